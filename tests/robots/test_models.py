"""Other people's URDF and MJCF: what a model says counts, or the robot is refused in one line."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from tatamu.base.errors import InputError
from tatamu.robots import Robot, load, plan_fold
from tatamu.robots.chain import Chain
from tatamu.robots.modelfile import read_model
from tatamu.robots.soundness import check_kinematics
from tests.refusals import refusal
from tests.robots.arms import BOX, finger, mjcf, pair, pair_of, pair_of_mjcf, pair_of_urdf, urdf
from tests.robots.folds import folder

HAND = finger("left", "0.021 0.057") + finger("right", "-0.057 -0.021")
COUPLED = '<equality><joint joint1="right" joint2="left" polycoef="0 -1 0 0 0"/></equality>'
PLACE = (0.36, -0.16, np.radians(50))


def at(robot: Robot, joint: str) -> float:
    return float(robot.initial[robot.model.joint(joint).qposadr[0]])


# Joints that follow others


def test_a_mimic_joint_of_an_arm_is_refused_by_name(tmp_path: Path) -> None:
    mimic = '<joint name="bend" type="revolute"><mimic joint="elbow" multiplier="-1"/>'
    said = refusal(load, str(pair_of_urdf(tmp_path, urdf().replace('<joint name="bend" type="revolute">', mimic))))
    assert "larm_bend follows larm_elbow" in said and "rarm_bend follows rarm_elbow" in said


@pytest.mark.parametrize(
    ("equality", "named"),
    [
        ('<joint joint1="bend" joint2="elbow" polycoef="0 -1 0 0 0"/>', "larm_bend follows larm_elbow"),
        ('<joint joint1="roll" polycoef="0.1 0 0 0 0"/>', "larm_roll stands still"),
        ('<connect body1="turn_link" body2="foot" anchor="0 0 0"/>', "bodies larm_turn_link and larm_foot are joined"),
        ('<weld name="glue" body1="elbow_link" body2="foot"/>', "bodies larm_elbow_link and larm_foot are joined"),
    ],
)
def test_an_equality_that_a_plan_would_break_is_refused_by_name(tmp_path: Path, equality: str, named: str) -> None:
    assert named in refusal(load, str(pair_of_mjcf(tmp_path, mjcf(more=f"<equality>{equality}</equality>"))))


def test_a_link_that_follows_an_arm_from_outside_it_is_refused(tmp_path: Path) -> None:
    rod = '<equality><joint joint1="left" joint2="elbow" polycoef="0 0.01 0 0 0"/></equality>'
    assert "larm_left follows larm_elbow" in refusal(load, str(pair_of_mjcf(tmp_path, mjcf(hand=HAND, more=rod))))


# Joints outside the arms


def test_fingers_stand_at_the_nearest_allowed_value(tmp_path: Path) -> None:
    robot = load(str(pair_of_mjcf(tmp_path, mjcf(hand=HAND))))
    assert (at(robot, "larm_left"), at(robot, "rarm_right")) == (0.021, -0.021)
    plan = plan_fold(folder(tmp_path / "fold", span=0.24, width=0.18), robot, place=PLACE)
    column = robot.model.joint("larm_left").qposadr[0]
    assert np.allclose(plan.motion.angles[:, column], 0.021, atol=1e-12)


def test_fingers_stand_where_the_description_says_and_followers_follow(tmp_path: Path) -> None:
    robot = load(str(pair_of_mjcf(tmp_path, mjcf(hand=HAND, more=COUPLED), arm="standing = { left = 0.05 }")))
    assert at(robot, "larm_left") == 0.05 and at(robot, "larm_right") == pytest.approx(-0.05)


def test_a_whole_robot_says_where_its_joints_stand_once(tmp_path: Path) -> None:
    lift = '<body name="lift_column"><joint name="column" type="slide" axis="0 0 1" range="0.1 0.5"/>'
    lift += '<inertial pos="0 0 0" mass="9" diaginertia="1 1 1"/>'
    body = mjcf().split("<worldbody>")[1].split("</worldbody>")[0]
    right = body
    for name in ("foot", "pan", "lift", "elbow", "roll", "bend", "turn"):
        right = right.replace(f'"{name}', f'"r_{name}')
    right = right.replace('<body name="r_foot">', '<body name="r_foot" pos="0 -0.5 0">')
    world = f"<worldbody>{lift}{body}{right}</body></worldbody>"
    (tmp_path / "both.xml").write_text(f'<mujoco><compiler angle="radian"/>{world}</mujoco>')
    path = pair_of(tmp_path, "both.xml", top='model = "both.xml"\nstanding = { column = 0.2 }')
    left, arm = path.read_text().replace('\nmodel = "both.xml"\nmount', "\nmount").split("[rarm]")
    for name in ("pan", "lift", "elbow", "roll", "bend", "turn"):
        arm = arm.replace(f'"{name}', f'"r_{name}')
    path.write_text(left + "[rarm]" + arm)
    robot = load(str(path))
    assert at(robot, "column") == 0.2
    angles = np.zeros((1, 6))
    assert Chain.of(robot, robot.larm).tool(angles)[0][0, 2, 3] == pytest.approx(0.2 + 1.08 + 0.14)


@pytest.mark.parametrize(
    ("top", "arm", "named"),
    [
        ("", "standing = { left = 0.2 }", "standing: larm_left must be from 0.021 to 0.057, given 0.2"),
        ("", "standing = { thumb = 0.2 }", "standing: must name a joint of the model, given 'larm_thumb'"),
        ("", "standing = { pan = 0.2 }", "standing: must contain joints outside the arms only, given larm_pan"),
        ("standing = { larm_left = 0.03 }", "", "standing must be under [larm] and [rarm]"),
    ],
)
def test_a_wrong_place_to_stand_is_named(tmp_path: Path, top: str, arm: str, named: str) -> None:
    assert named in refusal(load, str(pair_of_mjcf(tmp_path, mjcf(hand=HAND), top=top, arm=arm)))


# Kinematics


def test_the_reference_of_a_joint_shifts_its_angle_and_nothing_else(tmp_path: Path) -> None:
    models = mjcf(), mjcf(refs={"elbow": 0.5, "roll": -0.3})
    robots = [load(str(pair_of_mjcf(tmp_path, model))) for model in models]
    angles = np.array([[0.3, -0.2, 1.1, 0.4, 0.5, -0.6]])
    tools = [
        Chain.of(robot, robot.larm).tool(angles + shift)[0]
        for robot, shift in zip(robots, (np.zeros(6), np.array([0, 0, 0.5, -0.3, 0, 0])), strict=True)
    ]
    assert np.allclose(tools[0], tools[1], atol=1e-12)


def test_kinematics_that_differ_from_mujocos_are_refused_with_the_distance(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = load(str(pair(tmp_path)))
    check_kinematics(robot)
    right = Chain.of

    def wrong(robot: Robot, arm: object) -> Chain:
        chain = right(robot, arm)  # type: ignore[arg-type]
        return replace(chain, rest=chain.rest + 0.001)

    monkeypatch.setattr(Chain, "of", wrong)
    with pytest.raises(InputError, match=r"robot pair: larm: .* MuJoCo, but the positions are 0\.\d+ mm apart"):
        check_kinematics(robot)


@pytest.mark.parametrize("kind", ["named", "unnamed", "ball"])
def test_a_joint_without_one_angle_is_named_with_its_body(tmp_path: Path, kind: str) -> None:
    joint = {"named": '<freejoint name="loose"/>', "unnamed": "<freejoint/>", "ball": '<joint type="ball"/>'}[kind]
    cube = f'<body name="cube" pos="0.5 0 1">{joint}<geom size=".02" mass=".05"/></body>'
    said = refusal(load, str(pair_of_mjcf(tmp_path, mjcf(world=cube))))
    assert f"the {'ball' if kind == 'ball' else 'free'} joint" in said and "body 'larm_cube'" in said
    assert kind != "named" or "larm_loose" in said


def test_an_arm_of_four_joints_is_refused_with_the_number_that_is_needed(tmp_path: Path) -> None:
    path = pair(tmp_path)
    text = path.read_text().replace('"roll", "bend", "turn"]', '"turn"]')
    for field, last in (("initial", "0.0"), ("speed", "2.0"), ("acceleration", "3.0")):
        text = text.replace(f"{field} = [", f"{field} = [", 1)
        text = "\n".join(line.rsplit(", ", 2)[0] + "]" if line.startswith(field) else line for line in text.split("\n"))
        assert last in text
    path.write_text(text)
    why = "the position of the hand needs three joints, and the direction of the jaws needs two"
    assert f"larm: must have at least 5 joints, given 4; {why}" in refusal(load, str(path))


def test_joints_that_repeat_one_another_are_refused(tmp_path: Path) -> None:
    path = pair_of_mjcf(tmp_path, mjcf().replace('axis="0 0 1"', 'axis="0 1 0"'))
    assert "larm.joints: must move and turn the tool in 6 directions" in refusal(load, str(path))


# Limits of the model


def test_a_speed_above_the_models_is_lowered_with_its_acceleration_and_said(tmp_path: Path) -> None:
    path = pair_of_urdf(tmp_path, urdf())
    path.write_text(path.read_text().replace("speed = [2.0, 2.0", "speed = [120.0, 1.0"))
    robot = load(str(path))
    assert robot.larm.planned_speed.tolist() == [2.0, 1.0, 2.0, 2.0, 2.0, 2.0]
    assert robot.larm.planned_acceleration.tolist() == pytest.approx([0.05, 3.0, 3.0, 3.0, 3.0, 3.0])
    (note,) = robot.notes
    assert "larm pan 120 (2), rarm pan 120 (2)" in note and "lift" not in note


def test_a_speed_above_the_models_counts_for_joints_that_are_named(tmp_path: Path) -> None:
    path = pair_of_urdf(tmp_path, urdf(), arm='faster_than_model = ["pan"]')
    path.write_text(path.read_text().replace("speed = [2.0, 2.0", "speed = [3.0, 3.0"))
    robot = load(str(path))
    assert robot.larm.planned_speed.tolist()[:2] == [3.0, 2.0]
    assert "lift 3 (2)" in robot.notes[0] and "pan" not in robot.notes[0]


def test_a_speed_that_no_model_bounds_must_be_one_of_a_robot(tmp_path: Path) -> None:
    path = pair_of_mjcf(tmp_path, mjcf())
    path.write_text(path.read_text().replace("speed = [2.0", "speed = [120.0"))
    said = refusal(load, str(path))
    assert "larm.speed: pan must be at most 20 rad/s if the model states no limit, given 120" in said


def test_a_speed_limit_of_zero_is_none(tmp_path: Path) -> None:
    robot = load(str(pair_of_urdf(tmp_path, urdf().replace('velocity="2"', 'velocity="0"'))))
    assert robot.notes == () and robot.larm.planned_speed[0] == 2.0


# Files that a model names


def mesh(path: Path, suffix: str = ".stl", scale: float = 1.0) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    box = trimesh.creation.box(scale * np.array([0.06, 0.06, 0.05]))
    content = box.export(file_type="stl_ascii" if suffix == "ascii" else suffix[1:])
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def in_package(root: Path, uri: str = "package://my_arm/meshes/link.stl") -> Path:
    (root / "my_arm" / "urdf").mkdir(parents=True)
    file = root / "my_arm" / "urdf" / "arm.urdf"
    file.write_text(urdf(f'<mesh filename="{uri}"/>'))
    return file


def size(path: Path, **packages: Path) -> list[float]:
    """Half sizes of the last link's shape [m]."""
    model = read_model(path, packages)
    model.spec.assets = dict(model.contents)
    compiled = model.spec.compile()
    return sorted(compiled.geom_aabb[-1, 3:].round(6).tolist())


