"""The robot with its tools and the table, as one MuJoCo model that stands alone."""

from __future__ import annotations

from typing import Any

from tatamu.robots.clearance import Clearance
from tatamu.robots.extras import needed
from tatamu.robots.model import TABLE, Robot, with_tools


def stage(robot: Robot, table_height: float) -> Any:
    """A mujoco.MjSpec with the table top at a height in B [m]; what a plan checks, and nothing else, can touch."""
    mujoco = needed("mujoco")
    spec = with_tools(robot.spec, robot.arms)
    data = mujoco.MjData(robot.model)
    mujoco.mj_kinematics(robot.model, data)
    table = spec.geom(TABLE)
    table.pos = [0, 0, data.body(robot.base).xpos[2] + table_height - table.size[2]]
    for geom in spec.geoms:
        geom.contype = geom.conaffinity = 0
    for first, second in Clearance(robot).pairs:
        spec.add_pair(geomname1=first, geomname2=second)
    return spec


def stage_xml(robot: Robot, table_height: float) -> str:
    """The stage as MJCF text."""
    spec = stage(robot, table_height)
    spec.compile()
    return str(spec.to_xml())
