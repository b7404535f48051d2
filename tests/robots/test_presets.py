"""Pairs of arms by name: they are the robots that they are named after, and fold what a pair side by side cannot."""

import os
import re
import shutil
import sys
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from tatamu.base.errors import InputError
from tatamu.robots import load, plan_fold
from tatamu.robots.catalog import DATA, described
from tatamu.robots.catalog import NAMES as BUILT_IN
from tatamu.robots.chain import Chain
from tatamu.robots.clearance import FAR, Clearance
from tatamu.robots.constraint import ReachConstraint
from tatamu.robots.model import state_names
from tatamu.robots.modelfile import give, read_model
from tests.robots.folds import exact, folder

NAMES = sorted(set(BUILT_IN) - {"hironx", "nextage"})
REAL = {
    "panda": ("example-robot-data", "panda_description/urdf/panda.urdf", "panda_link{}", 1e-5),
    "xarm7": ("example-robot-data", "xarm_description/urdf/xarm7.urdf", "link{}", 1e-4),
    "ur5e": ("robosuite", "ur5e/robot.xml", "", 2.5e-3),  # its lengths are rounded to millimetres
    "so101": ("example-robot-data", "so_arm_description/urdf/so101.urdf", "", 1e-5),
    "viperx": ("gym_aloha", "assets/bimanual_viperx_insertion.xml", "", 1e-5),
    "openarm": ("openarm_mujoco-2.3.0", "v2/openarm_bimanual.xml", "", 1e-5),
}
LINKS = {
    "ur5e": ("shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link", "wrist_3_link"),
    "so101": ("shoulder_link", "upper_arm_link", "lower_arm_link", "wrist_link", "gripper_link"),
    "viperx": tuple(
        f"vx300s_left/{name}_link"
        for name in ("shoulder", "upper_arm", "upper_forearm", "lower_forearm", "wrist", "gripper")
    ),
    "openarm": (*(f"openarm_left_link{number}" for number in range(1, 7)), "openarm_left_ee_base_link"),
}
FEET = {"ur5e": "fixed_base_link", "viperx": "vx300s_left", "openarm": "openarm_left_base_link"}
JOINTS = {"viperx": "vx300s_left/{}", "openarm": "openarm_left_{}", "ur5e": "", "xarm7": "", "panda": ""}
FILES = {"viperx": "aloha2", "openarm": "openarm-left"}
COUNTS = {"panda": 7, "xarm7": 7, "ur5e": 6, "so101": 5, "viperx": 6, "openarm": 7}


def real_file(package: str, path: str) -> Path:
    """A model file of an installed package; the test is skipped if there is none."""
    inside = {
        "example-robot-data": "cmeel.prefix/share/example-robot-data/robots",
        "robosuite": "robosuite/models/assets/robots",
    }
    entries = [*sys.path, *filter(None, [os.environ.get("TATAMU_MODELS")])]  # unpacked source archives
    for entry in entries:
        file = Path(entry) / inside.get(package, package) / path
        if file.is_file():
            return file
    pytest.skip(f"{package} is not installed, whose {path} this preset is compared with")


def single(name: str) -> Any:
    """The model of a preset's left arm, its foot at the origin."""
    return read_model(DATA / f"{FILES.get(name, name)}.xml", {}).spec.compile()


def joints_of(model: Any, name: str) -> list[str]:
    return [model.joint(number).name for number in range(COUNTS[name])]


@pytest.mark.parametrize("name", BUILT_IN)
def test_a_robot_of_the_package_passes_the_checks_of_users_robots(name: str) -> None:
    robot = described(DATA / f"{name}.toml")
    assert robot.name == name and robot.notes == load(name).notes == ()
    assert all(
        np.array_equal(one.initial, other.initial) for one, other in zip(robot.arms, load(name).arms, strict=True)
    )


