"""Simulators without a solver: each knows one exact answer, or a wrong one."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tests.physics import Subject
from tests.physics.limits import NATIVE

Motion = Callable[[Scene, float], np.ndarray]
"""Scene and time [s] to positions, shape (n, 3)."""


def subject(motion: Motion) -> Subject:
    """A subject that moves as `motion` says, held to the limits of the embedded simulator."""

    def simulate(scene: Scene) -> Rollout:
        times = np.arange(scene.frames) / scene.frame_rate
        positions = np.stack([scene.cloth.vertices, *(motion(scene, time) for time in times[1:])])
        return Rollout(times, positions, np.array(scene.cloth.faces), {"simulator": "fake"})

    def simulate_many(scenes: Sequence[Scene]) -> list[Rollout]:
        return [simulate(scene) for scene in scenes]

    return Subject("fake", simulate, simulate_many, NATIVE)


def still(shape: Callable[[Scene], np.ndarray]) -> Motion:
    """At once in a final shape, which is worked out once per scene."""
    known: list[tuple[Scene, np.ndarray]] = []

    def motion(scene: Scene, time: float) -> np.ndarray:
        if not known or known[0][0] is not scene:
            known[:] = [(scene, shape(scene))]
        return known[0][1]

    return motion
