"""GLB files come out as glTF places them, or are refused by the name of what they need."""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from tatamu.base.errors import InputError
from tatamu.garments import make_garment
from tatamu.garments.glbfile import parse_glb
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.mesh.topology import areas
from tests.refusals import refusal

VERTICES, FACES = staggered_rectangle(0.3, 0.4, 0.05)
KINDS = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}


class Glb:
    """A GLB file that is written piece by piece."""

    def __init__(self, vertices: np.ndarray = VERTICES, kind: str = "f4", **how: Any) -> None:
        self.header: dict[str, Any] = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}
        self.data = b""
        self.primitive: dict[str, Any] = {"attributes": {"POSITION": self.add(vertices, kind, **how)}}
        self.primitive["indices"] = self.add(FACES.reshape(-1, 1), "u2")
        self.header |= {
            "meshes": [{"primitives": [self.primitive]}],
            "nodes": [{"mesh": 0}],
            "scenes": [{"nodes": [0]}],
        }

    def view(self, array: np.ndarray, kind: str) -> int:
        self.data += b"\0" * (-len(self.data) % 4)
        rows = np.ascontiguousarray(array.astype(f"<{kind}"))
        self.header["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": rows.nbytes})
        self.data += rows.tobytes()
        return len(self.header["bufferViews"]) - 1

    def add(self, array: np.ndarray, kind: str, **how: Any) -> int:
        view = self.view(array, kind)
        shape = {"componentType": KINDS[kind], "count": len(array), "type": TYPES[array.shape[1]]}
        self.header["accessors"].append({"bufferView": view, **shape, **how})
        return len(self.header["accessors"]) - 1

    def bytes(self, **buffer: str) -> bytes:
        text = json.dumps({**self.header, "buffers": [{"byteLength": len(self.data), **buffer}]}).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        chunks = struct.pack("<2I", len(text), 0x4E4F534A) + text + struct.pack("<2I", len(data), 0x004E4942) + data
        return struct.pack("<3I", 0x46546C67, 2, 12 + len(chunks)) + chunks

    def extent(self) -> list[float]:
        mesh = parse_glb(self.bytes())
        assert areas(mesh.vertices, mesh.faces).sum() > 0.0
        return np.sort(np.ptp(mesh.vertices, axis=0))[1:].tolist()


SIZE = [0.3, 0.4]


def quantised(kind: str) -> Glb:
    """Normalised integers, which the node's scale and translation bring back."""
    top = np.iinfo(kind).max
    middle = VERTICES.mean(axis=0)
    made = Glb(np.round((VERTICES - middle) / 0.25 * top), kind, normalized=True)
    made.header["nodes"] = [{"mesh": 0, "scale": [0.25] * 3, "translation": middle.tolist()}]
    made.header["extensionsRequired"] = ["KHR_mesh_quantization"]
    return made


def skinned(scale: float, bound: bool) -> Glb:
    """A mesh in centimetres whose skeleton is a hundredth: the scale of the mesh's own node does not count."""
    made = Glb(VERTICES * (100.0 if bound else 1.0))
    count = len(VERTICES)
    made.header["nodes"] = [{"mesh": 0, "skin": 0, "scale": [scale] * 3}, {"scale": [2.0] * 3}]
    made.header["scenes"] = [{"nodes": [0, 1]}]
    made.header["skins"] = [{"joints": [1]}]
    if bound:
        inverse = np.diag([0.005, 0.005, 0.005, 1.0]).T.reshape(1, 16)
        made.header["skins"][0]["inverseBindMatrices"] = made.add(inverse, "f4")
        made.primitive["attributes"]["JOINTS_0"] = made.add(np.zeros((count, 4)), "u1")
        weights = np.tile([255, 0, 0, 0], (count, 1))
        made.primitive["attributes"]["WEIGHTS_0"] = made.add(weights, "u1", normalized=True)
    return made


def sparse() -> Glb:
    """All vertices are zero, but for those that are stored beside."""
    made = Glb()
    where, what = made.view(np.arange(len(VERTICES)), "u2"), made.view(VERTICES, "f4")
    accessor = made.header["accessors"][0]
    del accessor["bufferView"]
    accessor["sparse"] = {
        "count": len(VERTICES),
        "indices": {"bufferView": where, "componentType": 5123},
        "values": {"bufferView": what},
    }
    return made


def morphed() -> Glb:
    made = Glb(VERTICES * [0.5, 1, 1])
    made.primitive["targets"] = [{"POSITION": made.add(VERTICES * [1.0, 0, 0], "f4")}]
    made.header["meshes"][0]["weights"] = [0.5]
    return made


