"""Hands stay out of the simulated cloth, in the search for placements as in the checks; plans of results in memory."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tatamu.api import FoldPlan, plan_for
from tatamu.robots import Robot, load, plan_fold, save
from tatamu.robots.cloth import clear_holds
from tatamu.robots.hands import HandMotion
from tatamu.robots.placement import Grip, Hold, Placement, holds_of
from tatamu.robots.reach import search
from tatamu.simulation.rollout import Rollout
from tatamu.study.result import Result
from tests.fabricated import write_fold
from tests.robots.folds import exact

PLACE = Placement(0.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load("panda-pair")


def behind(robot: Robot, hands: HandMotion, hold: Hold, distance: float, aside: float = 0.1) -> Rollout:
    """Cloth that is a point behind the left fingertips and aside, where the jaws open to, and moves with the hand."""
    times = np.linspace(0.0, hands.times[-1], 61)
    path = hands.at(times)[0]
    rotation, offset, _ = Grip.of(robot.larm.jaw, path).tool(PLACE.yaw, hold)
    points = path + offset - distance * rotation[:, 2] + aside * rotation[:, 1]
    return Rollout(times, points[:, None], np.zeros((0, 3), dtype=int), {}, {})


def test_an_orientation_in_which_the_hand_enters_the_cloth_is_left_out(robot: Robot) -> None:
    hands = HandMotion.exact(exact(span=0.5, width=0.4))
    holds = holds_of(robot.larm, fine=True)
    steep, turned = Hold(np.radians(30)), Hold(np.radians(30), -np.radians(60))
    assert clear_holds(robot, robot.larm, hands, [steep, turned], None).all()
    cloth = behind(robot, hands, steep, 0.08)  # in the palm, which begins 0.047 m behind the fingertips
    assert clear_holds(robot, robot.larm, hands, [steep, turned], cloth).tolist() == [False, True]
    assert clear_holds(robot, robot.rarm, hands, [steep, turned], cloth).all()
    at_the_fingers = behind(robot, hands, steep, 0.03, 0.0)  # which the fingers hold or lift
    assert clear_holds(robot, robot.larm, hands, holds, at_the_fingers).all()


def test_the_search_takes_an_orientation_that_stays_out_of_the_cloth(robot: Robot) -> None:
    hands = HandMotion.exact(exact(span=0.5, width=0.4))
    (free,) = search(robot, hands, [PLACE], fine=True)
    cloth = behind(robot, hands, free.holds[0], 0.08)
    (found,) = search(robot, hands, [PLACE], fine=True, cloth=cloth)
    assert free.is_good and found.is_good
    assert not clear_holds(robot, robot.larm, hands, [free.holds[0]], cloth)[0]
    assert clear_holds(robot, robot.larm, hands, [found.holds[0]], cloth)[0]


def _check_copies(plan: FoldPlan, folder: Path) -> None:
    for copied in (copy.copy(plan), copy.deepcopy(plan), replace(plan, plan=copy.deepcopy(plan.plan))):
        assert repr(copied) == repr(plan) and copied.plan.task.robot.model is plan.plan.task.robot.model
    copy.deepcopy(plan).export(folder)
    assert (folder / "plan.json").is_file()
    assert copy.deepcopy(plan.plan.task.robot) is plan.plan.task.robot
    with pytest.raises(TypeError, match="panda-pair: a robot and its plans cannot be pickled; write a plan"):
        pickle.dumps(plan)


def test_a_result_in_memory_has_the_plan_of_its_folder(tmp_path: Path, robot: Robot) -> None:
    loaded = Result.load(write_fold(tmp_path / "fold", spacing=0.08, frames=24))
    place = (0.0, 0.0, 0.0)
    save(plan_fold(tmp_path / "fold", robot, place), tmp_path / "plan")
    plan_for(replace(loaded, folder=None), "panda-pair", place=place).export(tmp_path / "memory")
    _check_copies(plan_for(loaded, robot="panda-pair", place=place), tmp_path / "copy")
    for name in ("plan.json", "joint_trajectory.csv", "fold/manipulation.json", "fold/rollout.npz", "fold/scene.json"):
        assert (tmp_path / "memory" / name).read_bytes() == (tmp_path / "plan" / name).read_bytes()
