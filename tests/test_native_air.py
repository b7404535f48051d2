"""Air around a sheet: energy, contact, and the same answer as before where there is none."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.plate_in_air import disc_added_mass, rectangle_added_mass, swinging_drag, turning_drag

from tatamu import simulate
from tatamu.simulation.material import DIRECTIONAL_AIR, Material
from tatamu.simulation.native.air import air_of, meet, resist, surface_of
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.scene import Cloth, Scene, Table
from tatamu.simulation.simulators import capabilities
from tests.physics.meshes import staggered
from tests.physics.scenes import on_incline

TRIANGLE = np.array([[0, 1, 2]])


def material(**air: float) -> Material:
    return Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=1e-4, **air)


def turned(corners: np.ndarray, angle: float) -> np.ndarray:
    """Turned about y."""
    sine, cosine = np.sin(angle), np.cos(angle)
    return corners @ np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])


def test_a_turning_normal_leaves_the_energy_of_cloth_and_air_as_it_was() -> None:
    """A plate is turned while nothing else acts on it: rho v^2 + m_a v_n^2 stays."""
    air = air_of(0.0, material(air_added_mass=0.1))
    surface = surface_of(3, 3, air)
    corners = np.eye(3)[:, [0, 2, 1]] * 0.1
    V = np.array([[0.7], [0.2], [-0.4]]) * np.ones((1, 3))
    energies = []
    for angle in np.linspace(0.0, 1.5, 4001):
        x = turned(corners, angle)
        meet(V, surface, air, Positions(x, x, x.copy()), TRIANGLE, np.arange(3), np.ones(3), 1e-3)
        along = surface.normals[:, 0] @ V[:, 0]
        energies.append(0.2 * V[:, 0] @ V[:, 0] + 0.1 * along**2)
    assert np.ptp(energies[1:]) < 1e-3 * energies[1]
    speeds = np.linalg.norm(V[:, 0])
    assert abs(speeds - np.linalg.norm([0.7, 0.2, -0.4])) > 0.01  # the cloth alone lost or won some


def test_what_turned_around_drags_by_the_way_since_then() -> None:
    air = air_of(0.0, material(air_drag_quadratic=0.5, air_drag_turning=0.4))
    surface = surface_of(3, 3, air)
    x = np.eye(3)[:, [0, 2, 1]] * 0.1
    normal = np.cross(x[1] - x[0], x[2] - x[0])
    normal /= np.linalg.norm(normal)
    surface.normals[:] = normal[:, None]

    def slowed(speed: float, step: float) -> float:
        V = speed * normal[:, None] * np.ones((1, 3))
        meet(V, surface, air, Positions(x, x, x.copy()), TRIANGLE, np.arange(3), np.ones(3), step)
        return float(normal @ V[:, 0])

    for speed, way, drag in ((1.0, 0.1, 0.4 / 0.1 ** (1 / 3)), (1.0, 0.9, 0.5), (-1.0, 0.2, 0.4 / 0.2 ** (1 / 3))):
        step = way - abs(surface.path[0]) * (speed * surface.path[0] > 0.0)
        assert slowed(speed, step) == pytest.approx(speed / (1.0 + step * drag / 0.2), rel=1e-6)
        assert surface.path[0] == pytest.approx(np.sign(speed) * way, rel=1e-6)


def test_forces_along_the_normal_move_cloth_and_air_and_others_the_cloth_alone() -> None:
    air = air_of(0.0, material(air_added_mass=0.1))
    surface = surface_of(1, 1, air)
    surface.normals[:, 0] = [0.0, 0.6, 0.8]
    surface.carried[0] = 1.0 / 3.0
    F = np.array([[3.0], [-1.0], [2.0]], dtype=np.float32)
    V = np.zeros((3, 1))
    resist(V, F, np.array([5.0]), surface, 0.1, 0.05, 0.0)
    got = V[:, 0] + 0.1 * 5.0 * F[:, 0] - [0.0, 0.0, 0.05]
    normal = surface.normals[:, 0]
    pushed = 0.1 * F[:, 0] - [0.0, 0.0, 0.05 / 5.0]
    assert np.linalg.solve(0.2 * (np.eye(3) + 0.5 * np.outer(normal, normal)), pushed) == pytest.approx(got, rel=1e-6)


@pytest.mark.parametrize(("tilt", "slides"), [(19.5, False), (20.5, True)])
def test_friction_is_that_of_the_cloth_whatever_air_it_carries(tilt: float, slides: bool) -> None:
    heavy = material(air_added_mass=0.2, friction_table=float(np.tan(np.radians(20.0))), thickness=1e-3)
    plan, faces = staggered(0.1, 0.1, 0.02)
    start = on_incline(plan, 0.5e-3, np.radians(tilt))
    cloth = Cloth(vertices=start, faces=faces, rest_vertices=np.column_stack([plan, 0 * plan[:, 0]]))
    rollout = simulate(Scene(cloth=cloth, material=heavy, table=Table(tilt=np.radians(tilt)), duration=0.5))
    moved = float(np.linalg.norm(rollout.positions[-1] - start, axis=1).max())
    assert (moved > 5e-3) == slides and (slides or moved < 1e-4)


def test_only_native_knows_such_air_and_the_others_say_so() -> None:
    blown = material(air_added_mass=0.1, air_drag_quadratic=1.0)
    assert capabilities("native").lacking(blown) == []
    assert capabilities("mujoco").lacking(blown) == [
        "air_drag_quadratic, air_added_mass: ignored, so air acts through air_drag only"
    ]
    assert capabilities("blender").lacking(material(air_drag=1.0)) == []


def test_a_material_speaks_of_air_by_direction_only_where_there_is_any() -> None:
    assert not set(material().model_dump()) & set(DIRECTIONAL_AIR)
    assert material(air_added_mass=0.1).model_dump()["air_added_mass"] == 0.1
    assert Material.model_validate(material(air_drag_normal=0.2).model_dump()).air_drag_normal == 0.2


def test_a_square_carries_more_than_its_inscribed_disc_and_less_than_the_disc_of_its_area() -> None:
    square = rectangle_added_mass(0.3, 0.3)
    assert disc_added_mass(0.15) * np.pi / 4 < square < disc_added_mass(0.3 / np.sqrt(np.pi))
    assert rectangle_added_mass(0.3, 30.0) == pytest.approx(np.pi / 4 * 1.2 * 0.3, rel=0.01)
    assert rectangle_added_mass(0.2, 0.5) == rectangle_added_mass(0.5, 0.2)


def test_a_plate_that_swings_wide_drags_as_in_a_steady_flow() -> None:
    assert swinging_drag(0.05, 0.3) > swinging_drag(0.1, 0.3) > swinging_drag(1e3, 0.3) == pytest.approx(0.702)


def test_a_stroke_loses_as_much_by_the_way_since_it_turned_as_by_grahams_coefficient() -> None:
    way = np.linspace(0.0, 0.1, 100_001)[1:]  # of a swing by 0.05 m
    squares = 0.1 * way - way**2
    lost = float((turning_drag(0.3) * way ** (-1 / 3) * squares).sum())
    assert lost == pytest.approx(swinging_drag(0.05, 0.3) * squares.sum(), rel=1e-4)
