"""Broken and hostile files: one clean line, in bounded time and memory, whatever the file contains."""

from __future__ import annotations

import io
import json
import os
import struct
import subprocess
import sys
import zipfile
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu.base.errors import InputError, one_line
from tatamu.base.files import MAX_TOML, foreign, read_json, read_npz, read_toml
from tatamu.garments import make_garment
from tatamu.garments.dxf import read_dxf
from tatamu.garments.meshfile import read_mesh
from tatamu.garments.photo import find_outline
from tatamu.garments.svg import read_svg
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tests.foreign import svg
from tests.refusals import refusal
from tests.test_garments_glb import FACES, Glb

READERS: dict[str, Callable[[Path], Any]] = {
    ".json": Scene.load,
    ".npz": Rollout.load,
    ".toml": lambda path: make_garment(str(path)),
    ".svg": read_svg,
    ".dxf": read_dxf,
    ".obj": read_mesh,
    ".ply": read_mesh,
    ".stl": read_mesh,
    ".glb": read_mesh,
    ".png": find_outline,
}
"""A reader of each kind of file."""


@pytest.mark.parametrize("kind", READERS)
def test_pipes_devices_and_folders_are_refused_at_once(kind: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / f"pipe{kind}")
    assert "a pipe or a device" in refusal(READERS[kind], tmp_path / f"pipe{kind}")
    (tmp_path / f"zero{kind}").symlink_to("/dev/zero")
    assert "a pipe or a device" in refusal(READERS[kind], tmp_path / f"zero{kind}")
    (tmp_path / f"folder{kind}").mkdir()
    assert "a folder" in refusal(READERS[kind], tmp_path / f"folder{kind}")


@pytest.mark.parametrize("kind", READERS)
def test_files_of_gigabytes_are_refused_before_they_are_read(kind: str, tmp_path: Path) -> None:
    path = tmp_path / f"large{kind}"
    with path.open("wb") as file:
        file.truncate(8 << 30)  # takes no space on the disk
    assert "must be at most" in refusal(READERS[kind], path)


def test_a_file_that_states_no_size_is_read_no_further_than_allowed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.toml"
    path.write_text("a = 1\n" + "#" * MAX_TOML)
    true = os.stat(path)
    monkeypatch.setattr(
        "tatamu.base.files.os.stat", lambda _: os.stat_result((true.st_mode, 0, 0, 0, 0, 0, 0, 0, 0, 0))
    )
    assert "must be at most 2 MiB" in refusal(read_toml, path)


def npz(path: Path, **arrays: np.ndarray) -> Path:
    np.savez_compressed(path, allow_pickle=True, **arrays)
    return path


def test_arrays_that_unpack_to_gigabytes_are_refused_by_their_headers(tmp_path: Path) -> None:
    path = tmp_path / "bomb.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        header = io.BytesIO()
        np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (1 << 18, 1)})
        for name in ("times", "positions"):
            archive.writestr(f"{name}.npy", header.getvalue() + bytes(8 << 18))
    assert "must contain arrays of at most 1 MiB" in refusal(read_npz, path, largest=1 << 20)
    assert set(read_npz(path, largest=1 << 23)) == {"times", "positions"}


def test_a_header_that_promises_more_than_there_is_is_refused(tmp_path: Path) -> None:
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (10**9,)})
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("times.npy", header.getvalue() + bytes(80))
    assert "does not have the size that its header states" in refusal(read_npz, tmp_path / "a.npz")


WHOLE: dict[str, Any] = {
    "times": np.zeros(1),
    "positions": np.zeros((1, 3, 3)),
    "faces": np.array([[0, 1, 2]]),
    "info": np.array("{}"),
}


