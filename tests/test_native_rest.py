"""Cloth that all hands have let go keeps its place once it no longer moves, until a hand takes it."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from tatamu import HandTarget, Scene, Simulation, simulate
from tatamu.simulation import native
from tatamu.simulation.native import Options, RestOptions
from tests.scenes import CLOTH, held, scene, sheet

EDGE = np.array([0, 1, 2])
LAID = np.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.02], [0.02, 0.0, 0.0]])
"""A short way of the edge [m]."""


def laid(**changes: Any) -> Scene:
    """A sheet whose edge a hand lifts and lays down; it rests soon."""
    hand = held(EDGE, opens=0.3, times=[0.05, 0.15, 0.25], displacements=LAID)
    cloth = sheet(0.1, 0.1, 0.02, CLOTH.thickness / 2)
    return scene(**{"cloth": cloth, "grippers": [hand], "duration": 1.0, **changes})


def rests_from(made: Scene, options: Options | None = None) -> float:
    """The time of the last frame in which anything moved [s]."""
    rollout = native.simulate(made, options)
    moved = np.abs(np.diff(rollout.positions, axis=0)).max(axis=(1, 2)) > 0.0
    return float(rollout.times[1:][moved][-1])


def test_cloth_that_was_let_go_rests_where_it_would_have_stayed() -> None:
    made = laid()
    assert 0.3 < rests_from(made) < 0.8
    never = Options(rest=RestOptions(still=0.0))
    ends = [native.simulate(made, options).positions[-1] for options in (None, never)]
    assert np.linalg.norm(ends[0] - ends[1], axis=1).mean() < 1e-3


@pytest.mark.parametrize(
    "grippers",
    [
        [held(EDGE, opens=None, times=[0.0], displacements=[[0.0, 0.0, 0.0]])],
        [held(EDGE, opens=0.1, times=[0.0], displacements=[[0.0, 0.0, 0.0]]), held(EDGE, closes=0.95)],
        [],
    ],
)
def test_cloth_does_not_rest_while_a_hand_holds_it_or_will_take_it_or_where_none_ever_did(grippers: list) -> None:
    simulation = Simulation(laid(grippers=grippers))
    simulation.advance(0.9)
    assert not simulation.state().rest.reached


def test_a_run_in_steps_has_the_bytes_of_one_go_beyond_rest() -> None:
    made = laid()
    whole = simulate(made)
    simulation = Simulation(made)
    for frame in range(1, made.frames):
        simulation.advance(1.0 / made.frame_rate)
        assert simulation.positions.tobytes() == whole.positions[frame].tobytes(), f"frame {frame}"
    assert simulation.state().rest.reached and not simulation.velocities.any()


def test_a_hand_takes_cloth_that_rests() -> None:
    simulation = Simulation(laid(duration=2.0))
    simulation.advance(1.2)
    assert simulation.state().rest.reached
    resting = simulation.positions.copy()
    other = Simulation(laid(duration=2.0))
    other.restore(pickle.loads(pickle.dumps(simulation.state())))
    for each in (simulation, other):
        each.advance(0.3, [HandTarget([0.0, 0.0, 0.05], closed=True)])
    assert simulation.positions[EDGE, 2] == pytest.approx(resting[EDGE, 2] + 0.05, abs=1e-6)
    assert simulation.positions.tobytes() == other.positions.tobytes()
