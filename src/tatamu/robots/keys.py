"""Names of a robot's numbers in datasets. They follow LeRobot's names for pairs of arms: `left_shoulder_pan.pos`."""

from __future__ import annotations

import re
from os.path import commonprefix

from tatamu.robots.model import Arm, Robot


def state_names(robot: Robot) -> tuple[str, ...]:
    """Return the names of the robot's numbers: left arm, right arm, then the trunk if the robot has a trunk.

    Each arm has the names of its joints, then the name of its gripper. Joints have the names in `lerobot` of the
    description. If `lerobot` has no names, joints have their names in the model, without a common prefix such as
    `larm_`.
    """
    names = [name for side, arm in zip(("left", "right"), robot.arms, strict=True) for name in _keys(side, arm)]
    return (*names, *(() if robot.trunk is None else (f"{robot.trunk.lower()}.pos",)))


def _keys(side: str, arm: Arm) -> list[str]:
    """Return the keys of an arm's joints and of its gripper."""
    *joints, gripper = [f"{side}_{stem}.pos" for stem in _of(arm)]
    return [*(arm.lerobot.joints or joints), arm.lerobot.gripper or gripper]


def _of(arm: Arm) -> list[str]:
    shared = re.match(r".*[_/.\-]", commonprefix(arm.joints))  # noqa: RUF071 (letter by letter is meant)
    start = len(shared[0]) if shared and len(arm.joints) > 1 else 0
    return [*(re.sub(r"[^a-z0-9]+", "_", joint[start:].lower()) for joint in arm.joints), "gripper"]
