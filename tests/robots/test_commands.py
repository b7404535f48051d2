"""Commands to the grippers and the segments of a motion, in all exports; the motion slower and above the table."""

from __future__ import annotations

import csv
import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from tatamu.base.errors import InputError
from tatamu.robots import RobotPlan, load, plan_fold, save
from tatamu.robots.arm import RosNames
from tatamu.robots.exports import GRIPPER, trajectory_json, typestore, write_goals, write_ros1, write_ros2
from tatamu.robots.motion import Pace
from tatamu.robots.planfile import Planned
from tatamu.study.folder import ResultFolder
from tests.robots.arms import pair_of, urdf

MD5 = "680acaff79486f017132a7f198d40f08"
"""Of control_msgs/GripperCommand in ROS 1 (docs.ros.org/en/noetic/api/control_msgs)."""
PLACE = (0.0, 0.0, 0.0)


@pytest.fixture
def plan(panda_plan: RobotPlan) -> RobotPlan:
    return panda_plan


def as_plan(out: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((out / "plan.json").read_text())
    return found


def table(out: Path) -> tuple[list[str], np.ndarray]:
    with open(out / "joint_trajectory.csv") as file:
        header, *rows = list(csv.reader(file))
    return header, np.array(rows, dtype=float)


def test_each_gripper_opens_closes_and_opens_at_the_events(plan_folder: Path) -> None:
    plan = as_plan(plan_folder)
    events = {(event["arm"], event["event"]): event["time"] for event in plan["events"]}
    for arm in ("larm", "rarm"):
        first, close, release = [command for command in plan["gripper_commands"] if command["arm"] == arm]
        assert first["time"] == 0 and first["width"] == release["width"] > close["width"]
        assert (close["time"], release["time"]) == (events[arm, "close"], events[arm, "open"])
        assert min(command["force"] for command in (first, close, release)) > 0


def test_json_csv_and_lists_of_hrpsys_hold_the_same_commands(plan_folder: Path) -> None:
    commands = as_plan(plan_folder)["gripper_commands"]
    assert json.loads((plan_folder / "joint_trajectory.json").read_text())["gripper_commands"] == commands
    with open(plan_folder / "gripper_commands.csv") as file:
        rows = list(csv.DictReader(file))
    assert [{name: row[name] if name == "arm" else float(row[name]) for name in row} for row in rows] == commands
    hands = json.loads((plan_folder / "play_pattern.json").read_text())["hands"]
    assert [(hand["hand"], hand["width"]) for hand in hands] == [
        (command["arm"].replace("arm", "hand"), pytest.approx(1e3 * command["width"])) for command in commands
    ]


@pytest.mark.parametrize("name", ["joint_trajectory.bag", "joint_trajectory_ros2"])
def test_both_bags_send_each_command_when_it_is_due(plan_folder: Path, name: str) -> None:
    from rosbags.highlevel import AnyReader

    commands = as_plan(plan_folder)["gripper_commands"]
    with AnyReader([plan_folder / name], default_typestore=typestore("ROS2_HUMBLE")) as reader:
        sent: list[tuple[str, int, Any]] = [
            (connection.topic, time, reader.deserialize(raw, connection.msgtype))
            for connection, time, raw in reader.messages()
        ]
    start = next(time for topic, time, _ in sent if topic.startswith("/larm_controller/"))
    heard = [(topic, time, message) for topic, time, message in sent if "gripper" in topic]
    assert len(heard) == len(commands) == 6
    for command in commands:
        of_arm = [(time, message) for topic, time, message in heard if topic == f"/{command['arm']}_gripper/command"]
        at, message = min(of_arm, key=lambda each: abs((each[0] - start) / 1e9 - command["time"]))
        assert (at - start) / 1e9 == pytest.approx(command["time"], abs=1e-6)
        assert (message.position, message.max_effort) == (command["width"], command["force"])


def test_the_message_of_grippers_is_that_of_ros() -> None:
    assert typestore("ROS1_NOETIC").generate_msgdef(GRIPPER)[1] == MD5


def test_the_robot_is_at_rest_where_a_player_may_stop(plan_folder: Path) -> None:
    plan, (_, rows) = as_plan(plan_folder), table(plan_folder)
    times, angles = rows[:, 0], rows[:, 1:]
    speed = np.abs(np.diff(angles, axis=0)).max(axis=1) / np.diff(times)
    assert [segment["then"] for segment in plan["segments"]] == ["close", "open", ""]
    for segment, event in zip(plan["segments"], ("close", "open"), strict=False):
        end = segment["start"] + segment["duration"]
        assert end == pytest.approx(next(each["time"] for each in plan["events"] if each["event"] == event), abs=2e-6)
        assert speed[np.searchsorted(times, end) + 1] < 1e-6


def test_the_goals_of_a_player_are_the_motion(plan_folder: Path) -> None:
    plan, (header, rows) = as_plan(plan_folder), table(plan_folder)
    goals = plan_folder / "goals"
    steps = json.loads((goals / "steps.json").read_text())["steps"]
    done = [step["do"] + step.get("segment", step.get("event", step.get("before", ""))) for step in steps]
    assert done == [
        *("gripopen", "moveapproach", "stopclose", "gripclose", "movefold", "stopopen", "gripopen", "moveleave")
    ]
    for segment, step in zip(plan["segments"], [step for step in steps if step["do"] == "move"], strict=True):
        assert set(step["goals"]) == {f"/{arm}_controller/follow_joint_trajectory" for arm in ("larm", "rarm")}
        for name in step["goals"].values():
            trajectory = json.loads((goals / name).read_text())["trajectory"]
            columns = [header.index(joint) for joint in trajectory["joint_names"]]
            points = trajectory["points"]
            times = [point["time_from_start"]["sec"] + 1e-9 * point["time_from_start"]["nanosec"] for point in points]
            assert times[0] > 0 and np.diff(times).min() > 0
            assert points[-1]["velocities"] == [0.0] * len(columns)
            curve = CubicHermiteSpline(
                times, [point["positions"] for point in points], [point["velocities"] for point in points]
            )
            inside = (rows[:, 0] >= segment["start"] + times[0]) & (rows[:, 0] <= segment["start"] + times[-1])
            driven = curve(rows[inside, 0] - segment["start"])
            assert np.abs(driven - rows[inside][:, columns]).max() < 2e-4


def test_controllers_have_the_names_of_the_description(plan: RobotPlan, tmp_path: Path) -> None:
    robot = plan.task.robot
    names = [f"left_fr3_joint{number}" for number in range(1, 8)]
    ros = RosNames(controller="left/arm_controller", gripper="left/hand", joints=names)
    named = replace(plan, task=replace(plan.task, robot=replace(robot, larm=replace(robot.larm, ros=ros))))
    write_ros1(named, tmp_path / "motion.bag")
    write_ros2(named, tmp_path / "motion")
    write_goals(named, tmp_path / "goals")
    from rosbags.highlevel import AnyReader

    for bag, ending in (("motion.bag", "command"), ("motion", "joint_trajectory")):
        with AnyReader([tmp_path / bag], default_typestore=typestore("ROS2_HUMBLE")) as reader:
            topics = {connection.topic for connection in reader.connections}
            assert topics == {
                f"/left/arm_controller/{ending}",
                f"/rarm_controller/{ending}",
                "/left/hand/command",
                "/rarm_gripper/command",
            }
    goal = json.loads((tmp_path / "goals" / "2-fold" / "left.arm_controller.json").read_text())
    assert goal["trajectory"]["joint_names"] == names
    assert trajectory_json(named)["topics"]["/left/arm_controller/command"]["joint_names"] == names


def _folder(plan: RobotPlan) -> Path:
    assert isinstance(plan.task.source, ResultFolder)
    return plan.task.source.path


def test_a_slower_plan_is_the_same_motion_at_a_fraction_of_the_speed(plan: RobotPlan) -> None:
    slow = plan_fold(_folder(plan), load("panda-pair"), place=PLACE, pace=Pace(speed_scale=0.5))
    assert slow.motion.parts[-1].start == pytest.approx(2 * plan.motion.parts[-1].start)
    for one, other in zip(plan.events, slow.events, strict=True):
        assert other.time == pytest.approx(2 * one.time, abs=1e-5)
    for one_command, other_command in zip(plan.gripper_commands, slow.gripper_commands, strict=True):
        assert other_command.time == pytest.approx(2 * one_command.time, abs=1e-5)
    rows = np.arange(0, len(plan.motion.times) - 1, 50)
    assert np.allclose(slow.motion.angles[2 * rows], plan.motion.angles[rows], atol=1e-9)
    for name, order in (("joint_speed", 1), ("joint_acceleration", 2), ("tool_speed", 1)):
        assert slow.checks[name].value == pytest.approx(plan.checks[name].value / 2**order, rel=0.02)
    scaling, slower = plan.checks["time_scaling"], slow.checks["time_scaling"]
    assert (slower.value, slower.limit) == pytest.approx((2 * scaling.value, 2 * scaling.limit))


def test_a_plan_that_hovers_is_the_motion_above_the_table_with_open_jaws(plan: RobotPlan, tmp_path: Path) -> None:
    above = plan_fold(_folder(plan), load("panda-pair"), place=PLACE, hover=0.10)
    assert (above.task.table, above.task.placement.z) == (plan.task.table, pytest.approx(plan.task.table + 0.10))
    assert above.checks["distance_to_the_table"].value > plan.checks["distance_to_the_table"].value + 0.05
    assert above.events == () and {command.width for command in above.gripper_commands} == {
        arm.jaw.opening for arm in above.task.robot.arms
    }
    save(above, tmp_path / "plan")
    planned = Planned.load(tmp_path / "plan")
    assert planned.plan.hover == 0.10 and planned.event("larm", "open") > planned.event("larm", "close") > 0
    steps = json.loads((tmp_path / "plan" / "goals" / "steps.json").read_text())["steps"]
    assert [step["do"] for step in steps] == ["grip", "move", "stop", "move", "stop", "move"]


def test_a_plan_without_events_is_refused_unless_it_hovers(plan_folder: Path, tmp_path: Path) -> None:
    shutil.copytree(plan_folder, tmp_path / "plan")
    content = as_plan(tmp_path / "plan")
    (tmp_path / "plan" / "plan.json").write_text(json.dumps({**content, "events": []}))
    with pytest.raises(InputError, match="events: must contain one close and one open for each arm"):
        Planned.load(tmp_path / "plan")
    (tmp_path / "plan" / "plan.json").write_text(json.dumps({**content, "events": [], "hover": 0.1, "segments": []}))
    with pytest.raises(InputError, match="segments: must be approach, fold and leave"):
        Planned.load(tmp_path / "plan")


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("jaw = { force = 0 }", "larm.jaw.force: Input should be greater than 0"),
        ('ros = { controller = "left arm" }', "larm.ros.controller: "),
        ('ros = { joints = ["a", "b"] }', r"larm: ros.joints must have one value for each of 6 joints, given 2"),
        ("lerobot = { open = 100 }", "larm.lerobot: open and closed must be given together"),
        ('lerobot = { unit = "turns" }', "larm.lerobot.unit: "),
    ],
)
def test_wrong_names_and_widths_are_one_line(tmp_path: Path, more: str, message: str) -> None:
    (tmp_path / "arm.urdf").write_text(urdf())
    with pytest.raises(InputError, match=message):
        load(str(pair_of(tmp_path, "arm.urdf", arm=more)))
