"""Woven cloth: energies by direction, fibres by triangle, and the isotropic sheet as a special case."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tatamu.simulation.material import Material, load_material
from tatamu.simulation.mesh.meshing import subdivided
from tatamu.simulation.native.elastic import curvature, membrane
from tatamu.simulation.scene import Cloth, Scene
from tatamu.simulation.simulators import capabilities
from tests.refusals import refusal
from tests.scenes import CLOTH
from tests.test_native_forces import Elastic, check_slopes, irregular, regular

WOVEN = CLOTH.model_copy(
    update={
        "stretch_stiffness": 900.0,
        "stretch_stiffness_weft": 500.0,
        "shear_stiffness": 30.0,
        "bending_rigidity_weft": 0.5 * CLOTH.bending_rigidity,
        "bending_rigidity_bias": 0.6 * CLOTH.bending_rigidity,
    }
)


def strained(angle: float) -> np.ndarray:
    """Green strain (xx, yy, 2 xy) of a stretch of 1 along a direction."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * c, s * s, 2 * c * s])


@pytest.mark.parametrize("angle", [0.0, 0.5, np.pi / 4, np.pi / 2])
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_the_energy_of_a_stretch_is_that_of_its_direction_to_the_fibres(angle: float, turn: float) -> None:
    fibre = np.array([[np.cos(turn), np.sin(turn), 0.0]])
    sheet = Elastic(irregular(), WOVEN, fibre)
    along = np.array([np.cos(angle + turn), np.sin(angle + turn), 0.0])
    small = 1e-4
    x = sheet.rest + small * np.outer(sheet.rest @ along, along)
    strain = strained(angle) * (small + small**2 / 2)
    area = 0.2 * 0.3
    wanted = 0.5 * area * strain @ membrane.plane_stress(WOVEN) @ strain
    assert sheet.membrane_energy(x) == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("angle", [0.0, 0.5, np.pi / 4, np.pi / 2])
def test_the_energy_of_a_cylinder_is_that_of_its_direction_to_the_fibres(angle: float) -> None:
    sheet = Elastic(regular(), WOVEN, np.array([[np.cos(0.3), np.sin(0.3), 0.0]]))
    along = sheet.rest[:, :2] @ [np.cos(angle + 0.3), np.sin(angle + 0.3)]
    k = 1e-3
    x = sheet.rest + np.outer(0.5 * k * along**2, [0.0, 0.0, 1.0])
    bent = strained(angle) * [1, 1, 0.5] * k
    wanted = 0.5 * 0.6 * 0.8 * bent @ curvature.rigidities(WOVEN) @ bent
    assert sheet.bending_energy(x) == pytest.approx(wanted, rel=0.06)  # borders bend less


def test_forces_are_minus_the_gradients_of_the_energies() -> None:
    sheet = Elastic(irregular(), WOVEN, np.array([[1.0, 0.4, 0.0]]))
    x = sheet.rest + np.random.default_rng(5).normal(0.0, 0.003, sheet.rest.shape)
    check_slopes(x, sheet.membrane_force(x), sheet.membrane_energy, 6, rel=1e-5)
    check_slopes(x, sheet.bending_force(x), sheet.bending_energy, 6, rel=1e-5)


def test_woven_cloth_that_is_alike_in_all_directions_is_the_isotropic_sheet() -> None:
    alike = CLOTH.model_copy(
        update={"shear_stiffness": CLOTH.shear_modulus, "bending_rigidity_bias": CLOTH.bending_rigidity}
    )
    np.testing.assert_allclose(membrane.plane_stress(alike), membrane.plane_stress(CLOTH))
    np.testing.assert_allclose(curvature.rigidities(alike), curvature.rigidities(CLOTH))
    sheet, plain = Elastic(irregular(), alike, np.array([[1.0, 0.7, 0.0]])), Elastic(irregular())
    np.testing.assert_allclose(sheet.S, plain.S, rtol=1e-6, atol=1e-6 * np.abs(plain.S).max())
    np.testing.assert_allclose(sheet.K, plain.K, rtol=1e-6, atol=1e-6 * np.abs(plain.K).max())


def test_the_warp_runs_along_x_and_along_y_where_a_triangle_lies_across_x() -> None:
    rest = np.array([[0, 0, 0], [0, 0.1, 0.1], [0, -0.1, 0.1], [0.1, 0, 0.05]])
    faces = np.array([[0, 1, 2], [0, 1, 3]])
    frames = membrane.along_fibres(membrane.rest_frames(rest, faces), rest, faces, None)
    assert frames[0, 1] - frames[0, 2] == pytest.approx([0.2, 0.0])
    normal = np.cross(rest[1], rest[3])
    level = np.array([1.0, 0, 0]) - normal[0] * normal / (normal @ normal)
    assert frames[1, 2, 0] == pytest.approx(rest[3] @ level / np.linalg.norm(level))


@pytest.mark.parametrize(
    ("fibre", "said"),
    [
        ([[1, 0, 0]] * 3, r"one vector, or one for each of 2 triangles, given 3"),
        ([[0, 0, 1]], "perpendicular to its triangle, given .* in triangle 0"),
    ],
)
def test_a_wrong_fibre_is_refused(fibre: list[list[float]], said: str) -> None:
    corners = [[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]]
    with pytest.raises(ValueError, match=said):
        Cloth(vertices=corners, faces=[[0, 1, 2], [0, 2, 3]], fibre=fibre)


def test_halved_triangles_keep_their_fibres() -> None:
    corners = [[0, 0, 0], [0.1, 0, 0], [0.1, 0.1, 0], [0, 0.1, 0]]
    cloth = Cloth(vertices=corners, faces=[[0, 1, 2], [0, 2, 3]], fibre=[[1, 0, 0], [0, 1, 0]])
    fine = subdivided(Scene(cloth=cloth, material=WOVEN, duration=0.1)).cloth
    centre = fine.vertices[fine.faces].mean(axis=1)
    assert fine.fibre is not None
    assert np.array_equal(fine.fibre[:, 0] == 1, centre[:, 0] > centre[:, 1])


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ("shear_stiffness = 30.0\ncompression = 0.5", "compression must be 1"),
        ("bending_rigidity_bias = 1e-6", "bending_rigidity_bias must be at least"),
        ("shear_stiffness = 0.0", "shear_stiffness"),
    ],
)
def test_a_wrong_material_is_refused_in_a_line(tmp_path: Path, fields: str, said: str) -> None:
    file = tmp_path / "wrong.toml"
    head = "[material]\nareal_density = 0.2\nstretch_stiffness = 300.0\nbending_rigidity = 1e-5\n"
    file.write_text(head + fields)
    assert re.search(said, refusal(load_material, file))


def test_only_native_knows_directions_and_the_others_say_so() -> None:
    woven = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-5, shear_stiffness=30.0)
    assert capabilities("native").lacking(woven) == []
    assert capabilities("blender").lacking(woven) == [
        "shear_stiffness: ignored, so the cloth is equally stiff in all directions"
    ]
    assert "shear_stiffness" in woven.model_dump() and "bending_rigidity_bias" not in woven.model_dump()
