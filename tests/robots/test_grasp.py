"""How a plan's jaws take the hem: one finger under it, one over it, and out of the turned hem along the tool's axis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tatamu.robots import RobotPlan, load, plan_fold
from tatamu.robots.arm import GAP, Jaw
from tatamu.robots.checks import Checks
from tatamu.robots.folder import plan_file
from tatamu.robots.model import Robot
from tatamu.robots.paths import Paths, tool_poses
from tatamu.robots.placement import LIFT, UNDER, Grip, Hold, Placement, holds_of, tool_paths
from tests.robots.folds import folder

SIDES = ("larm", "rarm")


@pytest.fixture
def plan(near_plan: RobotPlan) -> RobotPlan:
    return near_plan


def tools(plan: RobotPlan, part: str) -> np.ndarray:
    """X_BT of both arms (2, n, 4, 4) during a part of the motion."""
    rows = plan.motion.rows(part)
    return tool_poses(plan.task.robot, Paths(plan.task).chains, plan.motion.angles[rows])


@pytest.mark.parametrize("tilt", [0.2, 0.9])
@pytest.mark.parametrize("heading", [0.0, 2.0])
@pytest.mark.parametrize("flipped", [False, True])
def test_the_jaw_opens_in_the_vertical_plane_across_the_hem(tilt: float, heading: float, flipped: bool) -> None:
    R = Hold(tilt, flipped=flipped).rotation(heading)
    along = np.array([-np.sin(heading), np.cos(heading), 0.0])
    assert np.allclose(R @ R.T, np.eye(3)) and np.linalg.det(R) == pytest.approx(1.0)
    assert np.abs(R[:, 1:].T @ along).max() < 1e-12, "opening and approach are in that plane"
    assert R[2, 2] == pytest.approx(-np.cos(tilt))
    assert R[:2, 2] @ [np.cos(heading), np.sin(heading)] == pytest.approx(np.sin(tilt)), "it comes from outside"
    assert abs(R[2, 1]) == pytest.approx(np.sin(tilt)), "one finger is higher than the other"


def test_the_lower_finger_passes_over_the_table_at_the_gap() -> None:
    """By the corners of the finger's box, written out."""
    jaw, hold = Jaw(thickness=0.0095), Hold(0.4, yaw=0.3)
    R, offset, _ = Grip(jaw, 0.0, 0.0005).tool(0.2, hold)
    tip = 0.0005 + offset[2]
    outer = jaw.opening / 2 + jaw.thickness
    corners = [
        tip + (R @ [x, side * y, -z])[2]
        for x in (-0.014, 0.014)
        for side in (-1, 1)
        for y in (0.006, outer)
        for z in (0.0, 0.03)
    ]
    assert min(corners) == pytest.approx(GAP)


def test_the_tool_comes_down_beside_the_hem_and_leaves_along_its_axis() -> None:
    points = np.array([[-0.2, 0.1, 0.0005], [0.0, 0.1, 0.1], [0.2, 0.1, 0.001]])
    place, hold, jaw = Placement(0.4, 0.0, -0.1, 0.0), Hold(0.3, yaw=-0.2), Jaw()
    X_BT = tool_paths([place], [hold], points, jaw)[0, 0]
    across = np.array([1.0, 0.0, 0.0])
    before, grasp, release, after = X_BT[[0, 1, -2, -1]]
    approach = grasp[:3, 2]
    assert np.allclose(after[:3, 3] - release[:3, 3], -LIFT * approach)
    aside = before[:3, 3] - grasp[:3, 3] + LIFT * approach
    assert np.allclose(aside[2], 0) and np.linalg.norm(aside) == pytest.approx(UNDER) and aside @ across < -0.018
    hem = place.matrix[:3, :3] @ points[0] + place.matrix[:3, 3]
    assert (grasp[:3, 3] - hem) @ across == pytest.approx(jaw.depth)
    assert after[2, 3] > release[2, 3] + 0.05


def test_a_plan_goes_in_under_the_hem_and_out_along_the_tool(plan: RobotPlan) -> None:
    names = [part.name for part in plan.motion.parts]
    assert names == [
        *("lead", "approach", "lower", "enter", "close", "fold", "settle", "open", "raise", "return"),
    ]
    enter, leave = tools(plan, "enter"), tools(plan, "raise")
    assert np.ptp(enter[:, :, 2, 3], axis=1).max() < 1e-3, "the lower finger slides along the table"
    went = leave[:, -1, :3, 3] - leave[:, 0, :3, 3]
    assert np.allclose(went / LIFT, -leave[:, 0, :3, 2], atol=0.02)


def test_the_finger_bodies_are_where_the_checks_say(plan: RobotPlan) -> None:
    """The lowest point of the open jaw, by MuJoCo's own distance at the moment of closing."""
    robot = plan.task.robot
    row = int(plan.motion.rows("close")[0])
    model, data = robot.model, mujoco.MjData(robot.model)
    model.geom("tatamu_table").pos[2] = plan.task.placement.z - model.geom("tatamu_table").size[2]
    data.qpos[:] = plan.motion.angles[row]
    mujoco.mj_kinematics(model, data)
    table = model.geom("tatamu_table").id
    found = [
        mujoco.mj_geomDistance(model, data, model.geom(f"{arm}_finger{k}_tip").id, table, 1.0, None)
        for arm in SIDES
        for k in (1, 2)
    ]
    assert max(sorted(found)[:2]) == pytest.approx(GAP, abs=2e-4) and sorted(found)[2] > 0.002
    assert plan.checks["lower_finger_under_the_hem"].value == pytest.approx(GAP, abs=2e-4)
    assert plan.checks["distance_of_fingers_to_the_table"].ok


