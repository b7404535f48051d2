"""The motion of hands in an episode: actions that follow a manipulation, and the scene of what was moved."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.folding.manipulation import HANDS, SETTLE, Manipulation
from tatamu.simulation.native import HandTarget
from tatamu.simulation.scene import Gripper, Scene


@dataclass(frozen=True)
class Led:
    """The hands' path, step by step."""

    places: np.ndarray
    """At the end of each step [m], shape (steps, hands, 3)."""
    closed: np.ndarray
    """During each step, shape (steps,)."""


def lead(manipulation: Manipulation, start: np.ndarray, largest: float, rate: float) -> Led:
    """Return the path of the hands: open to the grasps, then closed along the manipulation. Slower hands take longer.

    Args:
        manipulation: The manipulation.
        start: Present positions of the hands [m], shape (hands, 3).
        largest: Largest motion of a hand in a step, along each axis [m].
        rate: Steps per second [1/s].
    """
    grasps = np.array(manipulation.positions)
    count = int(np.ceil(float(np.abs(grasps - start).max()) / largest - 1e-9))
    there = start + (grasps - start) * (np.arange(1, count + 1) / max(count, 1))[:, None, None]
    instants = np.arange(0.0, manipulation.timing.opens, 1.0 / rate)
    places = _places(manipulation, instants)
    slower = float(np.abs(np.diff(places, axis=0)).max()) / largest
    if slower > 1.0:
        instants = np.linspace(0.0, instants[-1], int(np.ceil(1.1 * slower * len(instants))))
        places = _places(manipulation, instants)
    moves = places - places[0]  # fingers without thickness do not rise when they close
    closed = np.arange(count + len(moves)) >= count
    return Led(np.concatenate([there, grasps + moves]), closed)


def actions_of(led: Led, start: np.ndarray, largest: float, wait: int) -> np.ndarray:
    """Return the actions for a path from `start` on, after which the hands wait open: float32, shape (n, 4 * hands)."""
    moves = np.diff(led.places, axis=0, prepend=start[None]) / largest
    jaws = np.broadcast_to(np.where(led.closed, 1.0, -1.0)[:, None, None], (*moves.shape[:2], 1))
    still = np.tile([0.0, 0.0, 0.0, -1.0], (wait, moves.shape[1]))
    return np.concatenate([np.concatenate([moves, jaws], axis=2).reshape(len(moves), -1), still]).astype(np.float32)


def follow(
    manipulation: Manipulation, start: np.ndarray, largest: float, rate: float, steps: int
) -> Iterator[np.ndarray]:
    """Yield at most `steps` actions that demonstrate a manipulation. `lead` explains the arguments."""
    yield from actions_of(lead(manipulation, start, largest, rate), start, largest, steps)[:steps]


def _places(manipulation: Manipulation, instants: np.ndarray) -> np.ndarray:
    """Return how far the hands have moved from their grasps [m], shape (k, hands, 3)."""
    times, paths = manipulation.motion()
    return np.stack(
        [np.column_stack([np.interp(instants, times, column) for column in path.T]) for path in paths], axis=1
    )


def scene_of_led(untouched: Scene, led: Sequence[Sequence[HandTarget | None]], rate: float) -> Scene:
    """Return the scene of hands that were moved step by step, which any simulator can run.

    It ends `SETTLE` seconds after the last step.

    Args:
        untouched: The scene without hands.
        led: The targets of each hand in each step.
        rate: Steps per second [1/s].
    """
    hands = range(len(led[0]) if led else 0)
    grippers = [each for hand in hands for each in _grippers(hand, [targets[hand] for targets in led], rate)]
    ends = len(led) / rate + SETTLE
    return untouched.model_copy(update={"grippers": grippers, "duration": ends})


def _grippers(hand: int, targets: Sequence[HandTarget | None], rate: float) -> list[Gripper]:
    """Return a gripper for each period in which a hand was closed."""
    periods: list[dict[str, Any]] = []
    for step, target in enumerate(targets):
        start = step / rate
        if target is None:
            continue
        if target.closed is False:
            periods[-1]["opens"] = start
            continue
        if target.closed:
            first = {"times": [start], "displacements": [np.zeros(3)]}
            periods.append({"vertices": [int(vertex) for vertex in target.vertices or ()], "closes": start, **first})
        periods[-1]["times"].append((step + 1) / rate)
        periods[-1]["displacements"].append(np.asarray(target.displacement, dtype=float))
    return [
        Gripper(**{**period, "hand": HANDS[hand], "displacements": np.array(period["displacements"])})
        for period in periods
    ]
