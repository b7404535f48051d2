"""A motion as goals of ROS 2 actions: one file for each controller and segment, and a list of steps.

A program that plays the motion sends these goals step by step.

    goals/steps.json                        the steps in order: what moves, what grips, where to stop
    goals/1-approach/larm_controller.json   control_msgs/action/FollowJointTrajectory, the goal's fields

The trajectory of a segment starts where the previous segment ended. The files also contain velocities, so that
controllers interpolate with cubic splines.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.files import write_json
from tatamu.robots.plan import RobotPlan
from tatamu.robots.planfile import Segment
from tatamu.robots.tables import DECIMALS, POINT_EVERY, Group, angles_at, duration, groups

FOLLOW = "control_msgs/action/FollowJointTrajectory"
GRIP = "control_msgs/action/GripperCommand"


def write_goals(plan: RobotPlan, folder: Path) -> None:
    """Write the goals of all segments, and the steps that name these goals."""
    steps: list[dict[str, Any]] = [_grip(plan, "open", 0)]
    for number, segment in enumerate(plan.segments, start=1):
        goals = {}
        for group in groups(plan):
            name = f"{number}-{segment.name}/{group.controller.replace('/', '.')}.json"
            write_json(folder / name, _follow(plan, segment, group))
            goals[f"/{group.controller}/follow_joint_trajectory"] = name
        steps.append({"do": "move", "segment": segment.name, "action": FOLLOW, "goals": goals})
        if number < len(plan.segments):
            steps.append({"do": "stop", "before": segment.then})
        if segment.then:
            steps.append(_grip(plan, segment.then, number))
    write_json(folder / "steps.json", {"version": 1, "robot": plan.task.robot.name, "steps": steps})


def _grip(plan: RobotPlan, word: str, number: int) -> dict[str, Any]:
    """Return a step in which all grippers of the robot move at once."""
    arms = plan.task.robot.folding
    commands = plan.gripper_commands[len(arms) * number : len(arms) * (number + 1)]
    return {
        "do": "grip",
        "event": word,
        "action": GRIP,
        "goals": {
            f"/{arm.gripper_controller}/gripper_cmd": {
                "command": {"position": command.width, "max_effort": command.force}
            }
            for arm, command in zip(arms, commands, strict=True)
        },
        "wait": commands[0].duration,
    }


def _follow(plan: RobotPlan, segment: Segment, group: Group) -> dict[str, Any]:
    """Return the fields of the FollowJointTrajectory goal with which one controller moves its joints in one segment."""
    times = plan.motion.times
    begins = plan.motion.part("approach").start if segment.name == "approach" else segment.start + times[1]
    first = int(np.searchsorted(times, begins - 1e-6))
    last = min(int(np.searchsorted(times, segment.end - 1e-6)), len(times) - 1)
    rows = np.append(np.arange(first, last, POINT_EVERY), last)
    speeds = np.gradient(plan.motion.angles, plan.motion.times, axis=0)[rows]
    speeds = speeds[:, [plan.task.robot.columns[name] for name in group.joints]]
    speeds[-1] = 0.0
    return {
        "trajectory": {
            "joint_names": list(group.names),
            "points": [
                {"positions": q.tolist(), "velocities": v.tolist(), "time_from_start": duration(float(time))}
                for time, q, v in zip(
                    times[rows] - segment.start,
                    angles_at(plan, group.joints, rows),
                    np.round(speeds, DECIMALS),
                    strict=True,
                )
            ],
        },
        "goal_time_tolerance": duration(1.0),
    }
