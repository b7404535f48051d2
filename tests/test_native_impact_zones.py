"""Rigid impact zones: what has passed through something is set back, and moves as one."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.simulation.material import Material
from tatamu.simulation.native.contact import impact_zones
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.geometry import closest_on_segments
from tatamu.simulation.native.simulation import Simulation
from tatamu.simulation.scene import Cloth, Scene

THICKNESS = 1e-3
CLOTH = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5, thickness=THICKNESS)
LOWER = np.array([[-0.02, -0.02, 0.0], [0.02, -0.02, 0.0], [0.0, 0.03, 0.0]])
"""A level triangle; vertices 0 to 2."""
UPPER = np.array([[0.0, 0.0, 0.0], [0.004, 0.01, 0.02], [-0.004, 0.01, 0.02]])
"""A triangle with one corner, vertex 3, over the middle of the lower one."""
CROSSING = np.array([[0.0, -0.04, 0.0], [0.0, 0.0, 0.0], [0.03, -0.03, 0.02]])
"""A triangle with one edge, vertices 3 and 4, across the front edge of the lower one."""


def simulation_of(upper: np.ndarray, height: float) -> Simulation:
    """The lower triangle, and another one that height over it."""
    vertices = np.concatenate([LOWER, upper + np.array([0.0, 0.0, height])])
    cloth = Cloth(vertices=vertices, faces=np.array([[0, 1, 2], [3, 4, 5]]))
    simulation = Simulation(Scene(cloth=cloth, material=CLOTH, duration=0.1))
    simulation.contact.vertex_face.triangle[:] = -1
    simulation.contact.counters.pairs = 0
    simulation.contact.counters.outer_step = 10
    return simulation


def above(height: float) -> Simulation:
    """Vertex 3 that height over the lower triangle, which is its partner."""
    simulation = simulation_of(UPPER, height)
    simulation.contact.vertex_face.triangle[3, 0] = 0
    simulation.contact.vertex_face.side[3, 0] = 1
    simulation.contact.activity.restless[3] = 10
    return simulation


def across(height: float) -> Simulation:
    """Edge (3, 4) that height over edge (0, 1), paired with it."""
    simulation = simulation_of(CROSSING, height)
    simulation.contact.edge_edge.pairs[0] = [3, 4, 0, 1]
    simulation.contact.edge_edge.wake[0] = 0.0
    simulation.contact.edge_edge.apart[0] = height
    simulation.contact.counters.pairs = 1
    simulation.contact.activity.restless[0] = 10
    return simulation


def held(simulation: Simulation, sunk: float) -> tuple[np.ndarray, np.ndarray, int]:
    """Positions at the start and after the upper triangle sank by that much, and the passes that it took."""
    start = simulation.system.state.positions.x
    x = start.copy()
    x[3:, 2] -= sunk
    passes = impact_zones.hold(
        Positions(x, start, x.copy()), simulation.mesh, simulation.contact, simulation.system.options
    )
    return start, x, passes


MADE = pytest.mark.parametrize(("make", "zone"), [(above, [0, 1, 2, 3]), (across, [0, 1, 3, 4])])


@MADE
def test_where_nothing_passed_nothing_is_moved(make: object, zone: list[int]) -> None:
    start, x, passes = held(make(THICKNESS), 0.9 * THICKNESS)  # type: ignore[operator]
    assert passes == 0
    assert (x[3:] == start[3:] - [0.0, 0.0, 0.9 * THICKNESS]).all() and (x[:3] == start[:3]).all()


@MADE
def test_what_passed_moves_as_one_from_where_it_was_with_its_momentum(make: object, zone: list[int]) -> None:
    simulation = make(THICKNESS)  # type: ignore[operator]
    start, x, passes = held(simulation, 1.5 * THICKNESS)
    moved = x[zone] - start[zone]
    assert passes == 1
    assert np.ptp(moved, axis=0) == pytest.approx(0.0, abs=1e-15)
    mass = simulation.model.mass[zone]
    upper = np.array(zone) > 2
    assert moved[0, 2] == pytest.approx(-1.5 * THICKNESS * mass[upper].sum() / mass.sum())
    outside = [v for v in range(6) if v not in zone]
    assert (
        x[outside] == (start - np.array([[0.0, 0.0, 1.5 * THICKNESS]]) * (np.arange(6) > 2)[:, None])[outside]
    ).all()


@MADE
def test_what_contact_has_not_pushed_hard_lately_is_not_looked_at(make: object, zone: list[int]) -> None:
    simulation = make(THICKNESS)  # type: ignore[operator]
    simulation.contact.activity.restless[:] = 9  # until the step before
    start, x, passes = held(simulation, 1.5 * THICKNESS)
    assert passes == 0 and (x[3:] == start[3:] - [0.0, 0.0, 1.5 * THICKNESS]).all()


@MADE
def test_vertices_of_a_zone_are_looked_at_in_the_steps_to_come(make: object, zone: list[int]) -> None:
    simulation = make(THICKNESS)  # type: ignore[operator]
    held(simulation, 1.5 * THICKNESS)
    assert (simulation.contact.activity.restless[zone] == 10 + simulation.options.contact.restless_steps).all()


@MADE
def test_a_zone_with_a_held_vertex_moves_as_the_hand_does(make: object, zone: list[int]) -> None:
    simulation = make(THICKNESS)  # type: ignore[operator]
    simulation.mesh.inverse_mass[zone[0]] = 0.0
    start, x, passes = held(simulation, 1.5 * THICKNESS)
    assert passes == 1 and (x[zone] == start[zone]).all()


@MADE
def test_what_hands_hold_on_both_sides_is_left_to_them(make: object, zone: list[int]) -> None:
    simulation = make(THICKNESS)  # type: ignore[operator]
    simulation.mesh.inverse_mass[[zone[0], 3]] = 0.0
    _, x, passes = held(simulation, 1.5 * THICKNESS)
    assert passes == 0 and x[3, 2] == pytest.approx(-0.5 * THICKNESS)


def test_zones_that_run_into_one_another_become_one() -> None:
    """A corner that has passed the lowest triangle is lifted, and then passes the corner that lies over it."""
    vertices = np.concatenate(
        [LOWER, LOWER + np.array([0.0, 0.0, THICKNESS]), LOWER + np.array([0.0, 0.0, 2 * THICKNESS])]
    )
    vertices[3:6] += [0.0, -0.002, 0.0]
    vertices[6:] += [0.0, -0.004, 0.0]
    cloth = Cloth(vertices=vertices, faces=np.arange(9).reshape(3, 3))
    simulation = Simulation(Scene(cloth=cloth, material=CLOTH, duration=0.1))
    vertex_face, counters = simulation.contact.vertex_face, simulation.contact.counters
    vertex_face.triangle[:] = -1
    counters.pairs = 0
    counters.outer_step = 10
    vertex_face.triangle[5, 0], vertex_face.side[5, 0] = 0, 1  # vertex 5 over the lowest triangle
    vertex_face.triangle[8, 0], vertex_face.side[8, 0] = 1, 1  # vertex 8 over the middle one
    simulation.contact.activity.restless[:] = 10
    start = simulation.system.state.positions.x
    x = start.copy()
    x[3:6, 2] -= 1.5 * THICKNESS
    x[6:, 2] -= 1.6 * THICKNESS
    positions = Positions(x, start, x.copy())
    assert impact_zones.hold(positions, simulation.mesh, simulation.contact, simulation.system.options) == 2
    moved = (x - start)[[0, 1, 2, 3, 4, 5, 8]]
    assert np.ptp(moved, axis=0) == pytest.approx(0.0, abs=1e-15)


def test_edges_that_approach_by_less_than_their_distance_have_not_passed() -> None:
    rng = np.random.default_rng(0)
    seen = set()
    for _ in range(2000):
        start = rng.normal(size=(4, 3))
        x = start + 0.6 * rng.normal(size=(4, 3))
        apart = closest_on_segments(start, 0, 1, 2, 3)[0]
        near = impact_zones._approach(x, start, 0, 1, 2, 3) < apart**2
        passed = impact_zones._edges_passed(x, start, 0, 1, 2, 3)
        assert not (near and passed)
        seen.add((bool(near), bool(passed)))
    assert len(seen) == 3