def nested() -> Glb:
    """The axes are turned by the outer node, and the scale of the inner one is undone."""
    made = Glb(VERTICES * 1000.0)
    inner = {"mesh": 0, "matrix": np.diag([1e-3, 1e-3, 1e-3, 1.0]).ravel().tolist()}
    outer = {"children": [1], "rotation": [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]}
    made.header |= {"nodes": [outer, inner], "scenes": [{"nodes": [0]}]}
    return made


def strided() -> Glb:
    """Vertices and another attribute in turn."""
    made = Glb(np.zeros((len(VERTICES), 3)))
    view = made.view(np.hstack([VERTICES, np.ones((len(VERTICES), 1))]), "f4")
    made.header["bufferViews"][view]["byteStride"] = 16
    made.header["accessors"][0]["bufferView"] = view
    return made


def unused_compression() -> Glb:
    made = Glb()
    made.header["extensionsUsed"] = ["KHR_draco_mesh_compression"]
    return made


WHOLE: dict[str, Callable[[], Glb]] = {
    "plain": Glb,
    "quantised to 8 bits": lambda: quantised("i1"),
    "quantised to 16 bits": lambda: quantised("i2"),
    "skin": lambda: skinned(0.01, bound=False),
    "skin with joints": lambda: skinned(0.01, bound=True),
    "sparse": sparse,
    "morph target": morphed,
    "nested nodes": nested,
    "interleaved": strided,
    "compression that is not required": unused_compression,
}


@pytest.mark.parametrize("kind", WHOLE)
def test_a_mesh_is_placed_as_gltf_says(kind: str, tmp_path: Path) -> None:
    made = WHOLE[kind]()
    assert made.extent() == pytest.approx(SIZE, rel=0.01 if "8 bits" in kind else 1e-4)


def test_a_mirrored_node_turns_its_triangles() -> None:
    made = Glb()
    made.header["nodes"] = [{"mesh": 0, "scale": [-1, 1, 1]}]
    plain, mirrored = parse_glb(Glb().bytes()), parse_glb(made.bytes())

    def up(mesh: Any) -> np.ndarray:
        a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
        return np.asarray(np.cross(b - a, c - a)[:, 2])

    assert (up(plain) > 0).all() and (up(mirrored) > 0).all()


@settings(max_examples=20, deadline=None)
@given(st.lists(st.sampled_from(["rotate", "scale", "move"]), max_size=5), st.integers(0, 2**31))
def test_rigid_nodes_change_no_length(kinds: list[str], seed: int) -> None:
    random = np.random.default_rng(seed)
    made, scale = Glb(), 1.0
    nodes: list[dict[str, Any]] = []
    for number, kind in enumerate(kinds):
        factor = float(random.uniform(0.5, 2.0)) if kind == "scale" else 1.0
        turn = random.normal(size=4)
        change = {
            "rotate": {"rotation": (turn / np.linalg.norm(turn)).tolist()},
            "scale": {"scale": [factor] * 3},
            "move": {"translation": random.normal(size=3).tolist()},
        }[kind]
        scale *= factor
        nodes.append({**change, "children": [number + 1]})
    made.header |= {"nodes": [*nodes, {"mesh": 0}], "scenes": [{"nodes": [0]}]}
    mesh = parse_glb(made.bytes())
    wanted = areas(VERTICES, FACES).sum() * scale**2
    assert areas(mesh.vertices, mesh.faces).sum() == pytest.approx(wanted, rel=1e-5)


@pytest.mark.parametrize("mode", [5, 6])
def test_strips_and_fans_are_triangles(mode: int) -> None:
    corners = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.4, 0], [0.3, 0.4, 0]])
    made = Glb(corners if mode == 5 else corners[[0, 1, 3, 2]])
    made.primitive.update(mode=mode, indices=made.add(np.arange(4).reshape(-1, 1), "u1"))
    mesh = parse_glb(made.bytes())
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    up = np.cross(b - a, c - a)[:, 2]
    assert len(up) == 2 and (up > 0).all() and up.sum() / 2 == pytest.approx(0.12)


