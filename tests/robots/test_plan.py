import csv
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.robots import check_out, load, plan_fold, save
from tatamu.robots.picture import reach_svg
from tatamu.robots.placement import Refused
from tatamu.robots.reach import table_heights
from tests.commands import refused, tatamu
from tests.robots.folds import bezier, folder, manipulation


class Written:
    """A plan's folder as somebody else reads it, with forward kinematics by MuJoCo alone."""

    def __init__(self, out: Path) -> None:
        self.out = out
        self.plan: dict[str, Any] = json.loads((out / "plan.json").read_text())
        with open(out / "joint_trajectory.csv") as file:
            self.header, *rows = list(csv.reader(file))
        self.rows = np.array(rows, dtype=float)
        self.times = self.rows[:, 0]

    def column(self, joint: str) -> np.ndarray:
        return self.rows[:, self.header.index(joint)]

    def event(self, name: str) -> float:
        return next(event["time"] for event in self.plan["events"] if event["event"] == name)

    def tools(self, arm: str, rows: np.ndarray) -> np.ndarray:
        """Tool poses in the fold's frame, shape (n, 4, 4)."""
        model = mujoco.MjModel.from_xml_path(str(self.out / "robot.xml"))
        data = mujoco.MjData(model)
        yaw, xyz = self.plan["task_in_base"]["yaw"], self.plan["task_in_base"]["xyz"]
        X_BF = np.eye(4)
        X_BF[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
        X_BF[:3, 3] = xyz
        found = []
        for row in rows:
            for joint, value in zip(self.header[1:], self.rows[row, 1:], strict=True):
                data.joint(joint).qpos = value
            mujoco.mj_kinematics(model, data)
            link = data.body(self.plan["wrist_frame"][arm])
            X_BW = np.eye(4)
            X_BW[:3, :3], X_BW[:3, 3] = link.xmat.reshape(3, 3), link.xpos
            found.append(np.linalg.inv(X_BF) @ X_BW @ np.array(self.plan["tool_in_wrist"][arm]))
        return np.array(found)


@pytest.fixture(scope="module")
def written(plan_folder: Path) -> Written:
    return Written(plan_folder)


def between(written: Written) -> np.ndarray:
    """Rows from closing to opening."""
    return np.flatnonzero((written.times >= written.event("close")) & (written.times <= written.event("open")))


def test_every_check_holds_and_says_its_figure(written: Written) -> None:
    checks = written.plan["checks"]
    assert len(checks) >= 10
    for check in checks.values():
        assert check["ok"] is True and np.isfinite(check["value"]) and isinstance(check["unit"], str)


@pytest.mark.parametrize(("arm", "hand"), [("larm", 0), ("rarm", 1)])
def test_the_tool_stays_on_the_bezier_while_it_holds_the_cloth(written: Written, arm: str, hand: int) -> None:
    rows = between(written)[::10]
    curve = bezier(np.array(manipulation()["arms"][hand]["control_points"]), np.linspace(0, 1, 4000))
    points = written.tools(arm, rows)[:, :3, 3]
    assert max(np.linalg.norm(curve - point, axis=1).min() for point in points) < 1e-3
    assert np.linalg.norm(points[0] - curve[0]) < 1e-3 and np.linalg.norm(points[-1] - curve[-1]) < 1e-3


@pytest.mark.parametrize("arm", ["larm", "rarm"])
def test_the_tool_keeps_its_orientation_while_it_holds_the_cloth(written: Written, arm: str) -> None:
    turns = written.tools(arm, between(written)[::10])[:, :3, :3]
    cosine = (np.trace(turns @ turns[0].T, axis1=1, axis2=2) - 1) / 2
    assert np.arccos(np.clip(cosine, -1, 1)).max() < 0.01


def test_it_starts_and_ends_at_the_initial_pose(written: Written) -> None:
    initial = np.radians([0.6, 0, -100, -15.2, 9.4, -3.2])
    for row in (0, -1):
        left = [written.column(f"LARM_JOINT{i}")[row] for i in range(6)]
        assert np.allclose(left, initial, atol=1e-6)


def test_joints_stay_within_limits_and_speeds(written: Written) -> None:
    robot = load("hironx")
    assert np.allclose(np.diff(written.times), written.times[1], atol=1e-6)
    for arm in robot.arms:
        for joint, (low, high), speed in zip(arm.joints, robot.limits(arm), arm.planned_speed, strict=True):
            angle = written.column(joint)
            assert low < angle.min() and angle.max() < high
            assert np.abs(np.diff(angle)).max() / written.times[1] <= speed
            assert np.abs(np.diff(angle, n=2)).max() / written.times[1] ** 2 <= 1.0 + 1e-3


def test_it_is_never_faster_than_the_cloth_was(written: Written) -> None:
    via = written.plan["via_points"]
    simulated, driven = np.diff(via["simulated_times"]), np.diff(via["times"])
    assert (driven >= simulated - 1e-3).all()


def test_via_points_are_ten_frames_apart_and_where_the_hands_were(written: Written) -> None:
    via = written.plan["via_points"]
    assert set(np.diff(via["frames"])[:-1]) == {10}
    rows = np.searchsorted(written.times, np.array(via["times"]))
    rows = np.minimum(rows, len(written.times) - 1)
    for arm, hand in (("larm", "left"), ("rarm", "right")):
        wanted = np.array(manipulation()["via_points"][hand])
        assert np.abs(written.tools(arm, rows)[:, :3, 3] - wanted).max() < 2e-3


def test_nothing_of_the_robot_touches_itself_or_the_table(written: Written) -> None:
    model = mujoco.MjModel.from_xml_path(str(written.out / "robot.xml"))
    data = mujoco.MjData(model)
    table = model.geom("tatamu_table").id
    fingers = [[f"{side}arm_finger{number}_tip" for number in (1, 2)] for side in "lr"]
    left, right = ([f"{s.upper()}ARM_JOINT5_Link_hand", *names] for s, names in zip("lr", fingers, strict=True))
    hands = [[model.geom(name).id for name in names] for names in (left, right)]
    for row in range(0, len(written.rows), 40):
        for joint, value in zip(written.header[1:], written.rows[row, 1:], strict=True):
            data.joint(joint).qpos = value
        mujoco.mj_kinematics(model, data)
        for part in (*hands[0], *hands[1]):
            assert mujoco.mj_geomDistance(model, data, part, table, 1.0, None) > 0
        for one in hands[0]:
            for other in hands[1]:
                assert mujoco.mj_geomDistance(model, data, one, other, 1.0, None) > 0.015


def test_fingers_close_before_the_cloth_moves_and_open_after(written: Written) -> None:
    events = written.plan["events"]
    assert [(event["arm"], event["event"]) for event in events] == [
        ("larm", "close"),
        ("rarm", "close"),
        ("larm", "open"),
        ("rarm", "open"),
    ]
    assert written.event("close") < written.plan["via_points"]["times"][0]
    assert written.event("open") > written.plan["via_points"]["times"][-1]


def test_the_picture_is_drawn(written: Written) -> None:
    text = (written.out / "reach.svg").read_text()
    assert text.startswith("<svg") and text.count("<rect") > 20


def test_the_picture_of_a_given_place_is_whole_whatever_the_robot_is_called(fold: Path, tmp_path: Path) -> None:
    robot = replace(load("hironx"), name="R&D <1>")
    plan = plan_fold(fold, robot, place=(0.28, 0.01, 0.02), table_height=-0.06)
    texts = ["".join(text.itertext()) for text in ElementTree.fromstring(reach_svg(plan)).iter() if "text" in text.tag]
    assert any(text.startswith("R&D <1>, from above") for text in texts) and "10 cm" in texts
    assert not any("squares" in text for text in texts)  # none was searched


def test_the_same_fold_gives_the_same_plan(written: Written, fold: Path, tmp_path: Path) -> None:
    save(plan_fold(fold, load("hironx")), tmp_path / "again")
    for name in ("plan.json", "joint_trajectory.csv", "joint_trajectory.bag"):
        assert (tmp_path / "again" / name).read_bytes() == (written.out / name).read_bytes()


@pytest.mark.parametrize(
    ("span", "reason"),
    [
        pytest.param(
            0.8,
            r"[lr]arm cannot follow its hand beyond frame \d+ of the fold, which spans 800 "
            "mm",
            id="too long",
        ),
        pytest.param(0.46, r"(distance .* and .* at|cannot follow its hand at) frame \d+", id="arms would touch"),
    ],
)
def test_a_fold_that_the_arms_cannot_do_is_refused_with_the_reason(tmp_path: Path, span: float, reason: str) -> None:
    with pytest.raises(InputError, match=reason):
        plan_fold(folder(tmp_path / "fold", span=span), load("hironx"))


def test_a_given_place_is_kept(fold: Path) -> None:
    found = plan_fold(fold, load("hironx"), place=(0.28, 0.01, 0.02), table_height=-0.06)
    where = found.task.placement
    assert (where.x, where.y, where.z, where.yaw) == (0.28, 0.01, -0.06, 0.02)


def test_a_place_out_of_reach_is_refused_with_the_frame(fold: Path) -> None:
    with pytest.raises(InputError, match=r"cannot do the fold at this place: .*frame \d+"):
        plan_fold(fold, load("hironx"), place=(0.45, 0.0, 0.0), table_height=-0.06)


def test_a_table_above_the_initial_pose_needs_the_higher_pose(fold: Path) -> None:
    assert plan_fold(fold, load("hironx"), table_height=0.0).task.robot.start == "factory"


def test_a_table_too_high_for_every_pose_is_refused_with_the_highest(fold: Path) -> None:
    robot = load("hironx")
    with pytest.raises(InputError, match=r"must be below (0.\d+) m, because at its pose 'factory'") as error:
        plan_fold(fold, robot, table_height=0.1)
    highest = float(str(error.value).split("below ")[1].split(" m")[0])
    assert table_heights(robot.starting(robot.poses[1]), highest - 0.001) == (highest - 0.001,) * 2
    with pytest.raises(Refused, match="must be below"):
        table_heights(robot.starting(robot.poses[1]), highest + 0.001)


@pytest.mark.parametrize(
    "arguments",
    [
        ("plan", "nowhere", "--out", "out"),
        ("plan", "long", "--out", "out"),
        ("plan", "long", "--robot", "pr2", "--out", "out"),
        ("plan", "long", "--place", "0.3,0", "--out", "out"),
        ("plan", "long", "--table-height", "5", "--out", "out"),
        ("plan", "long", "--out", "notes.txt"),
    ],
)
def test_a_wrong_command_line_is_one_line_and_leaves_nothing(arguments: tuple[str, ...], tmp_path: Path) -> None:
    folder(tmp_path / "long", span=0.8)
    (tmp_path / "notes.txt").write_text("mine")
    result = tatamu(*arguments, cwd=tmp_path)
    assert result.returncode == 2
    *progress, message = result.stderr.strip().splitlines()
    assert message.startswith("tatamu: ") and len(progress) <= 1 and "Traceback" not in result.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["long", "notes.txt"]
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_a_folder_of_somebody_else_is_left_alone(plan_folder: Path, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    with pytest.raises(InputError, match="must be a new folder or the folder of a plan"):
        check_out(tmp_path / "mine")
    check_out(plan_folder)
    check_out(tmp_path / "new")


def test_a_link_to_a_plan_stays_a_link_and_the_folder_one_stands_in_is_refused(
    fold: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "plan").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "plan")
    save(plan_fold(fold, load("hironx")), tmp_path / "link")
    assert (tmp_path / "link").is_symlink() and (tmp_path / "plan" / "plan.json").is_file()
    monkeypatch.chdir(tmp_path / "plan")
    with pytest.raises(InputError, match="current folder"):
        check_out(Path())


def test_a_table_height_that_is_no_height_is_refused_by_its_name(fold: Path, tmp_path: Path) -> None:
    said = refused("plan", str(fold), "--table-height", "nan", "--out", "out", cwd=tmp_path)
    assert "--table-height: must be between -10 and 10 m, given nan" in said


def test_the_command_writes_a_plan_and_its_figures(fold: Path, tmp_path: Path) -> None:
    result = tatamu("plan", str(fold), "--robot", "hironx", "--out", "out", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    assert re.search(r"tool path error +0\.\d+ mm +\(at most 1\)\n", result.stdout)
    assert re.search(r"joint limit margin .* rad +\(at least 0.01\)\n", result.stdout)
    assert (
        re.search(r"time scaling +[\d.]+ +\(at most 5\)\n", result.stdout)
        and (tmp_path / "out" / "plan.json").is_file()
    )
