"""A scripted policy: actions that move the hands along a manipulation, step by step.

A manipulation is a planned motion of the hands that makes a fold.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tatamu.folding.manipulation import Manipulation


@dataclass(frozen=True)
class Led:
    """The positions of all hands at the end of each step, and whether their jaws are closed during the step."""

    places: np.ndarray
    """Positions of the hands at the end of each step [m], shape (steps, hands, 3)."""
    closed: np.ndarray
    """Whether the jaws are closed in each step, shape (steps,)."""


def lead(manipulation: Manipulation, start: np.ndarray, largest: float, rate: float) -> Led:
    """Return the motion of the hands in a manipulation.

    The hands go to their grasps with open jaws, then close and follow their paths, then open. If the hands are slower
    than the manipulation, they need more time for the same paths.

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
    """Return the actions for a motion of the hands, float32, shape (steps + wait, 4 * hands).

    An action has four numbers for each hand. After the motion, the hands wait with open jaws.

    Args:
        led: Path of the hands.
        start: Positions of the hands before the motion [m], shape (hands, 3).
        largest: Largest motion of a hand in a step, along each axis [m].
        wait: Number of steps in which the hands wait.
    """
    moves = np.diff(led.places, axis=0, prepend=start[None]) / largest
    jaws = np.broadcast_to(np.where(led.closed, 1.0, -1.0)[:, None, None], (*moves.shape[:2], 1))
    still = np.tile([0.0, 0.0, 0.0, -1.0], (wait, moves.shape[1]))
    return np.concatenate([np.concatenate([moves, jaws], axis=2).reshape(len(moves), -1), still]).astype(np.float32)


def follow(
    manipulation: Manipulation, start: np.ndarray, largest: float, rate: float, steps: int
) -> Iterator[np.ndarray]:
    """Yield the actions of all hands for a demonstration of the manipulation.

    Args:
        manipulation: The manipulation.
        start: Present positions of the hands [m], shape (hands, 3).
        largest: Largest motion of a hand in a step, along each axis [m].
        rate: Steps per second [1/s].
        steps: Number of steps.
    """
    yield from actions_of(lead(manipulation, start, largest, rate), start, largest, steps)[:steps]


def _places(manipulation: Manipulation, instants: np.ndarray) -> np.ndarray:
    """Return how far each hand has moved from its grasp at k times [m], shape (k, hands, 3)."""
    times, paths = manipulation.motion()
    return np.stack(
        [np.column_stack([np.interp(instants, times, column) for column in path.T]) for path in paths], axis=1
    )