@pytest.mark.parametrize(
    "changes",
    [
        {"times": np.array(["0"])},
        {"positions": np.zeros((1, 3, 3), dtype=complex)},
        {"positions": np.full((1, 3, 3), np.nan)},
        {"positions": np.zeros((2, 3, 3))},
        {"positions": np.zeros((1, 3, 2))},
        {"positions": np.array([{}], dtype=object)},
        {"faces": np.array([[0, 1, 3]])},
        {"faces": np.array([[-1, 1, 2]])},
        {"faces": np.array([[0.0, 1.0, 2.0]])},
        {"target": np.array("text")},
        {"info": np.array(3.0)},
        {"times": np.zeros(1, dtype=[("a", float)])},
    ],
)
def test_arrays_of_another_kind_are_no_rollout(changes: dict[str, Any], tmp_path: Path) -> None:
    npz(tmp_path / "r.npz", **{**WHOLE, **changes})
    assert "is not a rollout file" in refusal(Rollout.load, tmp_path / "r.npz")


def test_a_whole_rollout_is_read(tmp_path: Path) -> None:
    assert Rollout.load(npz(tmp_path / "r.npz", **WHOLE)).positions.shape == (1, 3, 3)


# what is quoted


@pytest.mark.parametrize("hidden", ["\x1b[2J", "\x00", "\x9b31m", "\u202e", "\u200b", "\x7f", "\ud800"])
def test_what_is_quoted_from_a_file_cannot_command_the_terminal(hidden: str) -> None:
    said = str(InputError(f"given 'a{hidden}b'\nand"))
    assert said.isprintable()
    assert hidden not in said and "'a\\" in said and said.endswith("b' and")


def test_long_quotations_keep_both_ends() -> None:
    said = one_line("start " + "x" * 10_000 + " end")
    assert len(said) < 2_000
    assert said.startswith("start ") and said.endswith(" end")


def test_names_in_files_are_escaped_too(tmp_path: Path) -> None:
    (tmp_path / "a.svg").write_text(svg('<rect width="300" height="400"/>'))
    (tmp_path / "a.toml").write_text('[garment]\noutline = "a.svg"\nname = "shirt\\u001b[2J"\nspacing = 0.05\n')
    assert make_garment(str(tmp_path / "a.toml")).statement.isprintable()
    ends = [(0, 0), (300, 0), (300, 400), (0, 0)]
    lines = [f"0\nLINE\n8\na\x1b[2Jb\n10\n{a}\n20\n{b}\n11\n{c}\n21\n{d}\n" for (a, b), (c, d) in pairwise(ends)]
    (tmp_path / "a.dxf").write_text(dxf(*lines))
    assert all(piece.name.isprintable() for piece in read_dxf(tmp_path / "a.dxf").pieces)


@pytest.mark.parametrize("error", [StopIteration(), RecursionError("deep"), KeyError("\x1b"), MemoryError()])
def test_whatever_a_library_raises_is_one_line(error: Exception) -> None:
    def read() -> None:
        with foreign(Path("a.dxf"), "a DXF file"):
            raise error

    assert refusal(read).startswith("a.dxf: is not a DXF file (")


def test_libraries_print_nothing_beside_the_line(tmp_path: Path) -> None:
    """Of an STL file whose normals are broken, trimesh logs a traceback, though its triangles are whole."""
    text = "solid\nfacet normal 0 0 -0.x\nouter loop\n"
    text += "".join(f"vertex {x} {y} 0\n" for x, y in ((0, 0), (0.3, 0), (0, 0.4))) + "endloop\nendfacet\nendsolid\n"
    (tmp_path / "a.stl").write_text(text)
    code = f"import sys; sys.argv = ['tatamu', 'show', 'a.stl', '--out', 'a.png']; {MAIN}"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


MAIN = "from tatamu.cli import main; main()"