@pytest.mark.parametrize("place", ["above", "beside", "ROS_PACKAGE_PATH", "deeper", "AMENT_PREFIX_PATH", "table"])
def test_a_package_is_found(tmp_path: Path, place: str, monkeypatch: pytest.MonkeyPatch) -> None:
    for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.setenv(variable, "")
    name = "my_arm" if place == "above" else "shapes"
    file = in_package(tmp_path / "source", f"package://{name}/meshes/link.stl")
    root = tmp_path / "elsewhere"
    if place in ("above", "beside"):
        root = tmp_path / "source"
    elif place == "ROS_PACKAGE_PATH":
        monkeypatch.setenv(place, f"{tmp_path / 'none'}:{root}")
    elif place == "deeper":
        monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path))
    elif place == "AMENT_PREFIX_PATH":
        monkeypatch.setenv(place, str(root))
        root = root / "share"
    mesh(root / name / "meshes" / "link.stl")
    packages = {name: root / name} if place == "table" else {}
    assert size(file, **packages) == [0.025, 0.03, 0.03]


def test_a_package_of_the_description_is_relative_to_it_and_kept_with_it(tmp_path: Path) -> None:
    in_package(tmp_path, "package://shapes/meshes/link.stl")
    kept = mesh(tmp_path / "other" / "meshes" / "link.stl")
    path = pair_of(tmp_path, "my_arm/urdf/arm.urdf", top='packages = { shapes = "other" }')
    assert kept in load(str(path)).files


