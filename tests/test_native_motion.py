"""How far vertices have moved since the search: a bound on how much closer any two have come, and no more than that."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.simulation.material import Material
from tatamu.simulation.native.contact import broad_phase, motion
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactState, VertexMotion
from tatamu.simulation.native.simulation import Simulation
from tatamu.simulation.scene import Cloth, Scene
from tests.scenes import sheet, together

THICKNESS = 1e-3
CLOTH = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5, thickness=THICKNESS)
COUNT = 40
ALONG = np.array([1.0, 0.0, 0.0])


def contact_at(x: np.ndarray) -> ContactState:
    """Contact that was searched at positions x, and found something near."""
    simulation = Simulation(Scene(cloth=sheet(0.1, 0.1), material=CLOTH, duration=0.1))
    count = len(x)
    fresh = VertexMotion(np.zeros(count), np.zeros(count), np.zeros((count, 3)), np.zeros((count, 3)))
    contact = simulation.contact._replace(motion=fresh)
    contact.counters.ordered = 1
    motion.begin(x, contact)
    return contact


def followed(contact: ContactState, start: np.ndarray, x: np.ndarray) -> None:
    motion.follow(Positions(x, start, x.copy()), contact)


def distances(x: np.ndarray) -> np.ndarray:
    return np.linalg.norm(x[:, None] - x[None, :], axis=2)


def test_no_two_vertices_come_closer_than_their_paths_allow() -> None:
    """A random walk of legal positions, each with a prediction of its own, while all of it is carried away."""
    rng = np.random.default_rng(0)
    x = rng.normal(size=(COUNT, 3))
    contact = contact_at(x)
    before = distances(x)
    start = x
    for _ in range(20):
        start = start + 0.01 * rng.normal(size=x.shape) * rng.random((COUNT, 1)) ** 4 + 0.3 * ALONG
        predicted = start + 0.02 * rng.normal(size=x.shape) + 0.1 * ALONG
        followed(contact, start, predicted)
        reach = contact.motion.reach
        for now in (start, predicted):
            assert (before - distances(now) <= reach[:, None] + reach[None, :] + 1e-12).all()
        assert 2.0 * reach.max() <= contact.counters.travelled + 1e-12


def test_what_a_round_predicts_and_contact_puts_back_adds_to_no_path() -> None:
    x = np.random.default_rng(1).normal(size=(COUNT, 3))
    contact = contact_at(x)
    shaken = x.copy()
    shaken[3, 2] += 0.01
    for _ in range(100):
        followed(contact, x, shaken)
    assert contact.motion.reach[3] == pytest.approx(0.01, rel=0.1)
    assert np.delete(contact.motion.reach, 3).max() < 1e-3
    assert contact.counters.longest_path == 0.0


def test_a_cloth_carried_as_a_whole_goes_nowhere() -> None:
    x = np.random.default_rng(2).normal(size=(COUNT, 3))
    contact = contact_at(x)
    for step in range(1, 50):
        followed(contact, x + 0.1 * step * ALONG, x + (0.1 * step + 0.05) * ALONG)
    assert contact.counters.travelled == pytest.approx(0.0, abs=1e-9)
    assert not motion.worn_out(x + np.array([5.0, 0.0, 0.0]), contact, 1e-6)


def test_candidates_are_worn_out_when_two_vertices_have_moved_apart_by_the_limit_and_not_before() -> None:
    x = np.random.default_rng(3).normal(size=(COUNT, 3))
    contact = contact_at(x)
    limit = 0.01
    for moved in np.linspace(0.0, 2 * limit, 41):
        now = x.copy()
        now[7, 0] += moved
        followed(contact, now, now)
        assert motion.worn_out(now, contact, limit) == (moved >= limit)


def test_edges_that_come_under_pressure_are_paired_without_another_search() -> None:
    """Two flat sheets on one another: their inner edges are guarded once they are pressed."""
    lower = sheet(0.1, 0.1)
    upper = Cloth(vertices=lower.vertices + np.array([0.003, 0.002, 0.002]), faces=lower.faces)
    simulation = Simulation(Scene(cloth=together(lower, upper), material=CLOTH, duration=0.1))
    contact = simulation.contact
    positions = simulation.system.state.positions
    positions.start[:] = positions.x
    borders = contact.counters.pairs
    contact.activity.pressed[:] = 4
    contact.counters.newly_pressed = True
    contact.motion.searched_at[:] = positions.x + np.array([0.001, 0.0, 0.0])  # a mark that a search would overwrite
    options = simulation.system.options
    broad_phase.refresh(positions, simulation.mesh, contact, options, simulation.system.kernels)
    assert contact.counters.pairs > borders > 0 and not contact.counters.newly_pressed
    assert (contact.motion.searched_at != positions.x).any()

    def paired() -> set[frozenset[frozenset[int]]]:
        found = contact.edge_edge.pairs[: contact.counters.pairs].tolist()
        return {frozenset((frozenset(pair[:2]), frozenset(pair[2:]))) for pair in found}

    pairs = paired()
    assert len(pairs) == contact.counters.pairs  # none twice
    simulation.search()
    contact.activity.pressed[:] = 4
    simulation.search()
    assert paired() == pairs
