"""Find pairs of shapes that come too near along a motion, by MuJoCo's collision detection.

This is a second check in addition to `clearance`. The two checks share only the list of pairs. This module tests
every sample of the motion, and leaves it to MuJoCo to find the pairs that are near.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.robots.clearance import Clearance, Distance
from tatamu.robots.extras import needed
from tatamu.robots.model import Robot
from tatamu.robots.pairs import DISTANCES, link_name
from tatamu.robots.stage import stage


def touches(robot: Robot, table_height: float, configurations: np.ndarray) -> dict[str, Distance]:
    """Return the smallest distance of each kind of pair of shapes, if it is below the limit in `DISTANCES`.

    Distances are tested between pairs of collision shapes, in n configurations of the robot.

    Args:
        robot: The robot.
        table_height: Height of the table top in the base B [m].
        configurations: Angles of all nq joints in n configurations [rad], shape (n, nq).
    """
    mujoco = needed("mujoco")
    limits = {kind: limit.allowed for kind, limit in DISTANCES.items()}
    model = stage(robot, table_height, limits).compile()
    pairs = _pairs(robot, table_height, model)
    data = mujoco.MjData(model)
    found: dict[str, Distance] = {}
    for row, q in enumerate(configurations):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        for contact in data.contact[: data.ncon]:
            kind, links = pairs[frozenset(contact.geom.tolist())]
            if contact.dist < limits[kind] and (kind not in found or contact.dist < found[kind].value):
                found[kind] = Distance(float(contact.dist), row, links)
    return found


def _pairs(robot: Robot, table_height: float, model: Any) -> dict[frozenset[int], tuple[str, tuple[str, str]]]:
    """Return the kind and the two links of each pair of shapes that is tested."""
    clearance = Clearance(robot)
    clearance.set_table(table_height)
    found = {}
    for kind, *names in clearance.pairs:
        first, second = (int(model.geom(name).id) for name in names)
        found[frozenset((first, second))] = (kind, (link_name(model, first), link_name(model, second)))
    return found