def test_a_package_that_is_nowhere_is_said_with_what_to_write(tmp_path: Path) -> None:
    in_package(tmp_path, "package://shapes/meshes/link.stl")
    said = refusal(load, str(pair_of(tmp_path, "my_arm/urdf/arm.urdf")))
    assert "package://shapes/meshes/link.stl" in said and 'packages = { shapes = "FOLDER" }' in said


@pytest.mark.parametrize("suffix", [".stl", "ascii", ".STL", ".obj", ".ply", ".off"])
def test_meshes_of_any_format_are_the_same_shape(tmp_path: Path, suffix: str) -> None:
    file = mesh(tmp_path / f"link{'.stl' if suffix == 'ascii' else suffix}", suffix.lower())
    (tmp_path / "arm.urdf").write_text(urdf(f'<mesh filename="{file.name}"/>'))
    assert size(tmp_path / "arm.urdf") == [0.025, 0.03, 0.03]


def test_two_meshes_of_one_name_in_two_folders_are_two(tmp_path: Path) -> None:
    mesh(tmp_path / "arm" / "link.stl")
    mesh(tmp_path / "hand" / "link.stl", scale=0.5)
    text = urdf('<mesh filename="arm/link.stl"/>')
    before, last = text.rsplit("arm/link.stl", 1)
    (tmp_path / "arm.urdf").write_text(f"{before}hand/link.stl{last}")
    assert size(tmp_path / "arm.urdf") == [0.0125, 0.015, 0.015]


