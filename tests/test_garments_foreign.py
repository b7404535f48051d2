"""Outlines and meshes from elsewhere: eight go in and lie still, the broken ones are refused with the reason."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.garments import load_garment, make_garment
from tatamu.garments.drawing import distinct
from tatamu.garments.panel import angles
from tatamu.simulation.mesh.crossings import crossings
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.scene import Scene, Table
from tatamu.simulation.simulators import simulate
from tests.foreign import BROKEN, GOOD, meshed, svg, written
from tests.refusals import refusal

LAYERS = {"apron_svg": 1, "cloth_obj": 1, "disc_stl": 1}
OWN_MESH = ("cloth_obj", "bag_ply", "tube_glb")


@pytest.mark.parametrize("kind", GOOD)
def test_a_foreign_garment_goes_in_and_lies_still(kind: str, tmp_path: Path) -> None:
    path = GOOD[kind](tmp_path)
    garment = make_garment(str(path), spacing=None if kind in OWN_MESH else 0.02)
    assert garment.layers == LAYERS.get(kind, 2)
    rest = garment.vertices if garment.rest is None else garment.rest
    assert np.degrees(angles(rest, garment.faces).min()) > 25.0
    scene = Scene(cloth=garment.cloth(), material=garment.material, table=Table(), duration=0.3)
    positions = simulate(scene).positions
    assert np.linalg.norm(positions - positions[0], axis=2).max() < 2e-3
    assert crossings(positions[-1], garment.faces) == 0
    assert {"bottom", "top", "left", "right"} & set(garment.edges) or garment.openings


@pytest.mark.parametrize("kind", BROKEN)
def test_a_broken_one_is_refused_with_the_reason(kind: str, tmp_path: Path) -> None:
    make, words = BROKEN[kind]
    path = make(tmp_path)
    said = refusal(make_garment, str(path))
    assert words in said and said.startswith(str(path))


def test_a_drawing_lies_as_it_is_seen_with_its_hem_towards_negative_x(tmp_path: Path) -> None:
    shirt = make_garment(str(GOOD["tshirt_svg"](tmp_path)))
    assert shirt.size == pytest.approx((0.54, 0.46), abs=1e-5)
    assert shirt.vertices[shirt.edges["hem"], 0] == pytest.approx(-0.23, abs=1e-5)
    assert (shirt.vertices[shirt.edges["cuff_l"], 1] > 0.2).all()  # on the left of the picture
    assert set(shirt.openings) == {"hem", "neck", "cuff_l", "cuff_r"}


def test_points_in_the_garment_file_name_openings(tmp_path: Path) -> None:
    skirt = make_garment(str(GOOD["skirt_toml"](tmp_path)))
    waist, hem = (skirt.vertices[skirt.edges[name]] for name in ("waist", "hem"))
    assert np.ptp(waist[:, 1]) == pytest.approx(0.24, abs=1e-5)
    assert np.ptp(hem[:, 1]) == pytest.approx(0.40, abs=1e-5)
    assert waist[:, 0].mean() > 0 > hem[:, 0].mean()


def test_a_mesh_keeps_its_triangles_and_a_disc_is_meshed_anew(tmp_path: Path) -> None:
    cloth = make_garment(str(GOOD["cloth_obj"](tmp_path)))
    assert cloth.name == "tea towel"
    assert cloth.size == pytest.approx((0.3, 0.4))
    assert cloth.notes == ()
    mat = make_garment(str(GOOD["disc_stl"](tmp_path)))
    assert "72 vertices are welded into 25" in mat.notes
    assert len(mat.vertices) > 500


def test_a_mesh_has_its_own_spacing_unless_meshed_anew(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="remesh = true"):
        make_garment(str(GOOD["cloth_obj"](tmp_path)), spacing=0.02)


def test_a_sewn_mesh_hinges_where_front_and_back_meet(tmp_path: Path) -> None:
    bag = make_garment(str(GOOD["bag_ply"](tmp_path)))
    lengths = np.linalg.norm(np.diff(bag.vertices[bag.seams, :2], axis=1), axis=2)
    assert lengths.sum() == pytest.approx(2 * 0.30 + 0.25, rel=1e-3)
    assert len(bag.openings) == 1


def test_a_coarse_mesh_says_so(tmp_path: Path) -> None:
    GOOD["disc_stl"](tmp_path)
    plain = make_garment(str(written(tmp_path, "plain.toml", '[garment]\nmesh = "mat.stl"\n')))
    assert any("bending lengths" in note for note in plain.notes)


def test_a_worn_garment_is_laid_flat_and_says_so(tmp_path: Path) -> None:
    tube = make_garment(str(GOOD["tube_glb"](tmp_path)))
    assert tube.notes[0].startswith("the garment is laid flat")
    assert tube.vertices[:, 2].max() < 0.025 < 0.1  # it was 0.1 m deep
    assert tube.size[0] > 0.235  # half of its circumference, 0.52 m, less what its sides round off
    assert tube.rest is not None
    assert np.ptp(tube.rest[:, 2]) == 0.0  # it was cut from flat cloth
    assert tube.size == pytest.approx((0.5 * 0.519, 0.308), rel=0.01)  # as the tube unrolled


def test_options_go_before_what_the_file_says(tmp_path: Path) -> None:
    path = GOOD["skirt_toml"](tmp_path)
    skirt = load_garment(path, size=(0.3, 0.25), spacing=0.02)
    assert skirt.size == pytest.approx((0.3, 0.25))
    assert skirt.spacing == 0.02


def test_a_hole_stays_open(tmp_path: Path) -> None:
    square = svg('<path d="M0 0H400V400H0Z M150 150H250V250H150Z"/>', 400, 400)
    poncho = make_garment(str(written(tmp_path, "poncho.svg", square)))
    inside = (np.abs(poncho.vertices[poncho.faces].mean(axis=1)[:, :2]) < 0.045).all(axis=1)
    assert not inside.any()
    assert "hole 1" in poncho.openings


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('[garment]\nname = "x"\n', "must have either outline or mesh, given neither"),
        ('[garment]\noutline = "shirt.svg"\nfabric = "silk"\n', "fabric must be one of"),
        ('[garment]\noutline = "shirt.svg"\nlayer = 2\n', "layer"),
        ('[garment]\noutline = "shirt.svg"\nopenings = ["collar"]\n', "given 'collar'"),
        ('[garment]\noutline = "shirt.svg"\nopenings = {hem = [[0, 0], [900, 900]]}\n', "hem must begin and end on"),
        ('[garment]\noutline = "shirt.svg"\nlayers = 2\nopenings = []\n', "given none"),
        ('[garment]\noutline = "none.svg"\n', "cannot be read"),
        ('[garment]\noutline = "shirt.svg"\nscale = 1.0\n', "give scale"),
        ('outline = "shirt.svg"\n', "garment: "),
    ],
)
def test_a_wrong_garment_file_is_one_clear_line(text: str, words: str, tmp_path: Path) -> None:
    GOOD["tshirt_svg"](tmp_path)
    said = refusal(make_garment, str(written(tmp_path, "wrong.toml", text)))
    assert words in said and str(tmp_path) in said


@pytest.mark.parametrize("name", ["x.svg", "x.dxf", "x.obj", "x.glb", "x.stl", "x.ply", "x.toml"])
def test_rubbish_and_missing_files_are_refused(name: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        make_garment(str(tmp_path / name))
    (tmp_path / name).write_bytes(b"\x00\xff rubbish <")
    with pytest.raises(InputError):
        make_garment(str(tmp_path / name))


@pytest.mark.parametrize("across", [0, 1])
def test_a_mesh_that_stands_upright_lies_down_with_its_top_away_from_the_hem(across: int, tmp_path: Path) -> None:
    flat, faces = staggered_rectangle(0.3, 0.4, 0.03)
    standing = np.insert(flat[:, [1, 0]], across, 0.0, axis=1)
    garment = make_garment(str(meshed(tmp_path, "standing.obj", standing, faces)))
    assert garment.size == pytest.approx((0.3, 0.4))
    assert np.argmax(garment.vertices[:, 0]) in np.flatnonzero(standing[:, 2] > 0.19)


@pytest.mark.parametrize(("size", "side"), [((100.0, 100.0), "width"), ((0.3, 0.01), "length")])
def test_a_mesh_is_not_scaled_to_a_size_that_no_garment_has(
    size: tuple[float, float], side: str, tmp_path: Path
) -> None:
    towel = make_garment("towel", size=(0.3, 0.5))
    path = meshed(tmp_path, "flat.obj", towel.vertices, towel.faces)
    assert f"size: {side} must be from 0.05 to 5 m" in refusal(make_garment, str(path), size=size)


def test_numbered_names_are_different_whatever_the_author_numbered() -> None:
    assert distinct(["a", "a", "b"]) == ["a", "a 2", "b"]
    assert len(set(distinct(["a", "a", "a 2", "a"]))) == 4
