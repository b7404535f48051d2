"""Robot plans of folds that know the hands' fingers: whole fingers are obstacles, and come out before they rise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco")

from tatamu import InputError
from tatamu.robots import RobotPlan, load, plan_fold, save
from tatamu.robots.chain import Chain
from tatamu.robots.clearance import Clearance
from tatamu.robots.hands import HandMotion
from tatamu.robots.paths import OUT, tool_poses
from tatamu.robots.planned import Planned
from tatamu.robots.pose import into
from tatamu.robots.rehearsal import rehearse
from tests.robots.folds import folder

LIFT = 0.012


def planned(path: Path, lift: float) -> RobotPlan:
    return plan_fold(folder(path, lift=lift), load("hironx"), place=(0.28, 0.0, 0.0), table_height=-0.06)


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> RobotPlan:
    return planned(tmp_path_factory.mktemp("fingers"), LIFT)


def tools(plan: RobotPlan, part: str) -> np.ndarray:
    """Positions of both tools in the fold's frame (2, n, 3) during a part of the motion."""
    robot = plan.task.robot
    chains = tuple(Chain.of(robot, arm) for arm in robot.arms)
    poses = tool_poses(robot, chains, plan.motion.angles[plan.motion.rows(part)])
    return np.array([into(plan.task.placement.matrix, points) for points in poses[:, :, :3, 3]])


def test_hands_come_out_from_under_the_hem_before_they_rise(plan: RobotPlan) -> None:
    names = [part.name for part in plan.motion.parts]
    assert names[names.index("open") + 1 : names.index("raise")] == ["withdraw"]
    out = tools(plan, "withdraw")
    moved = out[:, -1] - out[:, 0]
    # the hem was carried along x, and now faces that way
    assert moved[:, 0] == pytest.approx(OUT, abs=1e-3) and np.abs(moved[:, 1]).max() < 1e-3
    assert np.ptp(out[:, :, 2], axis=1).max() < 1e-3, "no finger lifts the hem"
    up = tools(plan, "raise")
    assert np.abs(up[:, 0] - out[:, -1]).max() < 1e-3 and (up[:, -1, 2] - up[:, 0, 2]).min() > 0.04


def test_the_whole_finger_is_an_obstacle(plan: RobotPlan) -> None:
    distance = plan.checks["distance_to_the_table"]
    at_the_grasp = tools(plan, "close")[:, 0, 2].min()
    assert at_the_grasp == pytest.approx(0.0005 + LIFT, abs=1e-3)
    assert distance.ok and distance.limit <= distance.value <= at_the_grasp + 1e-3
    robot = plan.task.robot
    row = int(plan.motion.rows("close")[0])
    assert Clearance(robot).lowest(plan.motion.angles[row]) <= plan.task.placement.z + at_the_grasp + 1e-3


def test_a_fold_that_knows_no_fingers_is_planned_as_before(fold: Path, tmp_path: Path) -> None:
    known = plan_fold(fold, load("hironx"), place=(0.28, 0.0, 0.0), table_height=-0.06)
    assert "withdraw" not in [part.name for part in known.motion.parts]
    lowest = Clearance(known.task.robot).lowest(known.motion.angles[int(known.motion.rows("close")[0])])
    assert lowest > known.task.placement.z + 0.005, "the outermost centimetre is left out"


def test_fingers_too_thin_for_the_robots_hand_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        planned(tmp_path, 0.0005)


def test_the_rehearsed_hands_touch_no_table(plan: RobotPlan, tmp_path: Path) -> None:
    save(plan, tmp_path / "plan")
    rehearsal = rehearse(Planned.load(tmp_path / "plan"))
    assert not [contact for contact in rehearsal.contacts if "table" in contact.links]


def test_the_lift_is_read_from_the_file(tmp_path: Path) -> None:
    assert HandMotion.load(folder(tmp_path / "a", lift=LIFT)).lift == pytest.approx(LIFT)
    assert HandMotion.load(folder(tmp_path / "b")).lift == 0.0
