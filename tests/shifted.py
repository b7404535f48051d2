"""A simulator that agrees with the embedded one but for a shift, and may fail."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tatamu.base.errors import SimulationError
from tatamu.simulation import native
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import Capabilities

CAPABILITIES = Capabilities()
SHIFT = np.zeros(3)
"""Added to every frame but the first [m]."""
CALLS: list[Scene] = []
FAILS_AT: list[int] = []
"""Numbers of the calls that end in an error."""


def require() -> None:
    pass


def prepare() -> None:
    native.prepare()


def compilation() -> tuple[int, int]:
    return native.compilation()


def simulate(scene: Scene) -> Rollout:
    CALLS.append(scene)
    if len(CALLS) - 1 in FAILS_AT:
        raise SimulationError("shifted: the cloth was stretched")
    rollout = native.simulate(scene)
    positions = rollout.positions + SHIFT * (rollout.times > 0)[:, None, None]
    return Rollout(rollout.times, positions, rollout.faces, {**rollout.info, "simulator": "shifted"})


def simulate_many(scenes: Sequence[Scene]) -> list[Rollout]:
    return [simulate(scene) for scene in scenes]
