"""Rigid bodies in MuJoCo.

They are free bodies with a very large mass. Before every step, each body is put on its path, and gets the velocity of
this path.

MuJoCo's mocap bodies are not used, because they have no velocity and would not drag the cloth.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.simulation.body import Body

CONTACT = 'solref="0.004 1" solimp="0.95 0.99 0.0002"'
"""Contact parameters in MuJoCo's language.

A contact in MuJoCo is a spring with a damper. Here its time constant is 4 ms. The deeper the contact, the stiffer it
is, up to a depth of 0.2 mm."""
HEAVY = 1e3
"""Mass of a body [kg]. It is so large that cloth does not move the body within a step."""
RIGID = 2
"""Bit in MuJoCo's collision masks.

With this bit, bodies collide with cloth, but not with each other or with the table."""


def rigid(number: int, body: Body) -> str:
    """Return the XML element of a body in MuJoCo's language.

    Sizes and quaternions are not converted, because MuJoCo defines them as tatamu does.
    """
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
        """Find the body in a model, from its number among the bodies of the scene."""
        self.body = body
        joint = int(model.body(f"rigid{number}").jntadr[0])
        at = int(model.jnt_qposadr[joint])
        rate = int(model.jnt_dofadr[joint])
        self.coordinates = slice(at, at + 7)
        self.velocities = slice(rate, rate + 6)

    def aim(self, data: Any, start: float, end: float) -> None:
        """Put the body on its path before a step from `start` to `end` [s], and give it the velocity of the path."""
        import mujoco

        positions, orientations = self.body.path(np.array([start, end]))
        turn = np.zeros(3)
        mujoco.mju_subQuat(turn, orientations[1], orientations[0])  # in the body's frame, like its angular velocity
        data.qpos[self.coordinates] = np.concatenate([positions[0], orientations[0]])
        data.qvel[self.velocities] = np.concatenate([positions[1] - positions[0], turn]) / (end - start)

    def settle(self, data: Any, end: float) -> None:
        """Put the body back on its path after a step, because cloth and gravity have pulled it off the path."""
        positions, orientations = self.body.path(np.array([end]))
        data.qpos[self.coordinates] = np.concatenate([positions[0], orientations[0]])
