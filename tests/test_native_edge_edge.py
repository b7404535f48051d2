"""Edges that are kept apart: which are pushed, which may sleep, and what wakes them."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.simulation.material import Material
from tatamu.simulation.native.contact import edge_edge
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.options import ContactOptions
from tatamu.simulation.native.simulation import Simulation
from tatamu.simulation.scene import Cloth, Scene

THICKNESS = 1e-3
CLOTH = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5, thickness=THICKNESS)
COUNT = edge_edge.MANY + 13
"""More pairs than are measured together, and no whole number of times as many."""
WANTED = ContactOptions().edge_gap * THICKNESS


def crossed(gaps: np.ndarray) -> np.ndarray:
    """Triangles, 10 cm from one another: the first edge of each crosses that of one so far above, shape (6 g, 3)."""
    lower = np.array([[-0.01, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, -0.02, 0.0]])
    upper = np.array([[0.0, -0.01, 0.0], [0.0, 0.01, 0.0], [0.02, 0.0, 0.0]])
    at = np.arange(len(gaps))[:, None, None] * [0.1, 0.0, 0.0]
    return np.concatenate([lower + at, upper + at + gaps[:, None, None] * [0.0, 0.0, 1.0]], axis=1).reshape(-1, 3)


def simulation_of(gap: float) -> Simulation:
    """Pairs of crossed edges, each so far apart."""
    vertices = crossed(np.full(COUNT, gap))
    cloth = Cloth(vertices=vertices, faces=np.arange(6 * COUNT).reshape(-1, 3))
    simulation = Simulation(Scene(cloth=cloth, material=CLOTH, duration=0.1))
    simulation.contact.edge_edge.pairs[:COUNT] = 6 * np.arange(COUNT)[:, None] + [0, 1, 3, 4]
    simulation.contact.edge_edge.wake[:COUNT] = 0.0
    simulation.contact.edge_edge.meets[:COUNT] = 0.0
    simulation.contact.counters.pairs = COUNT
    return simulation


def swept(simulation: Simulation, gaps: np.ndarray, restored: float = 1.0) -> tuple[np.ndarray, float]:
    """Gaps after a sweep that finds these, and the smallest that it found."""
    x = crossed(gaps)
    positions = Positions(x, simulation.system.state.positions.x, x.copy())
    options, step = simulation.system.options, simulation.sizes.outer_step
    smallest = edge_edge.sweep(positions, simulation.mesh, simulation.contact, options, step, restored)
    z = x[:, 2].reshape(COUNT, 2, 3)
    return z[:, 1, :2].mean(axis=1) - z[:, 0, :2].mean(axis=1), smallest


def test_only_edges_that_are_too_near_are_pushed() -> None:
    gaps = np.linspace(0.3, 1.2, COUNT)[np.random.default_rng(0).permutation(COUNT)] * THICKNESS
    after, smallest = swept(simulation_of(THICKNESS), gaps)
    assert after == pytest.approx(np.maximum(gaps, WANTED), abs=1e-12)
    assert smallest == pytest.approx(gaps.min())
    unmoved = gaps > WANTED
    assert 0 < unmoved.sum() < COUNT and (after[unmoved] == gaps[unmoved]).all()


def test_edges_that_have_passed_are_brought_back_to_the_side_they_came_from() -> None:
    after, smallest = swept(simulation_of(THICKNESS), np.full(COUNT, -0.4 * THICKNESS))
    assert after == pytest.approx(WANTED) and smallest == pytest.approx(-0.4 * THICKNESS)


def test_edges_that_are_far_enough_sleep_until_something_may_have_come_nearer() -> None:
    simulation, near = simulation_of(THICKNESS), np.full(COUNT, 0.5 * THICKNESS)
    swept(simulation, np.full(COUNT, THICKNESS))
    asleep, smallest = swept(simulation, near)
    assert asleep == pytest.approx(near) and smallest == WANTED
    simulation.contact.counters.travelled += THICKNESS - WANTED
    first = slice(0, 6 * 5)  # whatever moved far, only the pairs of which it is a part may be too near
    simulation.contact.motion.reach[first] += 0.5 * (THICKNESS - WANTED)
    after = swept(simulation, near)[0]
    assert after[:5] == pytest.approx(WANTED) and after[5:] == pytest.approx(near[5:])


def test_a_later_sweep_looks_only_at_what_was_moved() -> None:
    simulation, near = simulation_of(0.7 * THICKNESS), np.full(COUNT, 0.3 * THICKNESS)
    simulation.contact.counters.sweep = 6
    simulation.contact.activity.touched[:6] = 5
    simulation.contact.edge_edge.awake[:COUNT] = np.arange(COUNT)
    simulation.contact.counters.pairs_awake = COUNT
    after, _ = swept(simulation, near, restored=0.5)
    assert after[0] == pytest.approx(0.5 * WANTED) and after[1:] == pytest.approx(near[1:])
