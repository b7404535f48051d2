"""Edges that are kept apart: which are pushed, which may sleep, and what wakes them."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.material import Material
from tatamu.scene import Cloth, Scene, Table
from tatamu.simulators.native.contact import edge_edge as pairs
from tatamu.simulators.native.simulator import _Run

THICKNESS = 1e-3
CLOTH = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5, thickness=THICKNESS)
COUNT = pairs.MANY + 13
"""More pairs than are measured together, and no whole number of times as many."""
WANTED = pairs.EDGE_GAP * THICKNESS


def crossed(gaps: np.ndarray) -> np.ndarray:
    """Triangles, 10 cm from one another: the first edge of each crosses that of one so far above, shape (6 g, 3)."""
    lower = np.array([[-0.01, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, -0.02, 0.0]])
    upper = np.array([[0.0, -0.01, 0.0], [0.0, 0.01, 0.0], [0.02, 0.0, 0.0]])
    at = np.arange(len(gaps))[:, None, None] * [0.1, 0.0, 0.0]
    return np.concatenate([lower + at, upper + at + gaps[:, None, None] * [0.0, 0.0, 1.0]], axis=1).reshape(-1, 3)


def run_of(gap: float) -> _Run:
    """Pairs of crossed edges, each so far apart."""
    vertices = crossed(np.full(COUNT, gap))
    cloth = Cloth(vertices=vertices, faces=np.arange(6 * COUNT).reshape(-1, 3))
    run = _Run(Scene(cloth=cloth, material=CLOTH, duration=0.1))
    run.lists.pairs[:COUNT] = 6 * np.arange(COUNT)[:, None] + [0, 1, 3, 4]
    run.lists.pair_wake[:COUNT] = 0.0
    run.lists.used[0] = COUNT
    return run


def swept(run: _Run, gaps: np.ndarray, keep: float = 1.0) -> tuple[np.ndarray, float]:
    """What is left of the gaps after a sweep that finds them so small, and the smallest that it found."""
    x, before = crossed(gaps), run.state.x
    smallest = pairs.sweep(x, before, x.copy(), run.mesh, run.lists, run.step, keep)
    z = x[:, 2].reshape(COUNT, 2, 3)
    return z[:, 1, :2].mean(axis=1) - z[:, 0, :2].mean(axis=1), smallest


def test_only_edges_that_are_too_near_are_pushed() -> None:
    gaps = np.linspace(0.3, 1.2, COUNT)[np.random.default_rng(0).permutation(COUNT)] * THICKNESS
    after, smallest = swept(run_of(THICKNESS), gaps)
    assert after == pytest.approx(np.maximum(gaps, WANTED), abs=1e-12)
    assert smallest == pytest.approx(gaps.min())
    unmoved = gaps > WANTED
    assert 0 < unmoved.sum() < COUNT and (after[unmoved] == gaps[unmoved]).all()


def test_edges_that_have_passed_are_brought_back_to_the_side_they_came_from() -> None:
    after, smallest = swept(run_of(THICKNESS), np.full(COUNT, -0.4 * THICKNESS))
    assert after == pytest.approx(WANTED) and smallest == pytest.approx(-0.4 * THICKNESS)


def test_edges_that_are_far_enough_sleep_until_something_may_have_come_nearer() -> None:
    run, near = run_of(THICKNESS), np.full(COUNT, 0.5 * THICKNESS)
    swept(run, np.full(COUNT, THICKNESS))
    asleep, smallest = swept(run, near)
    assert asleep == pytest.approx(near) and smallest == WANTED
    run.lists.travelled[0] += THICKNESS - WANTED
    assert swept(run, near)[0] == pytest.approx(WANTED)


def test_a_later_sweep_looks_only_at_what_was_moved() -> None:
    run, near = run_of(0.7 * THICKNESS), np.full(COUNT, 0.3 * THICKNESS)
    run.lists.sweeps[0] = 5
    run.lists.touched[:6] = 5
    after, _ = swept(run, near, keep=0.5)
    assert after[0] == pytest.approx(0.5 * WANTED) and after[1:] == pytest.approx(near[1:])


def test_what_contact_moves_counts_as_way_travelled() -> None:
    """A level sheet on the table: all of it falls alike, and only the table's correction is motion."""
    corners = np.array([[0.0, 0.0, 0.5], [20.0, 0.0, 0.5], [20.0, 20.0, 0.5], [0.0, 20.0, 0.5]]) * THICKNESS
    cloth = Cloth(vertices=corners, faces=np.array([[0, 1, 2], [0, 2, 3]]))
    run = _Run(Scene(cloth=cloth, material=CLOTH, table=Table(), duration=0.1))
    run.frames()
    fall = 0.5 * 9.81 * run.step**2
    assert run.lists.travelled[0] > run.number * fall
