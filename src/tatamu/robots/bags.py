"""A motion as ROS bags: trajectory_msgs/JointTrajectory on each controller's command topic.

How hrpsys_ros_bridge reads them (start-jsk/rtmros_common: HrpsysJointTrajectoryBridge.cpp): it reads positions and
time_from_start only, needs every joint of the group, and takes the first point's time as the time to get there from
wherever the robot is.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tatamu.robots.extras import needed
from tatamu.robots.plan import RobotPlan
from tatamu.robots.tables import groups, points

MESSAGE = "trajectory_msgs/msg/JointTrajectory"
STAMP = 1_000_000_000
"""Time stamp of the messages [ns]; ROS has no time 0."""


def write_ros1(plan: RobotPlan, path: Path) -> None:
    """Write a ROS 1 bag."""
    store = _store("ROS1_NOETIC")
    with needed("rosbags.rosbag1").Writer(path) as writer:
        for topic, message in _messages(plan, store):
            # Not latched: a command must not come back to a controller that connects later.
            connection = writer.add_connection(topic, MESSAGE, typestore=store)
            writer.write(connection, STAMP, store.serialize_ros1(message, MESSAGE))


def write_ros2(plan: RobotPlan, folder: Path) -> None:
    """Write a ROS 2 bag: a folder with metadata.yaml and one .mcap."""
    store, rosbag2 = _store("ROS2_HUMBLE"), needed("rosbags.rosbag2")
    with rosbag2.Writer(folder, version=8, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        for topic, message in _messages(plan, store):
            connection = writer.add_connection(topic, MESSAGE, typestore=store)
            writer.write(connection, STAMP, store.serialize_cdr(message, MESSAGE))


def _store(name: str) -> Any:
    typesys = needed("rosbags.typesys")
    return typesys.get_typestore(typesys.Stores[name])


def _messages(plan: RobotPlan, store: Any) -> list[tuple[str, Any]]:
    return [(f"/{controller}/command", _message(plan, joints, store)) for controller, joints in groups(plan).items()]


def _message(plan: RobotPlan, joints: tuple[str, ...], store: Any) -> Any:
    types = store.types
    times, angles = points(plan, joints)
    header = {"stamp": types["builtin_interfaces/msg/Time"](sec=0, nanosec=0), "frame_id": ""}
    if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__:
        header["seq"] = 0
    empty = np.empty(0)
    return types[MESSAGE](
        header=types["std_msgs/msg/Header"](**header),
        joint_names=list(joints),
        points=[
            types["trajectory_msgs/msg/JointTrajectoryPoint"](
                positions=row,
                velocities=empty,
                accelerations=empty,
                effort=empty,
                time_from_start=_duration(types, float(time)),
            )
            for time, row in zip(times, angles, strict=True)
        ],
    )


def _duration(types: Any, time: float) -> Any:
    nanoseconds = round(time * 1e9)
    return types["builtin_interfaces/msg/Duration"](sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)
