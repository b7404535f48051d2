"""The exported bag through real ROS 1: its master, rosbag play, and a subscriber in the Python that has rospy.

Debian: apt-get install python3-rospy python3-roslaunch python3-rosbag python3-trajectory-msgs
"""

import json
import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu.robots import load
from tatamu.robots.exports import typestore

PYTHON = "/usr/bin/python3"


def missing() -> str | None:
    """What of ROS is not installed, if anything."""
    tools = [tool for tool in ("rosmaster", "rosbag") if shutil.which(tool) is None]
    if tools:
        return f"ROS 1 is not installed: no {' and no '.join(tools)}"
    probe = [PYTHON, "-c", "import rospy, trajectory_msgs.msg"]
    if subprocess.run(probe, capture_output=True).returncode:
        return "ROS 1 is not installed: no rospy with trajectory_msgs"
    return None


needs_ros = pytest.mark.skipif(missing() is not None, reason=missing() or "")


@pytest.fixture
def ros(tmp_path: Path) -> Iterator[dict[str, str]]:
    """A ROS master of our own on a free port; yields the environment that finds it."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    environment = {
        **{name: value for name, value in os.environ.items() if not name.startswith("PYTHON")},
        "ROS_MASTER_URI": f"http://127.0.0.1:{port}",
        "ROS_IP": "127.0.0.1",
        "ROS_HOME": str(tmp_path),
        "PATH": f"/usr/bin:{os.environ['PATH']}",
    }
    quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    master = subprocess.Popen(["rosmaster", "--core", "-p", str(port)], env=environment, **quiet)
    try:
        answered(port)
        yield environment
    finally:
        master.kill()  # it keeps nothing, and on a busy machine it takes long to end by itself
        master.wait()


def answered(port: int) -> None:
    """Wait until the master listens."""
    for _ in range(18000):
        with socket.socket() as probe:
            if probe.connect_ex(("127.0.0.1", port)) == 0:
                return
        time.sleep(0.1)
    raise TimeoutError("the ROS master did not start")


def heard(bag: Path, controllers: dict[str, dict[str, float]], ros: dict[str, str], out: Path) -> dict[str, Any]:
    """Play a bag to a stand-in controller; what it received and where it ended."""
    script = Path(__file__).parent / "ros_controller.py"
    listener = subprocess.Popen(
        [PYTHON, str(script), str(out)], env=ros, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert listener.stdin is not None and listener.stdout is not None
    listener.stdin.write(json.dumps({"controllers": controllers}))
    listener.stdin.close()
    assert listener.stdout.readline().strip() == "ready"
    topics = [f"/{controller}/command" for controller in controllers]  # no gripper listens here
    command = ["rosbag", "play", "--quiet", "--wait-for-subscribers", str(bag), "--topics", *topics]
    subprocess.run(command, env=ros, check=True, timeout=1800, stdin=subprocess.DEVNULL, capture_output=True)
    assert listener.wait(timeout=1800) == 0
    listener.stdout.close()
    return json.loads(out.read_text())


@needs_ros
def test_a_played_bag_brings_every_point_and_the_robot_to_the_planned_pose(
    plan_folder: Path, ros: dict[str, str], tmp_path: Path
) -> None:
    out = plan_folder
    poses = {arm.controller: dict(zip(arm.joints, arm.initial.tolist(), strict=True)) for arm in load("hironx").arms}
    result = heard(out / "joint_trajectory.bag", poses, ros, tmp_path / "heard.json")
    wanted = json.loads((out / "joint_trajectory.json").read_text())["topics"]
    assert set(wanted) == {"/larm_controller/command", "/rarm_controller/command"}
    for topic, sent in wanted.items():
        got = result[topic.split("/")[1]]
        assert got["joint_names"] == sent["joint_names"]
        assert [point["positions"] for point in got["points"]] == [point["positions"] for point in sent["points"]]
        received, written = ([point["time_from_start"] for point in each["points"]] for each in (got, sent))
        assert np.allclose(received, written, rtol=0, atol=1e-9)
        assert got["speed"] < 1.0
        last = dict(zip(sent["joint_names"], sent["points"][-1]["positions"], strict=True))
        assert got["pose"] == last


@needs_ros
def test_a_robot_that_is_elsewhere_is_not_made_to_jump(plan_folder: Path, ros: dict[str, str], tmp_path: Path) -> None:
    out = plan_folder
    poses = {
        arm.controller: dict(zip(arm.joints, (arm.initial + 0.5).tolist(), strict=True)) for arm in load("hironx").arms
    }
    result = heard(out / "joint_trajectory.bag", poses, ros, tmp_path / "heard.json")
    assert all(entry["speed"] < 1.0 for entry in result.values())


def points(message: Any) -> tuple[np.ndarray, np.ndarray]:
    times = [point.time_from_start.sec + 1e-9 * point.time_from_start.nanosec for point in message.points]
    return np.array(times), np.array([point.positions for point in message.points])


@pytest.mark.parametrize("name", ["joint_trajectory.bag", "joint_trajectory_ros2"])
def test_both_bags_hold_the_rows_of_the_table(plan_folder: Path, name: str) -> None:
    from rosbags.highlevel import AnyReader

    out = plan_folder
    header = (out / "joint_trajectory.csv").read_text().split("\n", 1)[0].split(",")
    table = np.loadtxt(out / "joint_trajectory.csv", delimiter=",", skiprows=1)
    topics = set()
    ending = "command" if name.endswith(".bag") else "joint_trajectory"
    with AnyReader([out / name], default_typestore=typestore("ROS2_HUMBLE")) as reader:
        of_arms = [connection for connection in reader.connections if connection.topic.endswith(f"controller/{ending}")]
        for connection, _, raw in reader.messages(of_arms):
            message: Any = reader.deserialize(raw, connection.msgtype)
            times, angles = points(message)
            rows = np.searchsorted(table[:, 0], times - 1e-4)
            columns = [header.index(joint) for joint in message.joint_names]
            assert np.allclose(table[rows, 0], times, atol=1e-6)
            assert np.allclose(table[rows][:, columns], angles, atol=1e-8)
            assert times[0] > 0 and np.allclose(angles[0], table[0, columns])
            topics.add(connection.topic)
    assert topics == {f"/larm_controller/{ending}", f"/rarm_controller/{ending}"}


def test_the_ros2_bag_is_one_mcap(plan_folder: Path) -> None:
    assert [path.name for path in plan_folder.rglob("*.mcap")] == ["joint_trajectory_ros2.mcap"]


def test_play_pattern_times_are_from_point_to_point(plan_folder: Path) -> None:
    out = plan_folder
    pattern = json.loads((out / "play_pattern.json").read_text())["groups"]
    trajectory = json.loads((out / "joint_trajectory.json").read_text())["topics"]
    for group in ("larm", "rarm"):
        sent = trajectory[f"/{group}_controller/command"]["points"]
        assert pattern[group]["jointangles"] == [point["positions"] for point in sent]
        assert np.allclose(np.cumsum(pattern[group]["tm"]), [point["time_from_start"] for point in sent], atol=1e-5)
        assert min(pattern[group]["tm"]) > 0