@pytest.mark.parametrize(
    ("what", "code", "line"),
    [
        ("warnings.warn('beside', RuntimeWarning); raise InputError('a: b')", 2, "tatamu: a: b\n"),
        ("raise MemoryError", 2, "tatamu: not enough memory; give smaller files or a larger mesh spacing\n"),
    ],
)
def test_a_command_that_fails_prints_its_line_alone(what: str, code: int, line: str) -> None:
    program = (
        "import sys, warnings\nimport tatamu.cli as cli\nfrom tatamu.base.errors import InputError\n"
        f"def app(**_):\n    {what}\ncli.app = app\ncli.main()\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (code, line)


# scenes


def scene_with(**changes: Any) -> dict[str, Any]:
    cloth = {
        "vertices": [[0, 0, 0.02], [0, 0.02, 0.02], [0.02, 0, 0.02], [0.02, 0.02, 0.02]],
        "faces": [[0, 2, 1], [1, 2, 3]],
    }
    material = {"areal_density": 0.2, "stretch_stiffness": 300.0, "bending_rigidity": 1.5e-5}
    return {"cloth": {**cloth, **changes}, "material": material, "duration": 0.01}


@pytest.mark.parametrize("index", ["Infinity", "NaN", "1e300", "-1e300", "0.5", '"1"', "1" + 20 * "0"])
def test_indices_that_are_no_whole_numbers_are_one_line(index: str, tmp_path: Path) -> None:
    text = json.dumps(scene_with(faces=[["HERE", 2, 1], [1, 2, 3]])).replace('"HERE"', index)
    (tmp_path / "s.json").write_text(text)
    said = refusal(Scene.load, tmp_path / "s.json")
    assert "s.json: cloth.faces: must be a list of triples [i, j, k] of whole numbers" in said


def test_a_patch_whose_points_lie_on_a_conic_is_simulated() -> None:
    from tatamu.simulation.native.model import _build
    from tatamu.simulation.native.options import Options

    rest = [[0, 0, 0], [0, -0.02, 0], [0.02, 0, 0], [0.02, 0.02, 0]]
    scene = Scene.model_validate(scene_with(rest_vertices=rest))
    built = _build(scene.cloth, scene.material, Options())
    assert built is not None


# meshes


def ply(vertices: np.ndarray, faces: list[list[int]], form: str = "ascii") -> bytes:
    head = (
        f"ply\nformat {form} 1.0\ncomment made by hand\nelement vertex {len(vertices)}\nproperty float x\n"
        f"property float y\nproperty float z\nproperty uchar red\nelement face {len(faces)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    ).encode()
    if form == "ascii":
        rows = [" ".join(f"{value:.9g}" for value in (*vertex, 255)) for vertex in vertices]
        rows += [" ".join(map(str, [len(face), *face])) for face in faces]
        return head + "\n".join(rows).encode() + b"\n"
    order = "<" if "little" in form else ">"
    body = b"".join(struct.pack(f"{order}3fB", *vertex, 255) for vertex in vertices)
    return head + body + b"".join(struct.pack(f"{order}B{len(face)}i", len(face), *face) for face in faces)


ARROW = np.array([[0, 0, 0], [0.4, 0, 0], [0.4, 0.4, 0], [0.2, 0.1, 0], [0, 0.4, 0], [0.2, -0.2, 0]])


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_a_ply_of_any_form_may_mix_faces_and_have_concave_ones(form: str, tmp_path: Path) -> None:
    (tmp_path / "a.ply").write_bytes(ply(ARROW, [[0, 1, 2, 3, 4], [0, 5, 1]], form))
    mesh = read_mesh(tmp_path / "a.ply")
    a, b, c = (mesh.vertices[mesh.faces[:, k], :2] for k in range(3))
    areas = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    assert len(areas) == 4 and (areas > 0).all()
    assert areas.sum() == pytest.approx(0.16 - 0.06 + 0.04)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_a_ply_that_lies_is_one_line(form: str, tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    whole = ply(ARROW, [[0, 1, 2, 3, 4]], form)
    for changed, words in (
        (ply(ARROW, [[0, 1, 99999]], form), "uses a vertex outside 0 to 5"),
        (ply(ARROW, [[0, 1, -1]], form), "uses a vertex outside 0 to 5"),
        (ply(ARROW, [[0, 1]], form), "faces must have 3 to 2000 corners, given 2"),
        (ply(ARROW, [], form), "must contain triangles"),
        (whole.replace(b"vertex 6", b"vertex 6000000000"), "must have at most 600000 vertex elements"),
        (whole.replace(b"face 1", b"face 9"), "ends too early"),
        (whole.replace(b"float x", b"floot x"), "is not a mesh file"),
        (whole.replace(b"float x", b"float w"), "is not a mesh file"),
        (whole.replace(b"end_header", b"end_heather"), "does not begin with the header"),
    ):
        path.write_bytes(changed)
        assert words in refusal(read_mesh, path)


def glb(**changes: Any) -> bytes:
    """A whole file, some of whose header was changed."""
    made = Glb()
    made.header |= changes
    return made.bytes()


def test_a_small_glb_that_unpacks_to_anything_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.glb"
    path.write_bytes(glb())
    assert len(read_mesh(path).faces) == len(FACES)
    many = [{"componentType": 5126, "count": 10**10, "type": "VEC3"}] * 2
    shown = [{"mesh": 0}] * 9_000
    heavy = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}] * 1_000}]
    scenes = [{"nodes": list(range(len(shown)))}]
    heavy_scene = {"nodes": shown, "meshes": heavy, "scenes": scenes}
    for changes in ({"accessors": many}, heavy_scene, {"nodes": [{"mesh": 0}] * 20_000}):
        path.write_bytes(glb(**changes))
        assert "must have at most" in refusal(read_mesh, path)
    path.write_bytes(glb(meshes=[]))
    refusal(read_mesh, path)


