"""Rigid bodies of a scene under way that a controller leads: fingers that come, turn and go as it decides."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

from tatamu import BodyTarget, InputError, Scene, Simulation
from tatamu.simulation.body import Body
from tests.scenes import held, scene, sheet

TIMES = [0.0, 0.2]
PLACES = [[0.0, 0.0, 0.01], [0.0, 0.0, 0.05]]
TURNED = [[1.0, 0.0, 0.0, 0.0], [np.cos(0.25), np.sin(0.25), 0.0, 0.0]]


def lifted(moves: bool) -> Scene:
    """A sheet that is held at its ends, and a finger below it that lifts its middle and turns, or stays."""
    cloth = sheet(0.2, 0.1, 0.02, 0.03)
    ends = np.flatnonzero(np.abs(cloth.vertices[:, 0]) > 0.4 * np.ptp(cloth.vertices[:, 0]))
    motion: dict[str, Any] = {"times": TIMES, "positions": PLACES, "orientations": TURNED}
    if not moves:
        motion = {"positions": PLACES[:1]}
    finger = Body(shape="box", size=[0.005, 0.03, 0.005], **motion)
    return scene(cloth=cloth, grippers=[held(ends)], bodies=[finger], duration=0.3)


def lead(simulation: Simulation, until: float) -> None:
    """Lead the finger of a scene in which it stays along the motion of the other scene."""
    (body,) = lifted(True).bodies
    while simulation.time < until - 1e-9:
        positions, orientations = body.path(np.array([simulation.time + 1 / 60]))
        simulation.advance(1 / 60, bodies=[BodyTarget(positions[0], orientations[0])])


def test_a_finger_that_is_led_lifts_as_one_that_a_scene_moves() -> None:
    moved, led, idle = Simulation(lifted(True)), Simulation(lifted(False)), Simulation(lifted(False))
    moved.advance(0.3)
    idle.advance(0.3)
    lead(led, 0.2)
    led.advance(0.1)
    assert np.abs(led.positions - moved.positions).max() < 1e-4
    assert np.abs(moved.positions - idle.positions).max() > 0.01


def test_a_restored_state_leads_a_finger_to_the_same_bytes() -> None:
    simulation = Simulation(lifted(False))
    before = simulation.state()
    lead(simulation, 0.1)
    state = pickle.dumps(simulation.state())
    lead(simulation, 0.2)
    simulation.advance(0.05)
    wanted = simulation.positions.tobytes()
    for other in (simulation, Simulation(lifted(False))):
        other.restore(pickle.loads(state))
        lead(other, 0.2)
        other.advance(0.05)
        assert other.positions.tobytes() == wanted
    simulation.restore(before)
    simulation.advance(0.25)
    idle = Simulation(lifted(False))
    idle.advance(0.25)
    assert simulation.positions.tobytes() == idle.positions.tobytes() != wanted


@pytest.mark.parametrize(
    ("bodies", "message"),
    [
        ([], r"^bodies: must have one item for each of 1 bodies, given 0"),
        ([BodyTarget([0.0, np.nan, 0.0])], r"^bodies\[0\].position: must be 3 finite numbers \[m\]"),
        (
            [BodyTarget([0.0, 0.0, 3.0])],
            r"^bodies\[0\].position: must be reachable at up to 10 m/s, given a distance "
            "of 2.99 m in",
        ),
        ([BodyTarget(orientation=[1.0, 1.0, 0.0, 0.0])], r"^bodies\[0\].orientation: must be a unit quaternion"),
        (
            [BodyTarget(orientation=[0.0, 1.0, 0.0, 0.0])],
            r"^bodies\[0\].orientation: must be reachable at up to 50 rad/s",
        ),
        ([BodyTarget(orientation=[1.0])], r"^bodies\[0\].orientation: must be 4 finite numbers"),
    ],
)
def test_a_wrong_target_is_named_and_nothing_is_done(bodies: Any, message: str) -> None:
    simulation = Simulation(lifted(False))
    simulation.advance(0.05)
    before = pickle.dumps(simulation.state())
    with pytest.raises(InputError, match=message):
        simulation.advance(0.05, bodies=bodies)
    assert pickle.dumps(simulation.state()) == before