def test_jaws_open_and_close_at_the_events(plan: RobotPlan) -> None:
    motion, robot = plan.motion, plan.task.robot
    column = robot.finger_columns["larm_finger1"]
    width = 2 * motion.angles[:, column]
    assert width[motion.rows("enter")].min() == pytest.approx(robot.larm.jaw.opening)
    assert np.ptp(width[motion.rows("fold")]) == 0 and width[motion.rows("fold")[0]] < 0.002
    assert width[motion.rows("raise")[1:]].min() == pytest.approx(robot.larm.jaw.opening)


def test_the_point_in_the_file_is_where_the_simulated_hand_is(plan: RobotPlan) -> None:
    file = plan_file(plan)
    start = tools(plan, "fold")[:, 0]
    for arm, X_BT, curve in zip(plan.task.robot.arms, start, plan.task.hands.curves, strict=True):
        X_BH = X_BT @ np.linalg.inv(arm.tool_in_wrist) @ np.array(file.tool_in_wrist[arm.name])
        assert np.allclose(X_BH[:3, 3], (plan.task.placement.matrix @ [*curve.control[0], 1.0])[:3], atol=2e-4)
        assert np.allclose(file.jaws[arm.name].fingertips_in_wrist, arm.tool_in_wrist)


Change = Callable[[RobotPlan], RobotPlan]


def with_jaw(plan: RobotPlan, **change: float) -> RobotPlan:
    """The same motion, judged for another jaw."""
    robot = plan.task.robot
    larm, rarm = (replace(arm, jaw=arm.jaw.model_copy(update=change)) for arm in robot.arms)
    return replace(plan, task=replace(plan.task, robot=replace(robot, larm=larm, rarm=rarm)))


def moved(plan: RobotPlan, by: tuple[float, float, float]) -> RobotPlan:
    """The same motion over a fold that lies elsewhere."""
    place = plan.task.placement
    elsewhere = Placement(place.x + by[0], place.y + by[1], place.z + by[2], place.yaw)
    return replace(plan, task=replace(plan.task, placement=elsewhere))


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (lambda plan: moved(plan, (0.008, 0, 0)), "hem_in_the_open_jaw"),
        (lambda plan: moved(plan, (0, 0, -0.014)), "cloth_in_the_closed_jaw"),
        (lambda plan: moved(plan, (0, 0, -0.014)), "lower_finger_under_the_hem"),
        (lambda plan: moved(plan, (0, 0, 0.002)), "distance_of_fingers_to_the_table"),
        (lambda plan: with_jaw(plan, widest=0.008), "jaw_opening"),
        (lambda plan: with_jaw(plan, yaw=-1.0), "jaw_across_the_hem"),
    ],
)
def test_a_grasp_that_takes_no_hem_is_refused(plan: RobotPlan, change: Change, name: str) -> None:
    changed = change(plan)
    check = Checks(changed.task, Paths(changed.task), plan.motion).all()[name]
    assert plan.checks[name].ok and not check.ok


def test_thick_fingers_close_on_the_cloth_and_not_above_it(tmp_path: Path) -> None:
    """A fold that carries the cloth 15.2 mm high, for Franka's fingertips, is taken at the table all the same."""
    plan = plan_fold(folder(tmp_path / "thick", lift=0.0152), load("panda-pair"), place=(0.0, 0.0, 0.0))
    assert plan.checks["lower_finger_under_the_hem"].value < 0.003
    assert plan.checks["cloth_in_the_closed_jaw"].value > 0.005


def test_ways_to_hold_keep_to_the_jaws_limits() -> None:
    robot = load("hironx")
    for arm, inwards in zip(robot.arms, (-1, 1), strict=True):
        narrow, steep = (replace(arm, jaw=jaw) for jaw in (Jaw(tilt=(0.3, 0.6), yaw=0.3), Jaw(tilt=(1.2, 1.3))))
        for fine in (False, True):
            found = holds_of(narrow, fine)
            assert all(0.3 <= hold.tilt <= 0.6 and 0 <= inwards * hold.yaw <= 0.3 for hold in found)
            assert {hold.tilt for hold in holds_of(steep, fine)} == {1.2}, "none of the usual ones"


def test_robots_have_fingers_that_start_open() -> None:
    robot: Robot = load("hironx")
    assert all(robot.rest[column] == pytest.approx(0.006) for column in robot.finger_columns.values())
    assert robot.fingers == {f"{arm}_finger{k}" for arm in SIDES for k in (1, 2)}


@pytest.mark.slow
def test_arms_of_five_joints_keep_the_jaws_axis_and_tilt(tmp_path: Path) -> None:
    plan = plan_fold(folder(tmp_path / "small", span=0.16, width=0.2, height=0.09), load("so101-pair"))
    assert len(plan.task.robot.larm.joints) == 5
    for X_BT, (R_BT, _, _) in zip(tools(plan, "fold"), plan.task.grips, strict=True):
        assert np.allclose(X_BT[:, :3, 1], R_BT[:, 1], atol=5e-3), "the opening axis, and with it the tilt"
    assert plan.checks["tool_turn_error"].ok and plan.checks["lower_finger_under_the_hem"].ok