def test_meshes_without_triangles_or_with_none_that_has_an_area_are_one_line(tmp_path: Path) -> None:
    head = bytes(80)
    for name, data, words in (
        ("empty.stl", head + struct.pack("<I", 0), "must contain triangles"),
        ("points.stl", head + struct.pack("<I12fH", 1, *[0.0] * 12, 0), "must contain triangles with an area"),
        ("nan.stl", head + struct.pack("<I12fH", 1, *[np.nan] * 12, 0), "must be finite"),
        ("far.obj", b"v 0 0 0\nv 1e300 0 0\nv 0 1e300 0\nf 1 2 3\n", "must be finite and lie within"),
        ("one.obj", b"v 0 0 0\nf 1 1 1\n", "each side must be from 0.05 to 5 m"),
        ("line.obj", b"f" + b" 1" * 60_000, "is not valid in an OBJ file"),
        ("crossed.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nv 2 3 0\nf 1 2 3 4 5\n", "touches or crosses itself"),
    ):
        (tmp_path / name).write_bytes(data)
        path = str(tmp_path / name)
        assert words in refusal(make_garment, path, scale=None)


# drawings


def test_an_svg_that_unpacks_to_anything_is_refused_at_once(tmp_path: Path) -> None:
    uses = "".join(f'<g id="g{k}">' + f'<use href="#g{k - 1}"/>' * 10 + "</g>" for k in range(1, 12))
    entities = "".join(f'<!ENTITY e{k} "&e{k - 1};&e{k - 1};">' for k in range(1, 30))
    shape = '<rect id="g0" width="1" height="1"/>'
    for text, words in (
        (svg(f"<defs>{shape}{uses}</defs><use href='#g11'/>"), "must have at most 50000 elements"),
        (svg('<g id="a"><use href="#a"/></g>'), "refers to itself"),
        (svg("<g>" * 5_000 + "</g>" * 5_000), "at most 100 deep"),
        (svg('<path d="M0 0' + " C 0 1 0 2 1 0" * 90_000 + '"/>'), "must have at most 500000 elements"),
        (f'<!DOCTYPE svg [<!ENTITY e0 "a">{entities}]><svg id="&e29;"/>', "XML entities that contain other entities"),
        (svg('<circle r="1e308"/>'), "coordinates must be finite and at most"),
        (svg('<path d="M 0 0 A 1e12 1e12 0 0 1 5 5 L 1e300 3 Z"/>'), "coordinates must be finite and at most"),
        (svg('<rect width="1" height="1"/>' * 5_001), "at most 5000 closed curves"),
    ):
        (tmp_path / "a.svg").write_text(text)
        assert words in refusal(read_svg, tmp_path / "a.svg")


