"""Meshes of garments as worn on a body: turned onto their back, flattened, or refused with what to do."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from tatamu.base.errors import InputError
from tatamu.garments import Garment, load_garment, make_garment
from tatamu.garments.flattening import flattened, side_lengths
from tatamu.garments.meshfile import read_mesh
from tatamu.garments.panel import angles
from tatamu.garments.posture import posture
from tatamu.simulation.mesh.crossings import crossings
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.scene import Scene, Table
from tatamu.simulation.simulators import simulate
from tests.foreign import meshed, written
from tests.refusals import refusal
from tests.worn import flat_shirt, inflated, inflated_shirt, with_sleeves_down, worn_shirt_obj


def described(path: Path, *lines: str) -> Garment:
    (path.parent / "garment.toml").write_text("\n".join(["[garment]", f'mesh = "{path.name}"', *lines]) + "\n")
    return make_garment(str(path.parent / "garment.toml"))


def edge_change(garment: Garment, true: np.ndarray) -> float:
    """Median relative change of the sides of triangles against the true pattern (n, 2)."""
    assert garment.rest is not None
    made, wished = side_lengths(garment.rest[:, :2][garment.faces]), side_lengths(true[garment.faces])
    return float(np.median(np.abs(made / wished - 1.0)))


def test_a_worn_shirt_in_units_of_a_decimetre_is_refused_with_its_scale(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"give scale = 0\.1 under \[garment\] in a garment file, or --scale 0\.1"):
        make_garment(str(worn_shirt_obj(tmp_path)))


def test_a_worn_shirt_lies_flat_on_its_back_as_it_was_cut(tmp_path: Path) -> None:
    shirt = make_garment(str(worn_shirt_obj(tmp_path)), scale=0.1)
    thickness = shirt.material.thickness
    assert shirt.vertices[:, 2].max() == pytest.approx(1.5 * thickness)
    assert shirt.layers == 2
    assert shirt.size == pytest.approx((0.54, 0.46), rel=0.02)
    neck = shirt.vertices[shirt.edges["top opening"]]
    assert neck[:, 0].mean() > 0.1 and abs(neck[:, 1].mean()) < 0.01
    assert {"bottom", "left", "right"} <= set(shirt.openings)
    front = flat_shirt().vertices[:, 2] > thickness
    assert np.corrcoef(shirt.vertices[:, 2], front)[0, 1] > 0.9
    assert shirt.statement.endswith("read in decimetres (scale 0.1)")
    assert shirt.notes[0].startswith(
        "the garment is laid flat on its back, because the mesh is 170 mm deep; the axis from hem to top is y"
    )
    assert any(note.startswith("flattened by its own shape") for note in shirt.notes)


def test_what_was_flattened_lies_still(tmp_path: Path) -> None:
    shirt = make_garment(str(worn_shirt_obj(tmp_path)), scale=0.1)
    scene = Scene(cloth=shirt.cloth(), material=shirt.material, table=Table(), duration=0.3)
    positions = simulate(scene).positions
    assert np.linalg.norm(positions - positions[0], axis=2).max() < 2e-3
    assert crossings(positions[-1], shirt.faces) == 0


def test_what_was_flattened_can_be_meshed_anew_with_its_lower_neckline_in_front(tmp_path: Path) -> None:
    worn_shirt_obj(tmp_path, unit=1.0)
    shirt = described(tmp_path / "worn.obj", "remesh = true", "spacing = 0.016")
    assert shirt.rest is not None
    assert np.degrees(angles(shirt.rest, shirt.faces).min()) > 20.0
    assert shirt.size == pytest.approx((0.54, 0.46), rel=0.03)
    low, high = (shirt.vertices[shirt.edges[name], 0].min() for name in ("top opening", "back top opening"))
    assert high - low == pytest.approx(0.04, abs=0.01)  # the necklines of front and back
    assert {"bottom", "left", "right", "top opening", "back top opening"} == set(shirt.openings)


def test_a_uv_map_is_the_pattern(tmp_path: Path) -> None:
    path = worn_shirt_obj(tmp_path, unit=1.0, uv=True)
    shirt = make_garment(str(path))
    true = flat_shirt().vertices[:, :2]
    assert edge_change(shirt, true) < 0.004
    assert shirt.size == pytest.approx((0.54, 0.46), rel=0.005)
    assert any("its UV map, a pattern of 2 panels" in note for note in shirt.notes)
    by_shape = make_garment(str(worn_shirt_obj(tmp_path, unit=1.0, name="plain.obj")))
    assert edge_change(by_shape, true) < 0.02


def test_a_glb_is_welded_where_its_uv_map_is_cut_and_flattened_by_it(tmp_path: Path) -> None:
    mesh = read_mesh(worn_shirt_obj(tmp_path, unit=1.0, uv=True))
    assert mesh.uv is not None
    corners = np.column_stack([mesh.faces.reshape(-1), mesh.uv.reshape(-1, 2)])
    _, first, split = np.unique(corners, axis=0, return_index=True, return_inverse=True)
    image = trimesh.visual.TextureVisuals(
        uv=mesh.uv.reshape(-1, 2)[first], material=trimesh.visual.material.PBRMaterial()
    )
    vertices = mesh.vertices[mesh.faces.reshape(-1)[first]]
    trimesh.Trimesh(vertices, split.reshape(-1, 3), process=False, visual=image).export(tmp_path / "worn.glb")
    shirt = make_garment(str(tmp_path / "worn.glb"))
    assert shirt.size == pytest.approx((0.54, 0.46), rel=0.005)
    assert shirt.notes[0].endswith(f"vertices are welded into {len(flat_shirt().vertices)}")
    assert shirt.reading == "read in metres (as glTF has it)"


def test_a_uv_map_that_is_a_picture_is_no_pattern(tmp_path: Path) -> None:
    path = worn_shirt_obj(tmp_path, unit=1.0, uv=True)
    lines = path.read_bytes().decode("latin-1").splitlines()

    def bent(line: str) -> str:
        kind, *numbers = line.split()
        return f"vt {float(numbers[0]) ** 3} {numbers[1]}" if kind == "vt" else line

    stretched = [bent(line) for line in lines]
    path.write_text("\n".join(stretched))
    assert any("its UV map is no pattern" in note for note in make_garment(str(path)).notes)


def standing(kind: str) -> tuple[np.ndarray, np.ndarray]:
    """A worn T-shirt or pair of trousers, y up, front to +z."""
    garment = flat_shirt() if kind == "tshirt" else make_garment("trousers", spacing=0.02)
    x, y, z = (inflated_shirt() if kind == "tshirt" else inflated(garment)).T
    return np.column_stack([-y, x, z]), garment.faces


TURNS = {
    "y up": (np.eye(3), "y", "z"),
    "z up": (np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]]), "z", "-y"),
    "upside down": (np.diag([1.0, -1.0, -1.0]), "-y", "-z"),
    "facing x": (np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]), "y", "x"),
    "lying": (np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]), "x", "z"),
}


@pytest.mark.parametrize("turn", TURNS)
def test_front_and_top_of_a_shirt_are_found_however_it_stands(turn: str) -> None:
    points, faces = standing("tshirt")
    matrix, up, front = TURNS[turn]
    found = posture(points @ matrix.T, faces)
    assert (found.up, found.front) == (up, front)
    assert np.linalg.det(found.turn) == pytest.approx(1.0)
    assert (posture(points @ matrix.T, faces, up).turn == found.turn).all()


def test_a_shirt_that_leans_any_way_is_laid_down_too() -> None:
    points, faces = standing("tshirt")
    lean = Rotation.from_euler("xyz", [30, 40, 50], degrees=True).as_matrix()
    upright, leaning = posture(points, faces), posture(points @ lean.T, faces)
    assert np.degrees(np.arccos(np.clip((upright.turn @ lean.T * leaning.turn).sum(axis=1), -1, 1))).max() < 8.0


@pytest.mark.parametrize("turn", ["y up", "upside down"])
def test_trousers_stand_on_their_legs(turn: str) -> None:
    points, faces = standing("trousers")
    matrix, up, _ = TURNS[turn]
    assert posture(points @ matrix.T, faces).up == up


@pytest.mark.parametrize("degrees", [30, 50])
def test_sleeves_that_hang_are_flattened_with_the_rest(degrees: float, tmp_path: Path) -> None:
    points, faces = standing("tshirt")
    hanging = with_sleeves_down(points, flat_shirt(), degrees)
    shirt = make_garment(str(meshed(tmp_path, "shirt.ply", hanging, faces)))
    assert shirt.vertices[:, 2].max() < 0.002
    assert shirt.size == pytest.approx((0.54, 0.46), rel=0.01)
    assert edge_change(shirt, flat_shirt().vertices[:, :2]) < 0.01


def test_a_fine_mesh_is_flattened_in_seconds() -> None:
    points, faces = trimesh.remesh.subdivide(*standing("tshirt"))
    turn = posture(points, faces).turn
    placed = (points - points.mean(axis=0)) @ turn.T
    made = flattened(placed, faces, side_lengths(placed[faces]), np.zeros(len(faces), dtype=np.int64))
    assert len(points) > 7000
    assert made.wrong == 0 and made.median < 0.01


def test_normals_that_point_inwards_make_no_difference(tmp_path: Path) -> None:
    points, faces = standing("tshirt")
    paths = meshed(tmp_path, "out.ply", points, faces), meshed(tmp_path, "in.ply", points, faces[:, ::-1])
    out, inwards = (make_garment(str(path)) for path in paths)
    assert np.allclose(out.vertices, inwards.vertices, atol=1e-6)


def test_a_size_scales_what_was_flattened(tmp_path: Path) -> None:
    shirt = load_garment(worn_shirt_obj(tmp_path, unit=0.1), size=(0.88, 0.70))
    assert shirt.size == pytest.approx((0.88, 0.70))
    assert shirt.reading.endswith("scaled to that size")


def test_what_cannot_be_flattened_is_refused_above_a_stated_height(tmp_path: Path) -> None:
    trimesh.creation.icosphere(subdivisions=3, radius=0.15).export(tmp_path / "ball.ply")
    with pytest.raises(
        InputError, match=r"must be at most 40 mm high .*given \d+ mm; if the garment has the wrong orientation"
    ):
        make_garment(str(tmp_path / "ball.ply"))


@pytest.mark.parametrize(("up", "top"), [("x", 0), ("-x", 0), ("z", 2), ("-z", 2)])
def test_up_takes_any_axis_of_a_flat_mesh_too(up: str, top: int, tmp_path: Path) -> None:
    flat, faces = staggered_rectangle(0.3, 0.4, 0.03)
    placed = np.column_stack([flat[:, 1], flat[:, 2], flat[:, 0]]) if top == 2 else flat
    cloth = described(meshed(tmp_path, "cloth.ply", placed, faces), f'up = "{up}"')
    sign = -1.0 if up.startswith("-") else 1.0
    heights = sign * placed[:, top]
    assert np.corrcoef(cloth.vertices[:, 0], heights)[0, 1] > 0.999


def test_up_across_a_flat_mesh_is_refused(tmp_path: Path) -> None:
    path = meshed(tmp_path, "cloth.ply", *staggered_rectangle(0.3, 0.4, 0.03))
    assert "up: must be an axis in the plane of the mesh, given z" in refusal(described, path, 'up = "z"')


def test_comments_in_latin_1_are_no_matter(tmp_path: Path) -> None:
    flat, faces = staggered_rectangle(0.3, 0.4, 0.03)
    mesh = trimesh.Trimesh(flat, faces, process=False)
    for kind in ("obj", "ply", "stl_ascii"):
        data: Any = mesh.export(file_type=kind, **({"encoding": "ascii"} if kind == "ply" else {}))
        raw = data.encode() if isinstance(data, str) else data
        name = {"obj": b"# caf\xe9\n" + raw, "ply": raw.replace(b"end_header", b"comment caf\xe9\nend_header", 1)}
        text = name.get(kind, raw.replace(b"solid", b"solid caf\xe9", 1))
        path = tmp_path / f"cloth.{kind[:3]}"
        path.write_bytes(text)
        assert make_garment(str(path)).size == pytest.approx((0.4, 0.3), rel=1e-3)


def test_an_obj_may_count_backwards_and_have_faces_of_four_corners(tmp_path: Path) -> None:
    (tmp_path / "quad.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nf -4//1 -3//1 -2//1 -1//1\n")
    mesh = read_mesh(tmp_path / "quad.obj")
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]
    plane = written(tmp_path, "plane.obj", "v 0 0\nv 1 0\nv 0 1\nf 1 2 3\n")
    assert "line 1 is not valid in an OBJ file: 'v 0 0'" in refusal(read_mesh, plane)
    wrong = written(tmp_path, "wrong.obj", "v 0 0 0\nv 1 0 0\nf 1 2 7\n")
    assert "line 3 is not valid in an OBJ file: 'f 1 2 7'" in refusal(read_mesh, wrong)


def test_pieces_of_a_mesh_are_named_and_chosen(tmp_path: Path) -> None:
    flat, faces = staggered_rectangle(0.3, 0.4, 0.03)
    lines = []
    for name, shift in (("front", 0.0), ("button", 0.5)):
        size = 1.0 if name == "front" else 0.05
        lines += [f"o {name}", *("v {} {} {}".format(*(size * place + [shift, 0, 0])) for place in flat)]
        lines += ["f {} {} {}".format(*(face + 1 + (len(flat) if shift else 0))) for face in faces]
    (tmp_path / "shirt.obj").write_text("\n".join(lines))
    said = refusal(make_garment, str(tmp_path / "shirt.obj"))
    assert 'piece = "front" under [garment]' in said
    assert f'"button" ({len(flat)} vertices, 0.02 x 0.01 x 0.00 m)' in said
    assert described(tmp_path / "shirt.obj", 'piece = "front"', 'up = "x"').size == pytest.approx((0.3, 0.4))
