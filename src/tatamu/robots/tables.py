"""A motion as tables for any language: CSV, JSON, and lists for hrpsys' playPatternOfGroup."""

from __future__ import annotations

import csv
import io
from typing import Any

import numpy as np

from tatamu.robots.model import Robot
from tatamu.robots.motion import Motion
from tatamu.robots.plan import RobotPlan

DECIMALS = 9
POINT_EVERY = 4
"""Samples from one trajectory point of ROS and hrpsys to the next: 50 points a second."""


def joint_csv(robot: Robot, motion: Motion) -> str:
    """CSV with the header `time,JOINT,..`, one row per sample [s, rad]."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", *robot.joints])
    angles = motion.angles[:, [robot.columns[name] for name in robot.joints]]
    for time, row in zip(motion.times, angles, strict=True):
        writer.writerow([f"{time:.6g}", *(f"{value:.{DECIMALS}f}" for value in row)])
    return text.getvalue()


def groups(plan: RobotPlan) -> dict[str, tuple[str, ...]]:
    """The joints of each ROS controller that the motion needs."""
    robot = plan.task.robot
    controllers = {arm.controller: arm.joints for arm in robot.arms}
    if robot.trunk is not None and plan.task.placement.turning:
        controllers["torso_controller"] = (robot.trunk,)
    return controllers


def points(plan: RobotPlan, joints: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Trajectory points of some joints: times from the start [s] (n,), and angles [rad] (n, k).

    The first point is the initial pose after the lead time: a bridge that times its first point from wherever the
    robot stands then brings it there in that time, and never by a jump.
    """
    motion, robot = plan.motion, plan.task.robot
    first = int(np.ceil(motion.part("approach").start / motion.times[1] - 1e-6))
    rows = np.append(np.arange(first, len(motion.times) - 1, POINT_EVERY), len(motion.times) - 1)
    angles = motion.angles[rows][:, [robot.columns[name] for name in joints]]
    return np.round(motion.times[rows], 6), np.ascontiguousarray(np.round(angles, DECIMALS))


def trajectory_json(plan: RobotPlan) -> dict[str, Any]:
    """The fields of trajectory_msgs/JointTrajectory for each controller's command topic."""
    topics = {}
    for controller, joints in groups(plan).items():
        times, angles = points(plan, joints)
        topics[f"/{controller}/command"] = {
            "joint_names": list(joints),
            "points": [
                {"time_from_start": float(time), "positions": row.tolist()}
                for time, row in zip(times, angles, strict=True)
            ],
        }
    events = [{"time": event.time, "arm": event.arm, "event": event.event} for event in plan.motion.events]
    return {"version": 1, "units": {"time": "s", "positions": "rad"}, "topics": topics, "events": events}


def pattern_json(plan: RobotPlan) -> dict[str, Any]:
    """Arguments of playPatternOfGroup(group, jointangles, tm): radians, and seconds from point to point."""
    patterns = {}
    for controller, joints in groups(plan).items():
        times, angles = points(plan, joints)
        patterns[controller.removesuffix("_controller")] = {
            "joint_names": list(joints),
            "jointangles": angles.tolist(),
            "tm": np.round(np.diff(times, prepend=0.0), 6).tolist(),
        }
    return {
        "version": 1,
        "units": {"jointangles": "rad", "tm": "s from the point before"},
        "groups": patterns,
    }