def dxf(*entities: str, blocks: str = "") -> str:
    block = f"0\nSECTION\n2\nBLOCKS\n{blocks}0\nENDSEC\n" if blocks else ""
    return f"{block}0\nSECTION\n2\nENTITIES\n{''.join(entities)}0\nENDSEC\n0\nEOF\n"


def inserted(name: str, rows: int = 1) -> str:
    return f"0\nINSERT\n8\n0\n2\n{name}\n10\n0\n20\n0\n71\n{rows}\n45\n1.0\n"


def test_a_dxf_that_unpacks_to_anything_is_refused_at_once(tmp_path: Path) -> None:
    chain = "".join(
        f"0\nBLOCK\n8\n0\n2\nB{k}\n70\n0\n10\n0\n20\n0\n{inserted(f'B{k - 1}') * 10 if k else ''}"
        "0\nPOINT\n8\n0\n10\n1\n20\n1\n0\nENDBLK\n"
        for k in range(9)
    )
    circle = "0\nCIRCLE\n8\n0\n10\n0\n20\n0\n40\n{}\n"
    for text, words in (
        (dxf(inserted("B8"), blocks=chain), "must have at most 60000 elements"),
        (dxf(inserted("B0", 10**9), blocks=chain), "must have at most 60000 elements"),
        (dxf(circle.format("1e308")), "coordinates of a CIRCLE must be finite and at most"),
        (dxf(circle.format("5") * 10_001), "must have at most 10000 curves other than lines, given 10001"),
        ("0\nSECTION\n2\nHEADER\n9\n$", "is not a DXF file"),
    ):
        (tmp_path / "a.dxf").write_text(text)
        assert words in refusal(read_dxf, tmp_path / "a.dxf")


def test_an_outline_of_any_number_of_corners_is_refused_or_simplified(tmp_path: Path) -> None:
    """The library that simplifies outlines ends the process if too many corners stay."""
    comb = " ".join(f"L {k / 100} {0 if k % 2 else 390}" for k in range(3_000))
    stairs = " ".join(f"L {k / 10} {k / 100}" for k in range(3_000))
    (tmp_path / "a.svg").write_text(svg(f'<path d="M0 400 {comb} L 300 400 Z"/>'))
    assert "each curve must have at most 2000 corners" in refusal(make_garment, str(tmp_path / "a.svg"))
    (tmp_path / "a.svg").write_text(svg(f'<path d="M0 400 {stairs} L 300 400 Z"/>'))
    assert make_garment(str(tmp_path / "a.svg"), spacing=0.06).size == pytest.approx((0.3, 0.4), abs=1e-3)
    many = " ".join(f"{k},{k * k % 997}" for k in range(100_001))
    (tmp_path / "a.svg").write_text(svg(f'<polyline points="{many}"/>'))
    assert "each curve must have at most 100000 points" in refusal(read_svg, tmp_path / "a.svg")


def test_entities_are_counted_once(tmp_path: Path) -> None:
    entities = "".join(f'<!ENTITY e{k} "{"x" * 99}">' for k in range(30_000))
    (tmp_path / "a.svg").write_text(f"<!DOCTYPE svg [{entities}]>" + svg("<g>" + "&e9;" * 200_000 + "</g>"))
    assert "must have XML entities of at most 16 MiB" in refusal(read_svg, tmp_path / "a.svg")


