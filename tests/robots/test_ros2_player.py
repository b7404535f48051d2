"""The player of examples/ros2: messages of ROS 2 Humble's types, steps in order, and no arm that goes on alone."""

from __future__ import annotations

import importlib.util
import json
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tatamu.robots.exports import GRIPPER, typestore

FOLLOW = "control_msgs/msg/FollowJointTrajectoryGoal"
TOLERANCE = "control_msgs/msg/JointTolerance"
DEFINITIONS = {
    TOLERANCE: "string name\nfloat64 position\nfloat64 velocity\nfloat64 acceleration\n",
    FOLLOW: (
        "trajectory_msgs/JointTrajectory trajectory\n"
        "trajectory_msgs/MultiDOFJointTrajectory multi_dof_trajectory\n"
        "control_msgs/JointTolerance[] path_tolerance\n"
        "control_msgs/JointTolerance[] goal_tolerance\n"
        "builtin_interfaces/Duration goal_time_tolerance\n"
    ),
    "control_msgs/msg/GripperCommandGoal": "control_msgs/GripperCommand command\n",
}
"""Goals of the actions as messages: control_msgs of ROS 2 Humble, without the tolerances by component."""


@pytest.fixture(scope="module")
def player() -> Any:
    path = Path(__file__).parents[2] / "examples" / "ros2" / "play_plan.py"
    spec = importlib.util.spec_from_file_location("play_plan", path)
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def store() -> Any:
    from rosbags.typesys import get_types_from_msg

    found = typestore("ROS2_HUMBLE")
    for name, text in DEFINITIONS.items():
        found.register(get_types_from_msg(text, name))
    return found


def empty(store: Any, kind: str) -> Any:
    """A message with the defaults that ROS 2 gives."""
    from rosbags.interfaces import Nodetype

    values = {}
    for name, (node, of) in store.fielddefs[kind][1]:
        if node == Nodetype.NAME:
            values[name] = empty(store, of)
        elif node == Nodetype.BASE:
            values[name] = "" if of[0] == "string" else 0
        else:
            values[name] = np.empty(0) if of[0][1][0] == "float64" else []
    return store.types[kind](**values)


def messages(store: Any) -> Any:
    """The classes that the player uses: as in ROS 2, they take some fields by name and have defaults for the rest."""

    def made(kind: str) -> Any:
        def make(**fields: Any) -> Any:
            message = empty(store, kind)
            for name, value in fields.items():
                assert hasattr(message, name), f"{kind} has no field {name}"
                setattr(message, name, np.array(value, float) if isinstance(value, list) else value)
            return message

        return make

    return SimpleNamespace(
        Duration=made("builtin_interfaces/msg/Duration"),
        JointTrajectoryPoint=made("trajectory_msgs/msg/JointTrajectoryPoint"),
        FollowJointTrajectory=SimpleNamespace(Goal=made(FOLLOW)),
        GripperCommand=SimpleNamespace(Goal=made("control_msgs/msg/GripperCommandGoal")),
    )


def test_its_trajectories_are_messages_of_ros_2(plan_folder: Path, player: Any, store: Any) -> None:
    file = plan_folder / "goals" / "2-fold" / "larm_controller.json"
    fields = json.loads(file.read_text())
    start = store.types["builtin_interfaces/msg/Time"](sec=5, nanosec=7)
    goal = player.follow_goal(messages(store), fields, start)
    back = store.deserialize_cdr(store.serialize_cdr(goal, FOLLOW), FOLLOW)
    assert back.trajectory.header.stamp.sec == 5
    assert back.trajectory.joint_names == fields["trajectory"]["joint_names"]
    assert len(back.trajectory.points) == len(fields["trajectory"]["points"]) > 100
    for read, given in zip(back.trajectory.points, fields["trajectory"]["points"], strict=True):
        assert read.positions.tolist() == given["positions"] and read.velocities.tolist() == given["velocities"]
        assert vars(read.time_from_start) | {} == {**vars(read.time_from_start), **given["time_from_start"]}


def test_its_gripper_commands_are_messages_of_ros_2(player: Any, store: Any) -> None:
    goal = player.grip_goal(messages(store), {"command": {"position": 0.04, "max_effort": 20}})
    raw = store.serialize_cdr(goal, "control_msgs/msg/GripperCommandGoal")
    back = store.deserialize_cdr(raw, "control_msgs/msg/GripperCommandGoal")
    assert (back.command.position, back.command.max_effort) == (0.04, 20.0) and GRIPPER in store.types


class Recorder:
    """A robot that notes what it is told."""

    def __init__(self) -> None:
        self.done: list[str] = []

    def move(self, goals: Mapping[str, Any]) -> None:
        assert len(goals) == 2 and all("trajectory" in goal for goal in goals.values())
        self.done.append("move")

    def grip(self, goals: Mapping[str, Any], wait: float) -> None:
        assert wait > 0
        self.done.append("closed" if next(iter(goals.values()))["command"]["position"] == 0 else "opened")


def test_it_stops_before_the_jaws_close_and_before_they_open(plan_folder: Path, player: Any) -> None:
    robot, asked = Recorder(), []

    def ask(text: str) -> bool:
        asked.append((text, len(robot.done)))
        return True

    assert player.play(plan_folder, robot, ask)
    assert robot.done == ["opened", "move", "closed", "move", "opened", "move"]
    assert asked == [("The jaws close next.", 2), ("The jaws open next.", 4)]
    robot = Recorder()
    assert not player.play(plan_folder, robot, lambda text: "open" not in text)
    assert robot.done == ["opened", "move", "closed", "move"]


class Handle:
    """A goal that was accepted; it ends well, or not."""

    def __init__(self, code: int, cancelled: list[str], name: str) -> None:
        self.accepted, self._code, self._name, self._cancelled = True, code, name, cancelled

    def get_result_async(self) -> Any:
        result = SimpleNamespace(error_code=self._code, error_string="")
        return SimpleNamespace(status=4, result=result)

    def cancel_goal_async(self) -> Any:
        self._cancelled.append(self._name)


def test_if_one_arm_fails_all_are_cancelled(player: Any, monkeypatch: pytest.MonkeyPatch, store: Any) -> None:
    robot: Any = object.__new__(player.Ros2Robot)
    cancelled: list[str] = []
    handles = {"left": Handle(0, cancelled, "left"), "right": Handle(-4, cancelled, "right")}
    robot._msg = messages(store)
    robot._ros = SimpleNamespace(duration=SimpleNamespace(Duration=lambda seconds: 0))
    robot._node = SimpleNamespace(get_clock=lambda: SimpleNamespace(now=lambda: Moment()))
    monkeypatch.setattr(robot, "_send", lambda kind, goals: handles)
    monkeypatch.setattr(robot, "_wait", lambda future: future)
    with pytest.raises(RuntimeError, match="right: failed"):
        robot.move({})
    assert cancelled == ["left", "right"]


class Moment:
    """A time of ROS 2's clock."""

    def __add__(self, other: object) -> Any:
        return SimpleNamespace(to_msg=lambda: None)
