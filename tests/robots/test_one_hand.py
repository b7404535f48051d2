"""A fold with one hand: one arm folds, the other one stays as it stands at the start."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import InputError
from tatamu.folding.trial_scene import scene_of
from tatamu.robots import ReachConstraint, RobotPlan, load, plan_fold, save
from tatamu.robots.episode import state
from tatamu.robots.hands import HandMotion
from tatamu.robots.placement import Placement
from tatamu.robots.planfile import Planned
from tatamu.robots.reach import search
from tatamu.robots.refold import refold
from tatamu.robots.rehearsal import rehearse
from tests.robots.folds import exact, manipulation
from tests.test_press import scene as pressed_scene
from tests.test_press import task

PLACE = (0.26, 0.284, -0.873)


def one_hand(path: Path, **fold: float) -> Path:
    """The folder of a fold by the left hand, along the middle."""
    made: dict[str, Any] = manipulation(**{"span": 0.3, "width": 0.0, "height": 0.12, **fold})
    made["arms"] = made["arms"][:1]
    del made["via_points"]["right"]
    path.mkdir(parents=True)
    (path / "manipulation.json").write_text(json.dumps(made))
    return path


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> RobotPlan:
    return plan_fold(one_hand(tmp_path_factory.mktemp("one") / "fold"), load("hironx"), PLACE, table_height=-0.035)


def test_one_arm_folds_and_the_other_one_stands_still(plan: RobotPlan) -> None:
    robot = plan.task.robot
    assert robot.alone == "larm" and [arm.name for arm in robot.folding] == ["larm"]
    still = plan.motion.angles[:, [robot.columns[name] for name in robot.rarm.joints]]
    moving = plan.motion.angles[:, [robot.columns[name] for name in robot.larm.joints]]
    assert (still == robot.rarm.initial).all() and np.ptp(moving, axis=0).max() > 0.5
    assert "distance_between_arms" in plan.checks and all(check.ok for check in plan.checks.values())


def test_the_files_name_the_arm_that_folds(plan: RobotPlan, tmp_path: Path) -> None:
    save(plan, tmp_path / "plan")
    planned = Planned.load(tmp_path / "plan")
    assert planned.arms == ("larm",) and list(planned.plan.jaws) == ["larm"]
    assert [(event.arm, event.event) for event in planned.plan.events] == [("larm", "close"), ("larm", "open")]
    assert planned.plan.via_points is not None and planned.plan.via_points.rarm is None
    assert sorted(path.name for path in (tmp_path / "plan" / "goals" / "2-fold").iterdir())[0] == "larm_controller.json"
    assert not (tmp_path / "plan" / "goals" / "2-fold" / "rarm_controller.json").exists()
    values = state(plan, plan.motion.times[::50])
    gripper = len(plan.task.robot.larm.joints)
    assert np.ptp(values[:, gripper]) > 0.01 and np.ptp(values[:, 2 * gripper + 1]) == 0


def test_either_arm_may_fold_alone() -> None:
    both = exact()
    hand = both.hands[0]
    assert hand.control_points is not None
    mirrored = (Placement(0.26, side * 0.284, -0.035, -side * 0.873, 0.5) for side in (1, -1))
    for robot, place in zip(load("hironx").ways(1)[:2], mirrored, strict=True):
        shifted = replace(both, hands=(replace(hand, position=hand.position * [1, 0, 1]),))
        assert search(robot, HandMotion.exact(shifted), [place], fine=True)[0].quality >= 0
    assert ReachConstraint(load("hironx"))(shifted) >= 0


def test_a_fold_that_is_pressed_is_refused(tmp_path: Path) -> None:
    one_hand(tmp_path / "fold")
    pressed_scene(tmp_path, "weight = 5.0").save(tmp_path / "fold" / "scene.json")
    with pytest.raises(
        InputError,
        match=r"scene\.json: bodies: must be hands only, given a pressing plate; robots cannot press creases",
    ):
        HandMotion.load(tmp_path / "fold")


@pytest.mark.slow
def test_a_fold_by_one_arm_is_rehearsed_as_it_was_planned(tmp_path: Path) -> None:
    made = task(tmp_path, "", size=(0.2, 0.3), material="polyester", hands=1)
    fold = made.fold
    middle = int(fold.candidates // 2)
    arched = made.manipulation({"x1": 0.05, "z1": 0.12, "x2": 0.24, "z2": 0.12, "g1": middle, "g2": 0})
    (tmp_path / "fold").mkdir()
    arched.save(tmp_path / "fold" / "manipulation.json")
    scene_of(fold, arched).save(tmp_path / "fold" / "scene.json")
    save(plan_fold(tmp_path / "fold", load("hironx")), tmp_path / "plan")
    done = rehearse(Planned.load(tmp_path / "plan"))
    assert done.tool_error < 0.003 and done.contacts == [] and done.tools.shape[0] == 1
    again = refold(done, "native")
    assert again is not None and again.apart.mean() < 0.02
