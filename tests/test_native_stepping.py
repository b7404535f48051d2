"""A simulation that is advanced in steps: the bytes of one go, hands that are led, states that are kept."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import tatamu
from tatamu import HandTarget, InputError, Scene, Simulation, SimulationError, simulate
from tests.scenes import CLOTH, held, scene, sheet

EDGE = np.array([0, 1, 2])
OVER = np.array([[0.0, 0.0, 0.0], [0.05, 0.0, 0.05], [0.1, 0.0, 0.004]])
"""A way of the edge onto the sheet [m]."""
RICH = CLOTH.model_copy(
    update={"bending_hysteresis": 1e-5, "air_drag_normal": 0.05, "air_added_mass": 0.05, "air_drag_quadratic": 0.5}
)
"""A material with all that a simulation remembers."""


def folded(**changes: Any) -> Scene:
    """A sheet whose edge a hand lays onto it; the hand opens between two frames."""
    hand = held(EDGE, opens=0.443, times=[0.05, 0.2, 0.4], displacements=OVER)
    cloth = sheet(0.2, 0.1, 0.02, CLOTH.thickness / 2)
    return scene(**{"cloth": cloth, "material": RICH, "grippers": [hand], "duration": 0.7, **changes})


def led() -> Scene:
    """The same sheet with two grippers that do nothing of themselves."""
    idle = [held(np.array([number]), closes=100.0) for number in (0, 1)]
    return folded(grippers=idle)


def test_a_run_in_steps_has_the_bytes_of_one_go() -> None:
    made = folded()
    whole = simulate(made)
    simulation = Simulation(made)
    for frame in range(1, made.frames):
        simulation.advance(1.0 / made.frame_rate)
        assert simulation.positions.tobytes() == whole.positions[frame].tobytes(), f"frame {frame}"
    uneven = Simulation(made)
    for seconds in [0.0013, 0.3, 0.0987, 0.2, 0.1]:
        uneven.advance(seconds)
    assert uneven.time == pytest.approx(0.7, abs=1e-9)
    assert uneven.positions.tobytes() == whole.positions[-1].tobytes()


def test_nothing_is_lost_when_time_is_requested_in_pieces_that_are_no_whole_steps() -> None:
    simulation = Simulation(folded())
    for _ in range(100):
        simulation.advance(0.005)
    assert simulation.time == pytest.approx(0.5, abs=0.5 * simulation.sizes.outer_step)


def test_a_run_ends_with_its_scene_and_says_so() -> None:
    made = folded(duration=0.516666667)  # a little beyond its last frame
    simulation = Simulation(made)
    for _ in range(31):
        assert not simulation.done
        simulation.advance(1.0 / 60.0)
    assert simulation.done
    assert simulation.positions.tobytes() == simulate(made).positions[-1].tobytes()
    with pytest.raises(InputError, match=r"^seconds: the scene has already ended at 0\.516667 s"):
        simulation.advance(0.1)
    other = Simulation(made)
    other.advance(100.0)
    assert other.done and other.number == simulation.number


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda each: pickle.loads(pickle.dumps(each))])
def test_a_copy_goes_on_as_the_original_and_leaves_it_alone(copied: Callable[[Simulation], Simulation]) -> None:
    simulation = Simulation(led())
    targets = [HandTarget(displacement=(0.01, 0.0, 0.02), closed=True), None]
    simulation.advance(0.2, hands=targets)
    before = simulation.positions.tobytes()
    other = copied(simulation)
    for _ in range(3):
        other.advance(0.05, hands=[HandTarget(displacement=(0.02, 0.0, 0.02)), None])
    assert simulation.positions.tobytes() == before
    for _ in range(3):
        simulation.advance(0.05, hands=[HandTarget(displacement=(0.02, 0.0, 0.02)), None])
    assert other.positions.tobytes() == simulation.positions.tobytes() != before


CONTINUE = """
import pickle, sys
from tatamu import Scene, Simulation
simulation = Simulation(Scene.load(sys.argv[1]))
with open(sys.argv[2], "rb") as file:
    simulation.restore(pickle.load(file))
