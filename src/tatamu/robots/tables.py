"""A motion as tables for any programming language: CSV, JSON, and lists for hrpsys, the control software of HIRONX."""

from __future__ import annotations

import csv
import io
from typing import Any, NamedTuple

import numpy as np

from tatamu.robots.plan import RobotPlan
from tatamu.robots.planfile import GripperCommand

DECIMALS = 9
POINT_EVERY = 4
"""Number of motion samples for each point of a trajectory.

The robot's motion has 200 samples a second. A trajectory for the robot software (ROS or hrpsys) contains only every
fourth sample as a point. So it has 50 points a second.
"""


class Group(NamedTuple):
    """The joints of one ROS controller that the motion needs."""

    controller: str
    joints: tuple[str, ...]
    """Names of the joints in the plan."""
    names: tuple[str, ...]
    """Names of the joints in the controller."""


def joint_csv(plan: RobotPlan) -> str:
    """Return the motion as CSV with the header `time,JOINT,..` and one row for each sample [s, rad]."""
    robot, motion = plan.task.robot, plan.motion
    angles = motion.angles[:, [robot.columns[name] for name in robot.joints]]
    rows = (
        [f"{time:.6g}", *(f"{value:.{DECIMALS}f}" for value in row)]
        for time, row in zip(motion.times, angles, strict=True)
    )
    return _csv(["time", *robot.joints], rows)


def gripper_csv(plan: RobotPlan) -> str:
    """Return the commands to the grippers as CSV: time [s], arm, width [m], force [N], duration [s]."""
    fields = list(GripperCommand.model_fields)
    return _csv(fields, ([getattr(command, field) for field in fields] for command in plan.gripper_commands))


def _csv(header: list[str], rows: Any) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()


def groups(plan: RobotPlan) -> list[Group]:
    """Return the ROS controllers that the motion needs, each with its joints."""
    robot = plan.task.robot
    found = [Group(arm.controller, arm.joints, arm.ros_joints) for arm in robot.folding]
    if robot.trunk is not None and plan.task.placement.turning:
        found.append(Group("torso_controller", (robot.trunk,), (robot.trunk,)))
    return found


def points(plan: RobotPlan, joints: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the trajectory points of k joints: n times from the start [s], and the angles [rad], shape (n, k).

    The first point is the initial pose, at the end of a lead time. Some ROS bridges move from the robot's present pose
    to the first point. Such a bridge then has the lead time for this move, so the robot does not jump.
    """
    motion = plan.motion
    first = int(np.ceil(motion.part("approach").start / motion.times[1] - 1e-6))
    rows = np.append(np.arange(first, len(motion.times) - 1, POINT_EVERY), len(motion.times) - 1)
    return np.round(motion.times[rows], 6), angles_at(plan, joints, rows)


def angles_at(plan: RobotPlan, joints: tuple[str, ...], rows: np.ndarray) -> np.ndarray:
    """Return the angles of k joints at n samples of the motion [rad], shape (n, k)."""
    angles = plan.motion.angles[rows][:, [plan.task.robot.columns[name] for name in joints]]
    return np.ascontiguousarray(np.round(angles, DECIMALS))


def duration(time: float) -> dict[str, int]:
    """Return a time [s] as the fields of builtin_interfaces/Duration."""
    nanoseconds = round(time * 1e9)
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}


def trajectory_json(plan: RobotPlan) -> dict[str, Any]:
    """Return the fields of trajectory_msgs/JointTrajectory for each controller's topic, and the gripper commands."""
    topics = {}
    for group in groups(plan):
        times, angles = points(plan, group.joints)
        topics[f"/{group.controller}/command"] = {
            "joint_names": list(group.names),
            "points": [
                {"time_from_start": float(time), "positions": row.tolist()}
                for time, row in zip(times, angles, strict=True)
            ],
        }
    return {
        "version": 1,
        "units": {"time": "s", "positions": "rad", "width": "m", "force": "N", "duration": "s"},
        "topics": topics,
        "events": [{"time": event.time, "arm": event.arm, "event": event.event} for event in plan.events],
        "gripper_commands": [command.model_dump() for command in plan.gripper_commands],
    }


def pattern_json(plan: RobotPlan) -> dict[str, Any]:
    """Return the arguments of playPatternOfGroup(group, jointangles, tm) and of setHandWidth(hand, width, tm)."""
    patterns = {}
    for group in groups(plan):
        times, angles = points(plan, group.joints)
        patterns[group.controller.removesuffix("_controller")] = {
            "joint_names": list(group.names),
            "jointangles": angles.tolist(),
            "tm": np.round(np.diff(times, prepend=0.0), 6).tolist(),
        }
    hands = [
        {
            "time": command.time,
            "hand": command.arm.replace("arm", "hand"),
            "width": round(1e3 * command.width, 3),
            "tm": command.duration,
        }
        for command in plan.gripper_commands
    ]
    return {
        "version": 1,
        "units": {"jointangles": "rad", "tm": "s from the point before", "time": "s", "width": "mm"},
        "groups": patterns,
        "hands": hands,
    }
