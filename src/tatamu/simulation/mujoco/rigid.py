"""Rigid bodies: free, very heavy bodies that are put on their paths, because mocap bodies would not drag the cloth."""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.simulation.body import Body

CONTACT = 'solref="0.004 1" solimp="0.95 0.99 0.0002"'
"""A spring with a damper, with a time constant of 4 ms, that stiffens up to a depth of 0.2 mm."""
HEAVY = 1e3
"""Mass of a body [kg], so large that cloth does not move it within a step."""
RIGID = 2
"""Bit in MuJoCo's collision masks with which bodies collide with cloth, but not with each other or the table."""


def rigid(number: int, body: Body) -> str:
    """Return the XML element of a body; MuJoCo defines sizes and quaternions as tatamu does."""
    size = " ".join(map(repr, body.size))
    return (
        f'<body name="rigid{number}"><freejoint/>'
        f'<inertial pos="0 0 0" mass="{HEAVY!r}" diaginertia="{HEAVY!r} {HEAVY!r} {HEAVY!r}"/>'
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
