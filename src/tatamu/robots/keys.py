"""Names of a robot's numbers in datasets, as LeRobot names those of pairs of arms: `left_shoulder_pan.pos`."""

from __future__ import annotations

import re
from os.path import commonprefix

from tatamu.robots.model import Arm, Robot


def state_names(robot: Robot) -> tuple[str, ...]:
    """Return the names of the joints and the gripper of the left arm, then of the right one; then the trunk's, if any.

    Joints have the names in `lerobot` of the description. Otherwise they have those of the robot, without a common
    prefix such as `larm_`.
    """
    names = [name for side, arm in zip(("left", "right"), robot.arms, strict=True) for name in _keys(side, arm)]
    return (*names, *(() if robot.trunk is None else (f"{robot.trunk.lower()}.pos",)))


def _keys(side: str, arm: Arm) -> list[str]:
    """The keys of an arm's joints and gripper."""
    *joints, gripper = [f"{side}_{stem}.pos" for stem in _of(arm)]
    return [*(arm.lerobot.joints or joints), arm.lerobot.gripper or gripper]


def _of(arm: Arm) -> list[str]:
    shared = re.match(r".*[_/.\-]", commonprefix(arm.joints))  # noqa: RUF071 (letter by letter is meant)
    start = len(shared[0]) if shared and len(arm.joints) > 1 else 0
    return [*(re.sub(r"[^a-z0-9]+", "_", joint[start:].lower()) for joint in arm.joints), "gripper"]
