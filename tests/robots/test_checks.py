from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from tatamu.robots import RobotPlan
from tatamu.robots.checks import Checks, failing
from tatamu.robots.motion import Motion
from tatamu.robots.paths import Paths

Change = Callable[[RobotPlan, np.ndarray], None]


@pytest.fixture
def plan(near_plan: RobotPlan) -> RobotPlan:
    return near_plan


def checked(plan: RobotPlan, change: Change) -> set[str]:
    """Names of the checks that fail when the joint angles are changed."""
    angles = plan.motion.angles.copy()
    change(plan, angles)
    motion = Motion(plan.motion.times, angles, plan.motion.parts)
    checks = Checks(plan.task, Paths(plan.task), motion).all()
    return {name for name, check in checks.items() if not check.ok}


def middle(plan: RobotPlan) -> np.ndarray:
    rows = plan.motion.rows("fold")
    return rows[len(rows) // 3 : 2 * len(rows) // 3]


def bump(plan: RobotPlan, angles: np.ndarray) -> None:
    rows = middle(plan)
    angles[rows, plan.task.robot.columns["LARM_JOINT0"]] += 0.01 * np.sin(np.linspace(0, np.pi, len(rows))) ** 2


def twist(plan: RobotPlan, angles: np.ndarray) -> None:
    rows = middle(plan)
    angles[rows, plan.task.robot.columns["LARM_JOINT5"]] += 0.1 * np.sin(np.linspace(0, np.pi, len(rows))) ** 2


def jump(plan: RobotPlan, angles: np.ndarray) -> None:
    angles[middle(plan)[0], plan.task.robot.columns["RARM_JOINT4"]] += 0.02


def beyond(plan: RobotPlan, angles: np.ndarray) -> None:
    angles[middle(plan), plan.task.robot.columns["RARM_JOINT2"]] = 0.0


def inwards(plan: RobotPlan, angles: np.ndarray) -> None:
    angles[middle(plan), plan.task.robot.columns["LARM_JOINT0"]] -= 0.8
    angles[middle(plan), plan.task.robot.columns["RARM_JOINT0"]] += 0.8


def downwards(plan: RobotPlan, angles: np.ndarray) -> None:
    angles[middle(plan), plan.task.robot.columns["LARM_JOINT1"]] += 0.6


def at_the_body(plan: RobotPlan, angles: np.ndarray) -> None:
    angles[middle(plan), plan.task.robot.columns["LARM_JOINT0"]] = -1.5
    angles[middle(plan), plan.task.robot.columns["LARM_JOINT2"]] = -2.7


@pytest.mark.parametrize(
    ("change", "names"),
    [
        (bump, {"tool_path_error"}),
        (twist, {"tool_turn_error"}),
        (jump, {"joint_speed", "joint_acceleration", "tool_speed"}),
        (beyond, {"joint_limit_margin"}),
        (inwards, {"distance_between_arms"}),
        (downwards, {"distance_to_the_table"}),
        (at_the_body, {"distance_to_the_trunk"}),
    ],
)
def test_a_motion_that_breaks_a_rule_is_caught(plan: RobotPlan, change: Change, names: set[str]) -> None:
    assert all(check.ok for check in plan.checks.values())
    assert names <= checked(plan, change)


def test_a_failed_check_says_which_joint_and_which_frame(plan: RobotPlan) -> None:
    angles = plan.motion.angles.copy()
    beyond(plan, angles)
    motion = Motion(plan.motion.times, angles, plan.motion.parts)
    name, check = failing(Checks(plan.task, Paths(plan.task), motion).all()) or ("", None)
    assert name == "joint_limit_margin" and check is not None
    assert "RARM_JOINT2" in check.failed(name) and f"at frame {check.frame}" in check.failed(name)


def test_a_slow_robot_is_refused_when_the_fold_would_be_another(plan: RobotPlan) -> None:
    fold = plan.motion.part("fold")
    slow = replace(fold, timed=replace(fold.timed, duration=20.0))
    parts = tuple(slow if part is fold else part for part in plan.motion.parts)
    motion = Motion(plan.motion.times, plan.motion.angles, parts)
    assert not Checks(plan.task, Paths(plan.task), motion).all()["time_scaling"].ok