simulation.advance(0.3)
sys.stdout.buffer.write(simulation.positions.tobytes() + simulation.velocities.tobytes())
"""


def test_a_restored_state_continues_to_the_same_bytes_here_and_in_another_process(tmp_path: Path) -> None:
    made = folded()
    made.save(tmp_path / "scene.json")
    simulation = Simulation(made)
    simulation.advance(0.35, [HandTarget([0.05, 0.0, 0.03])])  # its hand holds, and is led
    (tmp_path / "state").write_bytes(pickle.dumps(simulation.state()))
    simulation.advance(0.3)
    wanted = simulation.positions.tobytes() + simulation.velocities.tobytes()
    simulation.advance(0.04, [HandTarget(closed=False)])
    simulation.restore(pickle.loads((tmp_path / "state").read_bytes()))
    simulation.advance(0.3)
    assert simulation.positions.tobytes() + simulation.velocities.tobytes() == wanted
    command = [sys.executable, "-c", CONTINUE, str(tmp_path / "scene.json"), str(tmp_path / "state")]
    assert subprocess.check_output(command) == wanted


def arrays(record: Any) -> Iterator[np.ndarray]:
    """All arrays of a record and of the records in it."""
    for part in record:
        if hasattr(part, "_fields"):
            yield from arrays(part)
        elif isinstance(part, np.ndarray):
            yield part


def test_a_state_holds_everything_that_the_rest_depends_on() -> None:
    made = folded(material=RICH.model_copy(update={"bending_rigidity": 1e-6}))
    simulation, other = Simulation(made), Simulation(made)
    kept = {id(other.system.state.slot), id(other.system.state.F)}  # constant; zero between steps
    for _ in range(14):
        for array in arrays((other.system.state, other.contact)):
            if id(array) not in kept:
                array.fill(3)
        other.restore(pickle.loads(pickle.dumps(simulation.state())))
        simulation.advance(0.05)
        other.advance(0.05)
        assert other.positions.tobytes() == simulation.positions.tobytes(), simulation.time
    assert not simulation.system.state.F.any()


def test_a_state_before_the_first_target_returns_hands_to_the_motion_of_the_scene() -> None:
    made = folded()
    simulation = Simulation(made)
    start = simulation.state()
    simulation.advance(0.2, [HandTarget([0.0, 0.0, 0.1])])
    simulation.restore(start)
    simulation.advance(made.duration)
    assert simulation.positions.tobytes() == simulate(made).positions[-1].tobytes()


def test_targets_lead_a_hand_as_the_same_motion_in_a_scene_does() -> None:
    whole = simulate(folded())
    simulation = Simulation(folded(grippers=[held(EDGE, closes=100.0)]))
    simulation.advance(0.05, [HandTarget(closed=True)])
    simulation.advance(0.15, [HandTarget(OVER[1])])
    assert simulation.displacements[0] == pytest.approx(OVER[1])
    assert simulation.positions[EDGE] - whole.positions[0, EDGE] == pytest.approx(np.tile(OVER[1], (3, 1)), abs=1e-9)
    assert simulation.velocities[EDGE] == pytest.approx(np.tile(OVER[1] / 0.15, (3, 1)), abs=1e-6)
    simulation.advance(0.2, [HandTarget(OVER[2])])
    assert simulation.positions == pytest.approx(whole.positions[24], abs=1e-5)
    simulation.advance(0.05)  # without a target it stays
    assert simulation.displacements[0] == pytest.approx(OVER[2]) and simulation.closed == (True,)
    simulation.advance(0.05, [HandTarget(closed=False)])
    assert simulation.closed == (False,) and not simulation.displacements.any()
    assert np.abs(simulation.velocities[EDGE]).max() > 0.01


def test_a_hand_takes_other_vertices_where_it_closes_again() -> None:
    simulation = Simulation(led())
    simulation.advance(0.1, [HandTarget([0.0, 0.0, 0.02], True, EDGE), None])
    simulation.advance(0.1, [HandTarget(closed=False), None])
    before = simulation.positions[5].copy()
    simulation.advance(0.1, [HandTarget([0.0, 0.0, 0.01], True, [5]), HandTarget(closed=True, vertices=[0])])
    assert simulation.positions[5] == pytest.approx(before + np.array([0.0, 0.0, 0.01]), abs=1e-9)
    assert simulation.closed == (True, True)


NAN = float("nan")
WORD: Any = "up"
PART: Any = [0.5]


@pytest.mark.parametrize(
    ("seconds", "hands", "message"),
    [
        (-0.1, None, r"^seconds: must be finite and at least one outer step .*, given -0\.1"),
        (0.0, None, "^seconds"),
        (NAN, None, "^seconds"),
        (0.1, [None], "^hands: must have one item for each of 2 grippers, given 1"),
        (0.1, [HandTarget([0.0, NAN, 0.0]), None], r"^hands\[0\]\.displacement: must be three finite numbers"),
        (0.1, [None, HandTarget([0.0, 0.0], True)], r"^hands\[1\]\.displacement: must be three"),
        (0.1, [None, HandTarget(WORD, True)], r"^hands\[1\]\.displacement: must be three"),
        (0.1, [HandTarget([1.1, 0.0, 0.0]), None], r"^hands\[0\]\.displacement: must be reachable at up to 10 m/s"),
        (0.1, [None, HandTarget([0.0, 0.0, 0.1])], r"^hands\[1\]\.displacement: must be left out while"),
        (0.1, [None, HandTarget(vertices=[7])], r"^hands\[1\]\.vertices: must be left out while"),
        (0.1, [None, HandTarget(closed=True, vertices=[7, 7])], r"^hands\[1\]\.vertices: must be different"),
        (0.1, [None, HandTarget(closed=True, vertices=[10000])], r"^hands\[1\]\.vertices: must be different"),
        (0.1, [None, HandTarget(closed=True, vertices=[-1])], r"^hands\[1\]\.vertices: must be different"),
        (0.1, [None, HandTarget(closed=True, vertices=PART)], r"^hands\[1\]\.vertices: must be different"),
        (0.1, [None, HandTarget(closed=True, vertices=[])], r"^hands\[1\]\.vertices: must be different"),
        (0.1, [HandTarget(vertices=[7]), None], r"^hands\[0\]\.vertices: must be the vertices that the closed "
        "gripper holds"),
        (0.1, [None, HandTarget(closed=True, vertices=EDGE)], r"^hands\[1\]\.vertices: must be held by one gripper"),
    ],
)  # fmt: skip
def test_a_wrong_call_names_its_argument_and_does_nothing(seconds: float, hands: Any, message: str) -> None:
    simulation = Simulation(led())
    simulation.advance(0.1, [HandTarget(closed=True, vertices=EDGE), None])
    before = pickle.dumps(simulation.state())
    with pytest.raises(InputError, match=message):
        simulation.advance(seconds, hands)
    assert pickle.dumps(simulation.state()) == before
    simulation.advance(0.1, [HandTarget([0.0, 0.0, 0.01]), HandTarget(closed=True, vertices=[40])])


def test_vertices_that_the_scene_gives_to_another_hand_are_refused() -> None:
    later = folded(grippers=[held(EDGE, closes=0.5), held(np.array([7]), closes=100.0)])
    with pytest.raises(InputError, match=r"^hands\[1\]\.vertices: .* grippers 0 and 1 both hold vertex 2"):
        Simulation(later).advance(0.1, [None, HandTarget(closed=True, vertices=[2])])


def test_a_state_of_another_scene_is_refused() -> None:
    state = Simulation(folded()).state()
    with pytest.raises(InputError, match=r"^state: must come from a simulation with the same scene"):
        Simulation(folded(gravity=9.8)).restore(state)


def test_what_is_read_of_a_simulation_cannot_be_written() -> None:
    simulation = Simulation(folded())
    for array in (simulation.positions, simulation.velocities):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0
    assert simulation.positions.base is simulation.system.state.positions.x


def test_a_cloth_that_hands_tear_ends_in_an_error() -> None:
    simulation = Simulation(led())
    with pytest.raises(SimulationError, match=r"stretched to .* the limit is 1\.5"):
        simulation.advance(
            0.3, [HandTarget([-0.5, 0.0, 0.0], True, EDGE), HandTarget([0.5, 0.0, 0.0], True, [len(EDGE) + 40])]
        )


def test_the_names_are_public() -> None:
    assert tatamu.Simulation is Simulation and tatamu.HandTarget is HandTarget
