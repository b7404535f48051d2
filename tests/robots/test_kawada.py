import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.robots import load
from tatamu.robots.arm import Arm
from tatamu.robots.chain import Chain
from tatamu.robots.clearance import Clearance
from tatamu.robots.extras import needed
from tatamu.robots.model import Robot

DATA = json.loads((Path(__file__).parent / "hironx_vectors.json").read_text())


def arm_of(robot: Robot, group: str) -> Arm:
    return robot.larm if group == "LARM" else robot.rarm


@pytest.mark.parametrize("vector", DATA["vectors"], ids=lambda vector: f"{vector['pose']}-{vector['arm']}")
def test_the_model_and_the_batched_chain_have_the_published_forward_kinematics(vector: dict) -> None:
    robot = load("hironx", wrist_offset=DATA["wrist_offset"])
    arm, data = arm_of(robot, vector["arm"]), mujoco.MjData(robot.model)
    for joint, angle in zip(arm.joints, vector["q_rad"], strict=True):
        data.joint(joint).qpos = angle
    mujoco.mj_kinematics(robot.model, data)
    wanted, link = np.array(vector["T_waist_J5"]), data.body(arm.link)
    assert np.allclose(link.xpos, wanted[:3, 3], rtol=0, atol=1e-5)
    assert np.allclose(link.xmat.reshape(3, 3), wanted[:3, :3], rtol=0, atol=1e-5)
    X_BT, _ = Chain.of(robot, arm).tool(np.array([vector["q_rad"]]))
    assert np.allclose(X_BT[0], wanted @ arm.tool_in_wrist, rtol=0, atol=1e-5)


def test_the_newer_wrist_stands_7_mm_lower_at_the_initial_pose() -> None:
    # hironx_client.py prints z = 0.0746 for the old wrist and 0.0676 for the new one.
    robot = load("hironx")
    X_BT, _ = Chain.of(robot, robot.larm).tool(robot.larm.initial[None])
    X_BW = X_BT[0] @ np.linalg.inv(robot.larm.tool_in_wrist)
    assert X_BW[2, 3] == pytest.approx(0.0676245, abs=1e-5)


def test_jacobian_equals_finite_differences() -> None:
    robot = load("hironx")
    chain = Chain.of(robot, robot.rarm)
    q = robot.rarm.initial + 0.1
    X, jacobian = chain.tool(q[None])
    for joint in range(6):
        moved, _ = chain.tool((q + 1e-6 * np.eye(6)[joint])[None])
        assert np.allclose((moved[0, :3, 3] - X[0, :3, 3]) / 1e-6, jacobian[0, :3, joint], atol=1e-5)


def test_trunk_turns_both_tools_about_the_vertical() -> None:
    robot = load("hironx")
    chain, data = Chain.of(robot, robot.larm), mujoco.MjData(robot.model)
    data.qpos[:] = robot.initial
    data.joint("CHEST_JOINT0").qpos = 0.4
    mujoco.mj_kinematics(robot.model, data)
    X_BT = chain.trunk_pose(np.array(0.4)) @ chain.tool(robot.larm.initial[None])[0][0]
    assert np.allclose(X_BT[:3, 3], data.site("larm_tool").xpos, atol=1e-9)
    back = chain.before_trunk(X_BT, np.array(0.4))
    assert np.allclose(back, chain.tool(robot.larm.initial[None])[0][0], atol=1e-9)


def test_inverse_kinematics_return_to_where_they_came_from() -> None:
    robot = load("hironx")
    chain = Chain.of(robot, robot.larm)
    goal = robot.larm.initial + np.array([0.1, -0.2, 0.3, 0.1, -0.2, 0.2])
    X, _ = chain.tool(goal[None])
    found, reached = chain.solve(X, robot.larm.initial[None], steps=30, tolerance=1e-6)
    assert reached[0] and np.allclose(found[0], goal, atol=1e-4)


def test_left_elbow_swivel_keeps_to_what_all_sources_allow() -> None:
    hironx, nextage = load("hironx"), load("nextage")
    assert np.allclose(hironx.limits(hironx.larm)[3], [-1.8326, 1.8326], atol=1e-5)
    assert np.allclose(nextage.limits(nextage.larm)[3], [-1.8326, 2.87979], atol=1e-5)


def test_arms_that_cross_are_seen_to_touch() -> None:
    robot = load("hironx")
    q = robot.initial
    assert Clearance(robot, ("between arms",)).least(q[None])["between arms"].value > 0.1
    q[robot.columns["LARM_JOINT0"]], q[robot.columns["RARM_JOINT0"]] = -1.0, 1.0
    assert Clearance(robot, ("between arms",)).least(q[None])["between arms"].value < 0


def test_table_distance_is_measured_from_the_hand() -> None:
    robot = load("hironx")
    clearance = Clearance(robot, ("to the table", "of fingers to the table"))
    clearance.set_table(-0.10)
    least = {kind: found.value for kind, found in clearance.least(robot.initial[None]).items()}
    # At the initial pose the wrist is at 0.0676; the hand's box ends 0.063 below it, the fingers 0.093.
    assert least["to the table"] == pytest.approx(0.1046, abs=2e-3)
    assert least["of fingers to the table"] == pytest.approx(0.0746, abs=2e-3)


@pytest.mark.parametrize(("name", "wrist", "tip"), [("pr2", None, None), ("hironx", 0.3, None), ("hironx", None, 2.0)])
def test_a_wrong_robot_is_refused_in_one_line(name: str, wrist: float | None, tip: float | None) -> None:
    with pytest.raises(InputError, match=r"must be|from"):
        load(name, wrist, tip)


def test_a_missing_extra_is_named_with_how_to_install_it() -> None:
    with pytest.raises(InputError, match=r"no_such_package.*pip install 'tatamu\[robot\]'"):
        needed("no_such_package.inner")
