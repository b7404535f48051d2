"""A stand-in for hrpsys_ros_bridge, run by the Python that has rospy: listens, moves at once, writes what it saw.

Its rules are those of HrpsysJointTrajectoryBridge.cpp (start-jsk/rtmros_common): only positions and time_from_start
are read; every joint of the group must be named, in any order, else nothing is sent; the first point's time counts
from the pose that is commanded now; a time of 0 is a jump.

    python3 ros_controller.py OUT.json  <  {"controllers": {"larm_controller": {"JOINT": angle, ..}, ..}}
"""

import json
import sys
import time
from typing import Any

import rospy  # type: ignore[import-not-found]
from trajectory_msgs.msg import JointTrajectory  # type: ignore[import-not-found]


def driven(pose: dict[str, float], names: list[str], points: list[Any]) -> tuple[dict[str, float], float]:
    """The pose after the points, and the fastest speed on the way."""
    speed, last = 0.0, 0.0
    for point in points:
        goal = dict(zip(names, point["positions"], strict=True))
        duration = max(point["time_from_start"] - last, 1e-3)
        speed = max([speed, *(abs(goal[name] - pose[name]) / duration for name in pose)])
        pose, last = {name: goal[name] for name in pose}, point["time_from_start"]
    return pose, speed


def main() -> None:
    """Wait for one command for each controller."""
    controllers = json.load(sys.stdin)["controllers"]
    heard: dict[str, Any] = {}

    def listen(name: str, message: Any) -> None:
        points = [
            {"time_from_start": point.time_from_start.to_sec(), "positions": list(point.positions)}
            for point in message.points
        ]
        pose = controllers[name]
        entry: dict[str, Any] = {"joint_names": list(message.joint_names), "points": points}
        if set(pose) <= set(message.joint_names):
            entry["pose"], entry["speed"] = driven(pose, message.joint_names, points)
        heard[name] = entry

    rospy.init_node("stand_in_controller", disable_signals=True)
    for name in controllers:
        rospy.Subscriber("/" + name + "/command", JointTrajectory, lambda message, name=name: listen(name, message))
    print("ready", flush=True)
    deadline = time.time() + 1800
    while len(heard) < len(controllers) and time.time() < deadline:
        time.sleep(0.05)
    with open(sys.argv[1], "w") as file:
        json.dump(heard, file)


main()