def test_an_arc_that_is_far_too_large_for_a_garment_has_few_points(tmp_path: Path) -> None:
    (tmp_path / "a.dxf").write_text(dxf("0\nCIRCLE\n8\n0\n10\n0\n20\n0\n40\n1e8\n"))
    (piece,) = read_dxf(tmp_path / "a.dxf").pieces
    assert len(piece.curves[0].points) < 5_000


# photos


def test_a_picture_of_too_many_pixels_is_refused_by_its_header(tmp_path: Path) -> None:
    header = struct.pack("<2sIHHI", b"BM", 54, 0, 0, 54) + struct.pack(
        "<IiiHHIIiiII", 40, 12_000, 12_000, 1, 24, *[0] * 6
    )
    (tmp_path / "a.bmp").write_bytes(header)
    assert "at most 100 million pixels" in refusal(find_outline, tmp_path / "a.bmp")


def test_broken_json_of_any_kind_is_one_line(tmp_path: Path) -> None:
    for text in ("[" * 100_000, '{"a": 1' + "0" * 5_000 + "}", '{"a\\u001b": 1, "a\\u001b": 2}', ""):
        (tmp_path / "a.json").write_text(text)
        refusal(read_json, tmp_path / "a.json")


@pytest.mark.parametrize("value", ["NaN", "-Infinity", "1e999", "1" + "0" * 400, '"0.1"', "[]"])
def test_kept_verdicts_that_are_no_numbers_are_passed_over(value: str, tmp_path: Path) -> None:
    from tatamu.evaluation.draws import read_outcomes

    line = '{{"key": "{}", "mean_vertex_distance": {}, "mask_iou": 0.9}}\n'
    (tmp_path / "simulated.jsonl").write_text(
        line.format("wrong", value) + "[" * 9_999 + "\n" + line.format("right", 0.01)
    )
    memory = read_outcomes(tmp_path / "simulated.jsonl")
    assert memory.get("wrong") is None
    assert memory.get("right") is not None


def _gripper(vertices: object, closes: float = 0.0, opens: float = 1.0) -> dict[str, Any]:
    motion: dict[str, Any] = {"times": [0], "displacements": [[0, 0, 0]]}
    return {"vertices": vertices, "closes": closes, "opens": opens, **motion}


def _fan(count: int) -> dict[str, Any]:
    """Triangles around one vertex."""
    turn = 2 * np.pi * np.arange(count) / count
    rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    return {"vertices": [[0, 0, 0], *rim.tolist()], "faces": [[0, 1 + k, 1 + (k + 1) % count] for k in range(count)]}


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"grippers": [_gripper([*range(300_000), 7])]}, "vertices must not contain an index twice, given 7 twice"),
        (
            {"grippers": [_gripper([0], k, k + 1.5) for k in range(1_000)]},
            "must not hold the same vertex at the same time, given grippers 0 and 1",
        ),
        ({"cloth": _fan(2_000)}, "faces must have at most 1000 triangles at each vertex, given 2000 at vertex 0"),
        ({"grippers": [_gripper([0])] * 1_001}, "at most 1000 items"),
        ({"bodies": [{"shape": "sphere", "size": [1], "positions": [[0, 0, 9]]}] * 101}, "at most 100 items"),
    ],
    ids=["vertices", "times", "triangles", "grippers", "bodies"],
)
def test_scenes_of_any_number_of_hands_and_bodies_are_one_line(
    given: dict[str, Any], words: str, tmp_path: Path
) -> None:
    (tmp_path / "s.json").write_text(json.dumps({**scene_with(), **given}))
    assert words in refusal(Scene.load, tmp_path / "s.json")


def test_a_key_twice_among_many_is_found_at_once(tmp_path: Path) -> None:
    fields = ",".join([*(f'"f{k}":0' for k in range(9_000)), *['"g":0'] * 300_000])
    (tmp_path / "s.json").write_text("{" + fields + "}")
    assert "g: must not occur twice in the same object" in refusal(read_json, tmp_path / "s.json")