@pytest.mark.parametrize(
    ("text", "named"),
    [
        (urdf('<mesh filename="gone.stl"/>'), "must name existing files"),
        (urdf('<mesh filename="link.dae"/>'), "must be a file of type .stl"),
        (urdf('<mesh filename="broken.ply"/>'), "is not a mesh that tatamu can read"),
        (urdf('<mesh filename="broken.stl"/>'), "does not compile"),
        (urdf().replace("<robot", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"', 1), ""),
        (urdf(more='<xacro:arm xmlns:xacro="http://www.ros.org/wiki/xacro"/>'), "given xacro"),
        (urdf().replace('velocity="2"', 'velocity="fast"'), "velocity must be a number, given 'fast'"),
        ("<sdf/>", "must be a URDF (<robot>) or an MJCF (<mujoco>), given <sdf>"),
        ("joints: none", "cannot be read as URDF or MJCF"),
        ('<robot name="macros"></robot>', "must have a link"),
    ],
)
def test_a_model_file_that_cannot_be_read_is_one_line(tmp_path: Path, text: str, named: str) -> None:
    (tmp_path / "arm.urdf").write_text(text)
    for broken in ("broken.ply", "broken.stl", "link.dae"):
        (tmp_path / broken).write_text("solid nothing")
    path = pair_of(tmp_path, "arm.urdf")
    if named:
        assert named in refusal(load, str(path))
    else:
        load(str(path))


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ('mass="1"', 'mass="1e308"', "body_mass"),
        ('pos="0 0 0.35"', 'pos="0 0 1e200"', "body_pos"),
        ('range="-2.7 2.7"', 'range="-2.7 1e9"', "jnt_range must be within 10000 (SI units), given 1e+09"),
    ],
)
def test_a_number_that_no_robot_has_is_named(tmp_path: Path, old: str, new: str, named: str) -> None:
    assert old in mjcf()
    assert named in refusal(load, str(pair_of_mjcf(tmp_path, mjcf().replace(old, new))))