@pytest.mark.parametrize("name", NAMES)
def test_a_pair_starts_with_its_tools_down_and_its_jaws_across_the_hem(name: str) -> None:
    robot = load(name)
    for arm in robot.arms:
        tool = Chain.of(robot, arm).tool(arm.initial[None])[0][0]
        if name != "openarm":  # its tools point ahead, as in its maker's home pose
            assert np.allclose(tool[:3, 2], [0, 0, -1], atol=1e-3)
            assert np.allclose(tool[:3, 1], [1, 0, 0], atol=1e-3), "the jaw opens along the fold, across the hem"
        assert np.sign(tool[1, 3]) == (1 if arm.name == "larm" else -1)
        assert Chain.of(robot, arm).margin(arm.initial[None])[0] > 0.15
    clearance = Clearance(robot)
    clearance.set_table(robot.table_heights[1])
    least = {kind: found.value for kind, found in clearance.least(robot.initial[None]).items()}
    assert min(least.values()) > 0.01 and least["between arms"] > 0.1 <= FAR


@pytest.mark.parametrize("name", sorted(REAL))
def test_a_preset_moves_as_the_real_models_do(name: str) -> None:
    package, path, pattern, tolerance = REAL[name]
    model, mine = _real_model(package, path), single(name)
    theirs, ours = mujoco.MjData(model), mujoco.MjData(mine)
    joints = joints_of(mine, name)
    named = [JOINTS.get(name, "{}").format(joint) for joint in joints]
    numbers = [model.joint(joint).id if joint else number for number, joint in enumerate(named)]
    columns = [model.jnt_qposadr[number] for number in numbers]
    random = np.random.default_rng(0)
    for _ in range(5):
        angles = random.uniform(-1.0, 1.0, len(joints))
        theirs.qpos[columns] = angles
        for joint, angle in zip(joints, angles, strict=True):
            ours.joint(joint).qpos[0] = angle
        mujoco.mj_kinematics(model, theirs)
        mujoco.mj_kinematics(mine, ours)
        for number in range(1, len(joints) + 1):
            link = theirs.body(LINKS[name][number - 1] if name in LINKS else pattern.format(number))
            own = ours.body(f"link{number}")
            foot = theirs.body(FEET.get(name, 0))
            turned = foot.xmat.reshape(3, 3).T
            assert np.allclose(own.xpos, turned @ (link.xpos - foot.xpos), atol=tolerance)
            assert np.allclose(own.xmat.reshape(3, 3), turned @ link.xmat.reshape(3, 3), atol=1e-4)


@pytest.mark.parametrize("name", ["panda", "ur5e", "so101", "viperx", "openarm"])
def test_the_boxes_of_a_preset_contain_the_real_links(name: str) -> None:
    package, path, pattern, _ = REAL[name]
    model, mine = _real_model(package, path), single(name)
    seen = 0
    for number in range(1, COUNTS[name] + 1):
        geoms = [geom for geom in range(mine.ngeom) if mine.geom_bodyid[geom] == mine.body(f"link{number}").id]
        body = model.body(LINKS[name][number - 1] if name in LINKS else pattern.format(number)).id
        for geom in range(model.ngeom):
            if model.geom_bodyid[geom] == body and model.geom_contype[geom] and model.geom_dataid[geom] >= 0:
                points = _vertices(model, geom)
                if (name, number) == ("so101", 5):
                    points = points[points[:, 2] > -0.051]  # beyond is the fixed jaw, a finger
                inside = np.zeros(len(points), dtype=bool)
                for box in geoms:
                    inside |= (np.abs(points - mine.geom_pos[box]) <= mine.geom_size[box] + 1e-3).all(axis=1)
                assert inside.all(), number
                seen += 1
    assert seen >= COUNTS[name]


def _real_model(package: str, path: str) -> Any:
    read = read_model(real_file(package, path), {})
    give(read.spec, read.contents)
    return read.spec.compile()


def _vertices(model: Any, geom: int) -> np.ndarray:
    """Vertices of a shape in its link's frame [m]."""
    number = int(model.geom_dataid[geom])
    start, count = int(model.mesh_vertadr[number]), int(model.mesh_vertnum[number])
    turned = np.zeros(9)
    mujoco.mju_quat2Mat(turned, model.geom_quat[geom])
    found = model.mesh_vert[start : start + count] @ turned.reshape(3, 3).T
    return np.asarray(found + model.geom_pos[geom])


