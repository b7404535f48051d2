"""A manipulation as the actions of an environment: what a scripted policy does."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tatamu.folding.manipulation import Manipulation


def follow(manipulation: Manipulation, largest: float, rate: float, steps: int) -> Iterator[np.ndarray]:
    """Yield the actions of all hands: closed along their paths, then open and still.

    Hands that are slower than the manipulation take longer, along the same paths.

    Args:
        manipulation: The manipulation.
        largest: Largest motion of a hand in a step, along each axis [m].
        rate: Steps per second [1/s].
        steps: Number of steps.
    """
    timing = manipulation.timing
    instants = np.arange(0.0, timing.opens, 1.0 / rate)
    ways = _ways(manipulation, instants)
    slower = float(np.abs(ways).max()) / largest
    if slower > 1.0:
        instants = np.linspace(0.0, instants[-1], int(np.ceil(1.1 * slower * len(instants))))
        ways = _ways(manipulation, instants)
    for number in range(steps):
        led = number < len(instants)
        hands = [np.append(way[number] / largest if led else np.zeros(3), 1.0 if led else -1.0) for way in ways]
        yield np.concatenate(hands).astype(np.float32)


def _ways(manipulation: Manipulation, instants: np.ndarray) -> np.ndarray:
    """The way of each hand until each instant [m], shape (hands, k, 3)."""
    times, paths = manipulation.motion()
    places = [np.column_stack([np.interp(instants, times, column) for column in path.T]) for path in paths]
    return np.stack([np.diff(each, axis=0, prepend=each[:1]) for each in places])
