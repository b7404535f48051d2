"""Vertices that are kept from triangles: pushed by masses, held by friction, followed as the cloth slides."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.simulation.material import Material
from tatamu.simulation.native.contact import vertex_face
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import PARTNERS
from tatamu.simulation.native.options import ContactOptions, Options
from tatamu.simulation.native.simulation import Simulation
from tatamu.simulation.scene import Cloth, Scene

THICKNESS, MU, STEP = 1e-3, 0.5, 1e-3
CLOTH = Material(
    areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5, thickness=THICKNESS, friction_cloth=MU
)
FLAT = np.array([[-0.03, 0.0, 0.0], [0.0, -0.03, 0.0], [0.0, 0.03, 0.0], [0.03, 0.0, 0.0]])
"""Two triangles with the edge x = 0 in common, vertices 0 to 3."""
CORNER = np.array([[0.0, 0.0, 0.0], [-0.004, 0.01, 0.02], [-0.012, 0.01, 0.02]])
"""A triangle that stands on a corner, vertex 4."""
AT = np.array([-0.008, 0.0, 0.0])
"""Where that is over the first triangle, at first."""


def simulation_of(sheet: np.ndarray = FLAT, options: Options | None = None) -> Simulation:
    """Two triangles, and a corner over the first of them, which is its only partner."""
    vertices = np.concatenate([sheet, CORNER + AT + np.array([0.0, 0.0, THICKNESS])])
    cloth = Cloth(vertices=vertices, faces=np.array([[0, 1, 2], [1, 3, 2], [4, 5, 6]]))
    simulation = Simulation(Scene(cloth=cloth, material=CLOTH, duration=0.1), options)
    partners = simulation.contact.vertex_face
    partners.triangle[:] = -1
    partners.triangle[4, 0] = 0
    partners.side[:] = 0
    partners.order[0] = 4
    simulation.contact.counters.ordered = 1
    simulation.contact.counters.sweep = 1
    return simulation


def swept(
    simulation: Simulation, height: float, at_start: float, slide: float = 0.0, restored: float = 1.0
) -> tuple[Positions, float]:
    """A sweep that finds the corner at some height over the sheet, where it came from another, after some slide."""
    start = simulation.system.state.positions.x.copy()
    start[4, 2] = at_start
    x = start.copy()
    x[4] += [slide, 0.0, height - at_start]
    positions = Positions(x, start, x.copy())
    options = simulation.system.options
    smallest = vertex_face.sweep(positions, simulation.mesh, simulation.contact, options, STEP, restored)
    return positions, smallest


def over(x: np.ndarray) -> np.ndarray:
    """From the point of the first triangle below the corner's place at first to the corner, shape (3,)."""
    b = (AT[0] + 0.03) / 0.03 / 2
    return np.asarray(x[4] - (1 - 2 * b) * x[0] - b * x[1] - b * x[2])


def test_a_vertex_too_near_is_pushed_to_a_thickness_and_momentum_stays() -> None:
    simulation = simulation_of()
    positions, smallest = swept(simulation, 0.6 * THICKNESS, THICKNESS)
    assert over(positions.x) == pytest.approx([0.0, 0.0, THICKNESS], abs=1e-12)
    assert smallest == pytest.approx(0.6 * THICKNESS)
    moved = positions.x - positions.predicted
    assert simulation.model.mass @ moved == pytest.approx(0.0, abs=1e-12 * np.abs(moved).max())
    assert moved[4, 2] > 0 > moved[0, 2]


def test_a_later_sweep_restores_a_part() -> None:
    simulation = simulation_of()
    simulation.contact.activity.touched[4] = 1
    simulation.contact.vertex_face.awake[0] = PARTNERS * 4
    simulation.contact.counters.partners_awake = 1
    positions, _ = swept(simulation, 0.2 * THICKNESS, THICKNESS, restored=0.5)
    assert over(positions.x)[2] == pytest.approx(0.5 * THICKNESS)


def test_a_later_sweep_passes_over_what_nothing_has_touched() -> None:
    simulation = simulation_of()
    simulation.contact.counters.sweep = 2
    positions, smallest = swept(simulation, 0.2 * THICKNESS, THICKNESS, restored=0.5)
    assert (positions.x == positions.predicted).all() and smallest == THICKNESS


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_vertex_that_passed_goes_back_to_the_side_where_it_started(side: float) -> None:
    positions, smallest = swept(simulation_of(), -0.3 * side * THICKNESS, side * THICKNESS)
    assert over(positions.x)[2] == pytest.approx(side * THICKNESS)
    assert smallest == pytest.approx(-0.3 * THICKNESS)