def test_facing_arms_fold_what_arms_side_by_side_cannot(tmp_path: Path) -> None:
    towel = exact(span=0.8, width=0.5, height=0.28)
    text = (DATA / "panda-pair.toml").read_text().replace("front = -0.6", "front = 0.15")
    text = re.sub(r"mount = .*0\.65, 0\.0\], rpy.*", "mount = { xyz = [0.0, 0.3, 0.0] }", text, count=1)
    text = re.sub(r"mount = .*-0\.65, 0\.0\], rpy.*", "mount = { xyz = [0.0, -0.3, 0.0] }", text, count=1)
    (tmp_path / "beside.toml").write_text(text)
    shutil.copy(DATA / "panda.xml", tmp_path)
    beside = load(str(tmp_path / "beside.toml"))
    assert beside.model.body("rarm_foot").pos[1] == -0.3
    assert ReachConstraint(beside)(towel) < 0
    assert ReachConstraint(load("panda-pair"))(towel) > 0.2


def test_a_pair_plans_a_long_towel(tmp_path: Path) -> None:
    plan = plan_fold(folder(tmp_path / "fold", span=0.7, width=0.4), load("panda-pair"), place=(0.0, 0.0, 0.0))
    assert all(check.ok for check in plan.checks.values())
    assert set(plan.checks) >= {"distance_between_arms", "distance_to_obstacles", "distance_to_the_table"}


def test_fr3_keeps_to_half_of_its_speed() -> None:
    makers = np.array([2.62, 2.62, 2.62, 2.62, 5.26, 4.18, 5.26])
    assert load("fr3-pair").larm.planned_speed == pytest.approx(makers / 2)


def test_options_of_hironx_are_not_for_presets() -> None:
    with pytest.raises(InputError, match="must be left out, except for hironx and nextage"):
        load("panda-pair", fingertip=0.1)


def test_the_right_arm_of_openarm_is_the_real_one() -> None:
    model, mine = _real_model("openarm_mujoco-2.3.0", "v2/openarm_bimanual.xml"), load("openarm").model
    theirs, ours = mujoco.MjData(model), mujoco.MjData(mine)
    random = np.random.default_rng(0)
    for number in range(1, 8):
        real, own = model.joint(f"openarm_right_joint{number}"), mine.joint(f"rarm_joint{number}")
        assert own.range == pytest.approx(real.range)
        theirs.joint(real.name).qpos[0] = ours.joint(own.name).qpos[0] = random.uniform(*real.range)
    mujoco.mj_kinematics(model, theirs)
    mujoco.mj_kinematics(mine, ours)
    for number in range(1, 8):
        link = theirs.body(f"openarm_right_link{number}" if number < 7 else "openarm_right_ee_base_link")
        assert np.allclose(ours.body(f"rarm_link{number}").xpos, link.xpos, atol=1e-5)
        assert np.allclose(ours.body(f"rarm_link{number}").xmat, link.xmat, atol=1e-4)


@pytest.mark.parametrize(
    ("name", "kind", "keys"),
    [
        ("so101-pair", "bi_so_follower", ["left_shoulder_pan.pos", "left_gripper.pos", "right_wrist_roll.pos"]),
        ("openarm", "bi_openarm_follower", ["left_joint_1.pos", "left_gripper.pos", "right_joint_7.pos"]),
        ("aloha2", "aloha", ["left_waist.pos", "left_gripper.pos", "right_wrist_rotate.pos"]),
    ],
)
def test_light_arms_have_the_keys_of_lerobot(name: str, kind: str, keys: list[str]) -> None:
    robot = load(name)
    assert robot.lerobot_type == kind
    names = state_names(robot)
    width = len(robot.larm.joints)
    assert [names[0], names[width], names[-2]] == keys and len(names) == 2 * width + 2
