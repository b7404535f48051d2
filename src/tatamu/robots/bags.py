"""A motion as ROS bags.

The bags contain these messages:

- trajectory_msgs/JointTrajectory for each controller
- control_msgs/GripperCommand for the grippers

hrpsys_ros_bridge, which connects HIRONX to ROS, reads only positions and time_from_start from a trajectory, and needs
every joint of the group (start-jsk/rtmros_common: HrpsysJointTrajectoryBridge.cpp). The robot moves from its present
pose to the first point within this point's time_from_start.

In ROS 1, controllers of ros_control listen on `CONTROLLER/command`. In ROS 2, controllers of ros2_control listen on
`CONTROLLER/joint_trajectory`. Each trajectory has the time stamp of the motion's start, and each gripper command has
the time stamp at which it is due. A program that plays the bag therefore sends each message at the right time.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from tatamu.robots.extras import needed
from tatamu.robots.plan import RobotPlan
from tatamu.robots.tables import Group, duration, groups, points

TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
GRIPPER = "control_msgs/msg/GripperCommand"
STAMP = 1_000_000_000
"""Time stamp of the motion's start [ns]. It is not 0, because 0 is not a valid time in ROS."""


class Sent(NamedTuple):
    """One message of a bag."""

    time: int
    """Time of the message [ns]."""
    topic: str
    kind: str
    message: Any


def write_ros1(plan: RobotPlan, path: Path) -> None:
    """Write a ROS 1 bag."""
    store = typestore("ROS1_NOETIC")
    with needed("rosbags.rosbag1").Writer(path) as writer:
        _write(writer, _messages(plan, store, "command"), store, store.serialize_ros1)


def write_ros2(plan: RobotPlan, folder: Path) -> None:
    """Write a ROS 2 bag: a folder with the file metadata.yaml and one .mcap file."""
    store, rosbag2 = typestore("ROS2_HUMBLE"), needed("rosbags.rosbag2")
    with rosbag2.Writer(folder, version=8, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        _write(writer, _messages(plan, store, "joint_trajectory"), store, store.serialize_cdr)


def typestore(name: str) -> Any:
    """Return the message types of a ROS release, including the type of gripper commands."""
    typesys = needed("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores[name])
    if GRIPPER not in store.types:  # rosbags has no own type of it; units are [m] and [N]
        store.register(typesys.get_types_from_msg("float64 position\nfloat64 max_effort\n", GRIPPER))
    return store


def _write(writer: Any, messages: list[Sent], store: Any, serialize: Any) -> None:
    # The topics are not latched, because a command must not be sent again to a controller that connects later.
    connections: dict[str, Any] = {}
    for sent in messages:
        if sent.topic not in connections:
            connections[sent.topic] = writer.add_connection(sent.topic, sent.kind, typestore=store)
        writer.write(connections[sent.topic], sent.time, serialize(sent.message, sent.kind))


def _messages(plan: RobotPlan, store: Any, ending: str) -> list[Sent]:
    """Return all messages in the order of time. The topics of trajectories end in `ending`."""
    controllers = {arm.name: arm.gripper_controller for arm in plan.task.robot.arms}
    trajectories = [
        Sent(STAMP, f"/{group.controller}/{ending}", TRAJECTORY, _trajectory(plan, group, store))
        for group in groups(plan)
    ]
    grippers = [
        Sent(
            STAMP + round(command.time * 1e9),
            f"/{controllers[command.arm]}/command",
            GRIPPER,
            store.types[GRIPPER](position=command.width, max_effort=command.force),
        )
        for command in plan.gripper_commands
    ]
    return sorted([*trajectories, *grippers], key=lambda sent: sent.time)


def _trajectory(plan: RobotPlan, group: Group, store: Any) -> Any:
    types = store.types
    times, angles = points(plan, group.joints)
    header = {"stamp": types["builtin_interfaces/msg/Time"](sec=0, nanosec=0), "frame_id": ""}
    if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__:
        header["seq"] = 0
    empty = np.empty(0)
    return types[TRAJECTORY](
        header=types["std_msgs/msg/Header"](**header),
        joint_names=list(group.names),
        points=[
            types["trajectory_msgs/msg/JointTrajectoryPoint"](
                positions=row,
                velocities=empty,
                accelerations=empty,
                effort=empty,
                time_from_start=types["builtin_interfaces/msg/Duration"](**duration(float(time))),
            )
            for time, row in zip(times, angles, strict=True)
        ],
    )