REFUSED = {
    "KHR_draco_mesh_compression": "without compression",
    "EXT_meshopt_compression": "without compression",
    "VENDOR_curves": "without this extension",
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_a_file_requires_is_named(name: str, tmp_path: Path) -> None:
    made = Glb()
    made.header["extensionsRequired"] = ["KHR_materials_unlit", name]
    (tmp_path / "a.glb").write_bytes(made.bytes())
    with pytest.raises(InputError, match=f"must not use {name}, which cannot be read; export the file {REFUSED[name]}"):
        make_garment(str(tmp_path / "a.glb"))


def test_draco_without_a_copy_is_named_even_if_it_is_not_said_to_be_required() -> None:
    made = Glb()
    del made.header["accessors"][0]["bufferView"]
    made.primitive["extensions"] = {"KHR_draco_mesh_compression": {"bufferView": 0}}
    with pytest.raises(InputError, match="must not use KHR_draco_mesh_compression"):
        parse_glb(made.bytes())


def test_data_in_another_file_are_named() -> None:
    made = Glb()
    with pytest.raises(InputError, match="given vertices in another file"):
        parse_glb(made.bytes(uri="a.bin"))


@pytest.mark.parametrize("compressed", [False, True])
def test_data_in_another_buffer_are_not_taken_from_the_first_one(compressed: bool) -> None:
    """The first buffer is the file's; with meshopt the second one is empty."""
    made = Glb()
    view = made.header["bufferViews"][0]
    view["buffer"] = 1
    if compressed:
        view["extensions"] = {"EXT_meshopt_compression": {"buffer": 0}}
    words = "EXT_meshopt_compression.*without compression" if compressed else "given vertices in another file"
    with pytest.raises(InputError, match=words):
        parse_glb(made.bytes())


def test_instances_are_refused_although_the_file_does_not_require_them() -> None:
    """They may scale the mesh."""
    made = Glb()
    made.header["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {}}}
    with pytest.raises(InputError, match=r"must not use EXT_mesh_gpu_instancing.*without this extension"):
        parse_glb(made.bytes())


def test_rotations_that_would_scale_the_mesh_are_refused() -> None:
    made = Glb()
    made.header["nodes"][0]["rotation"] = [0.0, 0.0, 0.5, 0.5]
    with pytest.raises(ValueError, match="rotation must be a unit quaternion"):
        parse_glb(made.bytes())


def test_joints_outside_the_scene_are_named() -> None:
    made = skinned(0.01, bound=True)
    made.header["scenes"] = [{"nodes": [0]}]
    with pytest.raises(ValueError, match="a joint of a skin is not in the scene"):
        parse_glb(made.bytes())


def test_too_many_instances_are_counted_together() -> None:
    made = Glb()
    made.header |= {"nodes": [{"mesh": 0}] * 4_000, "scenes": [{"nodes": list(range(4_000))}]}
    with pytest.raises(InputError, match=r"at most 1200000 vertices and indices, given 1[0-9]{6}"):
        parse_glb(made.bytes())


def test_both_sides_of_a_cloth_are_named(tmp_path: Path) -> None:
    made = Glb()
    made.primitive["indices"] = made.add(np.vstack([FACES, FACES[:, ::-1]]).reshape(-1, 1), "u2")
    (tmp_path / "a.glb").write_bytes(made.bytes())
    with pytest.raises(InputError, match=f"{len(FACES)} triangles at the places of other triangles; export a single"):
        make_garment(str(tmp_path / "a.glb"))


@pytest.mark.parametrize(
    "names", [['shirt "L"', "C:\\new"], ["shirt", "shirt", "strap"], ["a  b\n\x1b[31m", "A c"], ["a", "A"]]
)
def test_the_advice_on_pieces_chooses_a_piece_whatever_the_names_are(names: list[str], tmp_path: Path) -> None:
    made = Glb()
    made.header["nodes"] = [{"mesh": 0, "name": name, "translation": [k, 0, 0]} for k, name in enumerate(names)]
    made.header["scenes"] = [{"nodes": list(range(len(names)))}]
    (tmp_path / "a.glb").write_bytes(made.bytes())
    said = refusal(make_garment, str(tmp_path / "a.glb"))
    advice = said.partition("choose one with ")[2].partition(" under [garment]")[0]
    (tmp_path / "a.toml").write_text(f'[garment]\nmesh = "a.glb"\n{advice}\n')
    assert make_garment(str(tmp_path / "a.toml")).size == pytest.approx((0.4, 0.3), rel=1e-4)


def test_textures_are_not_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A picture of a few kilobytes may unpack to gigabytes."""
    bomb = io.BytesIO()
    Image.new("1", (9_000, 9_000)).save(bomb, "PNG")
    made = Glb()
    picture = made.view(np.frombuffer(bomb.getvalue(), "u1"), "u1")
    made.header |= {
        "images": [{"bufferView": picture, "mimeType": "image/png"}] * 50,
        "textures": [{"source": k} for k in range(50)],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": k}}} for k in range(50)],
    }
    made.primitive["material"] = 0
    (tmp_path / "a.glb").write_bytes(made.bytes())
    monkeypatch.setattr(Image, "open", lambda *_: pytest.fail("a picture was opened"))
    assert make_garment(str(tmp_path / "a.glb")).size == pytest.approx((0.4, 0.3), rel=1e-3)