def test_nothing_but_our_line_is_written(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "left.xml").write_text(mjcf(more='<option integrator="RK4" timestep="0.1"/>'))
    (tmp_path / "right.xml").write_text(mjcf().replace('pos="0 0 0.35"', 'pos="0 0 NaN"'))
    refusal(load, str(pair_of(tmp_path, "left.xml", "right.xml")))
    load(str(pair_of(tmp_path, "left.xml")))
    said = capfd.readouterr()
    assert (said.out, said.err) == ("", "")


def test_an_mjcf_brings_its_meshes_height_fields_and_includes_and_no_textures(tmp_path: Path) -> None:
    mesh(tmp_path / "shapes" / "link.stl")
    Image.new("L", (4, 4), 9).save(tmp_path / "shapes" / "hill.png")
    Image.new("RGB", (4, 4)).save(tmp_path / "shapes" / "wood.png")
    assets = (
        '<asset><mesh name="link" file="link.stl"/>'
        '<texture name="wood" type="2d" file="wood.png"/><material name="wood" texture="wood"/></asset>'
    )
    (tmp_path / "assets.xml").write_text(f"<mujocoinclude>{assets}</mujocoinclude>")
    more = '<include file="assets.xml"/><compiler meshdir="shapes" texturedir="shapes"/>'
    more += '<asset><hfield name="hill" file="hill.png" size="1 1 0.1 0.1"/></asset>'
    world = '<geom type="hfield" hfield="hill" pos="0 0 -0.5"/>'
    text = mjcf(world=world, more=more).replace(
        'type="box" size="0.03 0.03 0.025"', 'type="mesh" mesh="link" material="wood"'
    )
    path = pair_of_mjcf(tmp_path, text)
    robot = load(str(path))
    assert (robot.model.nmesh, robot.model.nhfield, robot.model.ntex) == (2, 2, 0)
    names = {file.name for file in load(str(path)).files}
    assert names == {"pair.toml", "arm.xml", "assets.xml", "link.stl", "hill.png"}


def test_the_files_of_a_robot_are_kept_so_that_the_copy_loads(tmp_path: Path) -> None:
    from tatamu.study.inputs import Sources, keep_inputs, kept_input

    in_package(tmp_path / "robots", "package://my_arm/meshes/link.stl")
    mesh(tmp_path / "robots" / "my_arm" / "meshes" / "link.stl")
    path = pair_of(tmp_path / "robots", "my_arm/urdf/arm.urdf")
    keep_inputs(tmp_path / "run", {"robot": Sources(load(str(path)).files)})
    shutil.rmtree(tmp_path / "robots")
    kept = kept_input(tmp_path / "run", "robot")
    assert kept is not None and load(str(kept)).model.nmesh == 2


def test_what_a_model_says_of_drives_and_sensors_is_left_out(tmp_path: Path) -> None:
    more = (
        '<actuator><position name="drive" joint="pan" kp="100"/></actuator>'
        '<sensor><actuatorfrc actuator="drive"/></sensor><keyframe><key qpos="0 0 0 0 0 0" ctrl="0"/></keyframe>'
        '<option integrator="RK4"><flag contact="disable"/></option>'
    )
    robot = load(str(pair_of_mjcf(tmp_path, mjcf(more=more))))
    assert (robot.model.nu, robot.model.nsensor, robot.model.nkey) == (0, 0, 0)
    assert not robot.model.opt.disableflags


def test_a_box_is_a_box(tmp_path: Path) -> None:
    (tmp_path / "arm.urdf").write_text(urdf(BOX))
    assert size(tmp_path / "arm.urdf") == [0.025, 0.03, 0.03]
