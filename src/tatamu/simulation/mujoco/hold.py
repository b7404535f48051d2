"""Grippers, which MuJoCo does not have for cloth: held vertices are made very heavy and are moved along their path."""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.simulation.scene import Gripper

HEAVY = 1e6
"""Added mass of a held vertex, as a multiple of its own [-], so that cloth cannot pull it off its path in a step."""


class HeldVertices:
    """The vertices that one gripper holds and moves along its path."""

    def __init__(self, gripper: Gripper, masses: np.ndarray) -> None:
        self.gripper = gripper
        self.sliders = (3 * np.array(gripper.vertices)[:, None] + np.arange(3)).ravel()
        self.armature = HEAVY * np.repeat(masses[gripper.vertices], 3)
        self.closed_at: np.ndarray | None = None

    def close(self, model: Any, data: Any) -> None:
        """Hold the vertices where they are. The constants of the model must be computed again afterwards."""
        if self.closed_at is None:
            self.closed_at = data.qpos[self.sliders].copy()
            model.dof_armature[self.sliders] = self.armature

    def open(self, model: Any) -> None:
        """Release the vertices. The constants of the model must be computed again afterwards."""
        if self.closed_at is not None:
            self.closed_at = None
            model.dof_armature[self.sliders] = 0.0

    def aim(self, data: Any, start: float, end: float) -> None:
        """Put the vertices on their path, with its velocity, before a step from `start` to `end` [s]."""
        if self.closed_at is not None:
            data.qpos[self.sliders] = self._path(start)
            data.qvel[self.sliders] = (self._path(end) - self._path(start)) / (end - start)

    def settle(self, data: Any, end: float) -> None:
        """Put the vertices back on their path after a step, because the cloth has pulled them off."""
        if self.closed_at is not None:
            data.qpos[self.sliders] = self._path(end)

    def _path(self, time: float) -> np.ndarray:
        assert self.closed_at is not None
        return np.asarray(self.closed_at + np.tile(self.gripper.displacement(time), len(self.gripper.vertices)))
