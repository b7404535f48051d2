"""Hands and rigid bodies, which are moved along their paths from outside.

MuJoCo has no grippers for cloth, so held vertices are made very heavy. Rigid bodies are free and very heavy bodies,
because mocap bodies would not drag the cloth.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.simulation.body import Body
from tatamu.simulation.scene import Gripper

CONTACT = 'solref="0.004 1" solimp="0.95 0.99 0.0002"'
"""A spring with a damper, with a time constant of 4 ms, that stiffens up to a depth of 0.2 mm."""
RIGID = 2
"""Bit in MuJoCo's collision masks with which bodies collide with cloth, but not with each other or the table."""


class HeldVertices:
    """The vertices that one gripper holds and moves along its path."""

    def __init__(self, gripper: Gripper, masses: np.ndarray) -> None:
        self.gripper = gripper
        self.sliders = (3 * np.array(gripper.vertices)[:, None] + np.arange(3)).ravel()
        self.armature = 1e6 * np.repeat(masses[gripper.vertices], 3)  # so much that cloth cannot pull it off its path
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


def rigid(number: int, body: Body) -> str:
    """Return the XML element of a body; MuJoCo defines sizes and quaternions as tatamu does."""
    size = " ".join(map(repr, body.size))
    heavy = repr(1e3)  # mass [kg], so large that cloth does not move the body within a step
    return (
        f'<body name="rigid{number}"><freejoint/>'
        f'<inertial pos="0 0 0" mass="{heavy}" diaginertia="{heavy} {heavy} {heavy}"/>'
        f'<geom type="{body.shape}" size="{size}" contype="{RIGID}" conaffinity="0" condim="3" priority="1"'
        f' friction="{body.friction!r} 0 0" {CONTACT}/></body>'
    )


class MovingBody:
    """A rigid body that is moved along its path in the scene."""

    def __init__(self, body: Body, model: Any, number: int) -> None:
        self.body = body
        joint = int(model.body(f"rigid{number}").jntadr[0])
        at = int(model.jnt_qposadr[joint])
        rate = int(model.jnt_dofadr[joint])
        self.coordinates = slice(at, at + 7)
        self.velocities = slice(rate, rate + 6)

    def aim(self, data: Any, start: float, end: float) -> None:
        """Put the body on its path, with its velocity, before a step from `start` to `end` [s]."""
        import mujoco

        positions, orientations = self.body.path(np.array([start, end]))
        turn = np.zeros(3)
        mujoco.mju_subQuat(turn, orientations[1], orientations[0])  # in the body's frame, like its angular velocity
        data.qpos[self.coordinates] = np.concatenate([positions[0], orientations[0]])
        data.qvel[self.velocities] = np.concatenate([positions[1] - positions[0], turn]) / (end - start)

    def settle(self, data: Any, end: float) -> None:
        """Put the body back on its path after a step, because cloth and gravity have pulled it off."""
        positions, orientations = self.body.path(np.array([end]))
        data.qpos[self.coordinates] = np.concatenate([positions[0], orientations[0]])
