"""A motion for other programs: tables in CSV and JSON, ROS bags, goals of ROS 2 actions, and lists for hrpsys.

All of them are made from `trajectories`, the points of each ROS controller, and from the commands to the grippers.

hrpsys, the control software of HIRONX, and hrpsys_ros_bridge, which connects HIRONX to ROS, read only positions and
time_from_start from a trajectory, and need every joint of the group (start-jsk/rtmros_common:
HrpsysJointTrajectoryBridge.cpp). The robot moves from its present pose to the first point within this point's
time_from_start.

The bags contain messages trajectory_msgs/JointTrajectory for each controller, and control_msgs/GripperCommand for the
grippers. In ROS 1, controllers of ros_control listen on `CONTROLLER/command`. In ROS 2, controllers of ros2_control
listen on `CONTROLLER/joint_trajectory`. Each trajectory has the time stamp of the motion's start, and each gripper
command has the time stamp at which it is due. A program that plays the bag therefore sends each message at the right
time.

The goals are one file for each controller and segment, and a list of steps:

    goals/steps.json                        the steps in order: what moves, what grips, where to stop
    goals/1-approach/larm_controller.json   control_msgs/action/FollowJointTrajectory, the goal's fields

A program that plays the motion sends them step by step. The trajectory of a segment starts where the previous segment
ended. The files also contain velocities, so that controllers interpolate with cubic splines.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tatamu.base.files import write_json
from tatamu.robots.extras import needed
from tatamu.robots.plan import RobotPlan
from tatamu.robots.planfile import GripperCommand, Segment

DECIMALS = 9
POINT_EVERY = 4
"""Number of motion samples for each point of a trajectory.

The robot's motion has 200 samples a second. A trajectory for the robot software (ROS or hrpsys) contains only every
fourth sample as a point. So it has 50 points a second.
"""
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
GRIPPER = "control_msgs/msg/GripperCommand"
FOLLOW = "control_msgs/action/FollowJointTrajectory"
GRIP = "control_msgs/action/GripperCommand"
STAMP = 1_000_000_000
"""Time stamp of the motion's start [ns]. It is not 0, because 0 is not a valid time in ROS."""


class Trajectory(NamedTuple):
    """The whole motion of one ROS controller."""

    controller: str
    names: list[str]
    """Names of the k joints in the controller."""
    columns: list[int]
    """Indices of the joints in the motion's angles."""
    times: np.ndarray
    """Times of the points from the start [s], shape (n,)."""
    angles: np.ndarray
    """Angles of the joints at the points [rad], shape (n, k)."""


def trajectories(plan: RobotPlan) -> list[Trajectory]:
    """Return the trajectory of each controller that the motion needs.

    The first point is the initial pose, at the end of a lead time. Some ROS bridges move from the robot's present pose
    to the first point. Such a bridge then has the lead time for this move, so the robot does not jump.
    """
    robot, times = plan.task.robot, plan.motion.times
    controllers = [(arm.controller, [*arm.ros_joints], robot.arm_columns(arm)) for arm in robot.folding]
    if robot.trunk is not None and plan.task.placement.turning:
        controllers.append(("torso_controller", [robot.trunk], [robot.columns[robot.trunk]]))
    first = int(np.ceil(plan.motion.part("approach").start / times[1] - 1e-6))
    rows = _every_few(first, len(times) - 1)
    points = np.round(times[rows], 6)
    return [Trajectory(*each, points, _rounded(plan.motion.angles, rows, each[-1])) for each in controllers]


def _every_few(first: int, last: int) -> np.ndarray:
    """Return the indices of the samples that are points of a trajectory."""
    return np.append(np.arange(first, last, POINT_EVERY), last)


def _rounded(values: np.ndarray, rows: np.ndarray, columns: list[int]) -> np.ndarray:
    return np.ascontiguousarray(np.round(values[rows][:, columns], DECIMALS))


def _duration(time: float) -> dict[str, int]:
    """Return a time [s] as the fields of builtin_interfaces/Duration."""
    nanoseconds = round(time * 1e9)
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}


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
    return _csv([*GripperCommand.model_fields], (command.model_dump().values() for command in plan.gripper_commands))


