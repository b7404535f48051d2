"""Rigid bodies in MuJoCo: free bodies, very heavy, that are put on their path with its velocity before every step.

MuJoCo's mocap bodies are not used: they have no velocity, so they would not drag the cloth.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.body import Body

CONTACT = 'solref="0.004 1" solimp="0.95 0.99 0.0002"'
"""Contact parameters: MuJoCo's contacts are springs and dampers, here with 4 ms over 0.2 mm."""
HEAVY = 1e3
"""Mass of a body [kg]: cloth does not move it within a step."""
RIGID = 2
"""Bit of the collision masks with which bodies collide with cloth only, not with each other or the table."""


def rigid(number: int, body: Body) -> str:
    """The element of a body, in MuJoCo's language; its size and quaternions are as ours."""
    size = " ".join(map(repr, body.size))
    return (
        f'<body name="rigid{number}"><freejoint/>'
        f'<inertial pos="0 0 0" mass="{HEAVY!r}" diaginertia="{HEAVY!r} {HEAVY!r} {HEAVY!r}"/>'
        f'<geom type="{body.shape}" size="{size}" contype="{RIGID}" conaffinity="0" condim="3" priority="1"'
        f' friction="{body.friction!r} 0 0" {CONTACT}/></body>'
    )


class MovingBody:
    """A body on its path."""

    def __init__(self, body: Body, model: Any, number: int) -> None:
        """Find body `number` of a scene in a model."""
        self.body = body
        joint = int(model.body(f"rigid{number}").jntadr[0])
        at = int(model.jnt_qposadr[joint])
        rate = int(model.jnt_dofadr[joint])
        self.coordinates = slice(at, at + 7)
        self.velocities = slice(rate, rate + 6)

    def aim(self, data: Any, start: float, end: float) -> None:
        """Before a step from `start` to `end` [s]: put the body on its path, with its velocity."""
        import mujoco

        positions, orientations = self.body.path(np.array([start, end]))
        turn = np.zeros(3)
        mujoco.mju_subQuat(turn, orientations[1], orientations[0])  # in the frame of the body, as its velocity is
        data.qpos[self.coordinates] = np.concatenate([positions[0], orientations[0]])
        data.qvel[self.velocities] = np.concatenate([positions[1] - positions[0], turn]) / (end - start)

    def settle(self, data: Any, end: float) -> None:
        """After a step: undo the displacement by which cloth and gravity pulled it off its path."""
        positions, orientations = self.body.path(np.array([end]))
        data.qpos[self.coordinates] = np.concatenate([positions[0], orientations[0]])