def test_what_was_too_near_at_the_start_clears_at_one_speed_and_recovers_at_another() -> None:
    options = ContactOptions()
    positions, _ = swept(simulation_of(), 0.2 * THICKNESS, 0.2 * THICKNESS)
    assert over(positions.x)[2] == pytest.approx(0.2 * THICKNESS + options.clearing_speed * STEP)
    velocity = over(positions.x - positions.predicted)[2] / STEP
    assert velocity == pytest.approx(options.recovery_speed)


def test_friction_holds_a_vertex_to_its_anchor_while_it_can() -> None:
    simulation = simulation_of()
    push = 0.4 * THICKNESS
    positions, _ = swept(simulation, THICKNESS - push, THICKNESS, slide=0.9 * MU * push)
    assert over(positions.x)[0] == pytest.approx(0.0, abs=1e-4 * THICKNESS)
    anchor = simulation.contact.vertex_face.anchor[4, 0]
    assert anchor @ FLAT[:3] == pytest.approx(AT)


def test_beyond_that_it_slides_by_the_rest_and_drags_its_anchor_along() -> None:
    simulation = simulation_of()
    push, slide = 0.4 * THICKNESS, THICKNESS
    positions, _ = swept(simulation, THICKNESS - push, THICKNESS, slide=slide)
    assert over(positions.x)[0] == pytest.approx(slide - MU * push, abs=1e-4 * THICKNESS)
    anchor = simulation.contact.vertex_face.anchor[4, 0] @ FLAT[:3]
    assert anchor[0] - AT[0] == pytest.approx(slide - 2 * MU * push)  # as far behind as the next step can hold


def test_what_is_held_on_both_sides_is_left_alone() -> None:
    simulation = simulation_of()
    simulation.mesh.inverse_mass[[1, 4]] = 0.0
    positions, _ = swept(simulation, 0.2 * THICKNESS, THICKNESS)
    assert (positions.x == positions.predicted).all()


def test_a_vertex_far_enough_sleeps_until_something_may_have_come_nearer() -> None:
    simulation = simulation_of()
    swept(simulation, 2.0 * THICKNESS, 2.0 * THICKNESS)
    asleep, _ = swept(simulation, 0.5 * THICKNESS, THICKNESS)
    assert (asleep.x == asleep.predicted).all()
    simulation.contact.counters.travelled += THICKNESS
    asleep, _ = swept(simulation, 0.5 * THICKNESS, THICKNESS)
    assert (asleep.x == asleep.predicted).all()  # something else moved that far
    simulation.contact.motion.reach[4] += THICKNESS
    awake, _ = swept(simulation, 0.5 * THICKNESS, THICKNESS)
    assert over(awake.x)[2] == pytest.approx(THICKNESS)


def test_a_partner_is_followed_to_the_triangle_beyond() -> None:
    simulation = simulation_of()
    swept(simulation, 0.5 * THICKNESS, THICKNESS, slide=0.012)
    assert simulation.contact.vertex_face.triangle[4].tolist() == [1, -1, -1]


def test_a_partner_is_not_followed_around_a_fold() -> None:
    folded = FLAT.copy()
    folded[3] = [0.03 * np.cos(2.1), 0.0, -0.03 * np.sin(2.1)]  # by 120 degrees
    simulation = simulation_of(folded)
    positions, _ = swept(simulation, -10 * THICKNESS, THICKNESS, slide=0.012)
    assert simulation.contact.vertex_face.triangle[4].tolist() == [0, -1, -1]
    assert (positions.x == positions.predicted).all()


def test_a_partner_is_not_followed_to_another_partner() -> None:
    simulation = simulation_of()
    simulation.contact.vertex_face.triangle[4, 1] = 1
    simulation.contact.vertex_face.wake[4, 1] = np.inf
    swept(simulation, 0.5 * THICKNESS, THICKNESS, slide=0.012)
    assert simulation.contact.vertex_face.triangle[4].tolist() == [0, 1, -1]


def test_what_is_pressed_calls_for_a_search_that_guards_its_edges() -> None:
    simulation = simulation_of()
    assert not simulation.contact.counters.newly_pressed
    swept(simulation, 0.5 * THICKNESS, THICKNESS)
    assert simulation.contact.counters.newly_pressed
    assert (simulation.contact.activity.pressed[[0, 1, 2, 4]] == ContactOptions().pressed_searches).all()
    assert simulation.contact.activity.pressed[3] == 0