def _csv(header: list[str], rows: Iterable[Iterable[Any]]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows([header, *rows])
    return text.getvalue()


def trajectory_json(plan: RobotPlan) -> dict[str, Any]:
    """Return the fields of trajectory_msgs/JointTrajectory for each controller's topic, and the gripper commands."""
    return {
        "version": 1,
        "units": {"time": "s", "positions": "rad", "width": "m", "force": "N", "duration": "s"},
        "topics": {
            f"/{each.controller}/command": {
                "joint_names": each.names,
                "points": [
                    {"time_from_start": float(time), "positions": row.tolist()}
                    for time, row in zip(each.times, each.angles, strict=True)
                ],
            }
            for each in trajectories(plan)
        },
        "events": [event.model_dump() for event in plan.events],
        "gripper_commands": [command.model_dump() for command in plan.gripper_commands],
    }


def pattern_json(plan: RobotPlan) -> dict[str, Any]:
    """Return the arguments of playPatternOfGroup(group, jointangles, tm) and of setHandWidth(hand, width, tm)."""
    return {
        "version": 1,
        "units": {"jointangles": "rad", "tm": "s from the point before", "time": "s", "width": "mm"},
        "groups": {
            each.controller.removesuffix("_controller"): {
                "joint_names": each.names,
                "jointangles": each.angles.tolist(),
                "tm": np.round(np.diff(each.times, prepend=0.0), 6).tolist(),
            }
            for each in trajectories(plan)
        },
        "hands": [
            {
                "time": command.time,
                "hand": command.arm.replace("arm", "hand"),
                "width": round(1e3 * command.width, 3),
                "tm": command.duration,
            }
            for command in plan.gripper_commands
        ],
    }


def write_ros1(plan: RobotPlan, path: Path) -> None:
    """Write a ROS 1 bag."""
    store = typestore("ROS1_NOETIC")
    with needed("rosbags.rosbag1").Writer(path) as writer:
        _send(plan, writer, store, store.serialize_ros1, "command")


def write_ros2(plan: RobotPlan, folder: Path) -> None:
    """Write a ROS 2 bag: a folder with the file metadata.yaml and one .mcap file."""
    store, rosbag2 = typestore("ROS2_HUMBLE"), needed("rosbags.rosbag2")
    with rosbag2.Writer(folder, version=8, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        _send(plan, writer, store, store.serialize_cdr, "joint_trajectory")


def typestore(name: str) -> Any:
    """Return the message types of a ROS release, including the type of gripper commands."""
    typesys = needed("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores[name])
    if GRIPPER not in store.types:  # rosbags has no own type of it; units are [m] and [N]
        store.register(typesys.get_types_from_msg("float64 position\nfloat64 max_effort\n", GRIPPER))
    return store


def _send(plan: RobotPlan, writer: Any, store: Any, serialize: Callable[[Any, str], Any], ending: str) -> None:
    """Write all messages in the order of time. The topics of trajectories end in `ending`."""
    grippers = {arm.name: arm.gripper_controller for arm in plan.task.robot.arms}
    sent = [(STAMP, f"/{each.controller}/{ending}", TRAJECTORY, _message(each, store)) for each in trajectories(plan)]
    for command in plan.gripper_commands:
        message = store.types[GRIPPER](position=command.width, max_effort=command.force)
        sent.append((STAMP + round(command.time * 1e9), f"/{grippers[command.arm]}/command", GRIPPER, message))
    # The topics are not latched, because a command must not be sent again to a controller that connects later.
    connections: dict[str, Any] = {}
    for time, topic, kind, message in sorted(sent, key=lambda each: each[0]):
        if topic not in connections:
            connections[topic] = writer.add_connection(topic, kind, typestore=store)
        writer.write(connections[topic], time, serialize(message, kind))


def _message(trajectory: Trajectory, store: Any) -> Any:
    types, empty = store.types, np.empty(0)
    header = {"stamp": types["builtin_interfaces/msg/Time"](sec=0, nanosec=0), "frame_id": ""}
    if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__:
        header["seq"] = 0
    return types[TRAJECTORY](
        header=types["std_msgs/msg/Header"](**header),
        joint_names=trajectory.names,
        points=[
            types["trajectory_msgs/msg/JointTrajectoryPoint"](
                positions=row,
                velocities=empty,
                accelerations=empty,
                effort=empty,
                time_from_start=types["builtin_interfaces/msg/Duration"](**_duration(float(time))),
            )
            for time, row in zip(trajectory.times, trajectory.angles, strict=True)
        ],
    )


def write_goals(plan: RobotPlan, folder: Path) -> None:
    """Write the goals of all segments, and the steps that name these goals."""
    steps: list[dict[str, Any]] = [_grip(plan, "open", 0)]
    controllers = trajectories(plan)
    for number, segment in enumerate(plan.segments, start=1):
        goals = {}
        for each in controllers:
            name = f"{number}-{segment.name}/{each.controller.replace('/', '.')}.json"
            write_json(folder / name, _goal(plan, segment, each.names, each.columns))
            goals[f"/{each.controller}/follow_joint_trajectory"] = name
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
    goals = {
        f"/{arm.gripper_controller}/gripper_cmd": {"command": {"position": each.width, "max_effort": each.force}}
        for arm, each in zip(arms, commands, strict=True)
    }
    return {"do": "grip", "event": word, "action": GRIP, "goals": goals, "wait": commands[0].duration}


def _goal(plan: RobotPlan, segment: Segment, names: list[str], columns: list[int]) -> dict[str, Any]:
    """Return the fields of the FollowJointTrajectory goal with which one controller moves its joints in one segment."""
    times, angles = plan.motion.times, plan.motion.angles
    begins = plan.motion.part("approach").start if segment.name == "approach" else segment.start + times[1]
    last = min(int(np.searchsorted(times, segment.end - 1e-6)), len(times) - 1)
    rows = _every_few(int(np.searchsorted(times, begins - 1e-6)), last)
    speeds = _rounded(np.gradient(angles, times, axis=0), rows, columns)
    speeds[-1] = 0.0
    points = [
        {"positions": q.tolist(), "velocities": v.tolist(), "time_from_start": _duration(float(time))}
        for time, q, v in zip(times[rows] - segment.start, _rounded(angles, rows, columns), speeds, strict=True)
    ]
    trajectory = {"joint_names": names, "points": points}
    return {"trajectory": trajectory, "goal_time_tolerance": _duration(1.0)}
