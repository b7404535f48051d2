"""The motion of the hands in an episode as a scene, which any simulator can run."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tatamu.folding.manipulation import HANDS, SETTLE
from tatamu.simulation.native import HandTarget
from tatamu.simulation.scene import Gripper, Scene


def scene_of_led(untouched: Scene, led: Sequence[Sequence[HandTarget | None]], rate: float) -> Scene:
    """Return the scene of hands that were moved step by step, which ends `SETTLE` seconds after the last step.

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
    found: list[Gripper] = []
    times: list[float] = []
    places: list[np.ndarray] = []
    vertices: list[int] = []
    for step, target in enumerate([*targets, HandTarget(closed=False)]):
        start = step / rate
        if target is None or (target.closed is False and not vertices):
            continue
        if target.closed is False:
            opens = start if step < len(targets) else None
            closes = times[0]
            displacements = np.array(places)
            found.append(
                Gripper(
                    hand=HANDS[hand],
                    vertices=vertices,
                    closes=closes,
                    opens=opens,
                    times=times,
                    displacements=displacements,
                )
            )
            vertices = []
            continue
        if target.closed:
            vertices = [int(vertex) for vertex in target.vertices or ()]
            times, places = [start], [np.zeros(3)]
        times = [*times, (step + 1) / rate]
        places = [*places, np.asarray(target.displacement, dtype=float)]
    return found
