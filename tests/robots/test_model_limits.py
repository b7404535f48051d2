"""What other people's models say of limits, masses, files and sizes holds in plans, or is refused in one line."""

import re
import struct
import zlib
from pathlib import Path

import mujoco
import numpy as np
import pytest
import trimesh

from tatamu.base.errors import InputError
from tatamu.robots import Robot, load, plan_fold, save
from tatamu.robots.modelfile import read_stage
from tatamu.robots.planfile import Planned
from tatamu.robots.rehearsal import rehearse
from tatamu.robots.stage import load_stage
from tests.refusals import refusal
from tests.robots.arms import BOX, finger, mjcf, pair_of, pair_of_mjcf, pair_of_urdf, urdf
from tests.robots.folds import folder

PLACE = (0.36, -0.16, np.radians(50))
INERTIA = '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'
DRIVE = '<actuator><position joint="pan" kp="50" ctrlrange="{}"/></actuator>'


def of_urdf(path: Path, old: str = "", new: str = "", shape: str = BOX) -> Robot:
    text = urdf(shape)
    assert old in text
    return load(str(pair_of_urdf(path, text.replace(old, new, 1) if old else text)))


def with_soft(soft: str, kind: str = "revolute", limit: str | None = None) -> str:
    """The URDF with a safety controller at the joint `pan`."""
    old = re.search('<joint name="pan" .*?</joint>', urdf())
    assert old
    new = old[0].replace("</joint>", f"<safety_controller {soft} k_position='20' k_velocity='20'/></joint>")
    new = new.replace('type="revolute"', f'type="{kind}"')
    if limit is not None:
        new = re.sub("<limit .*?/>", limit, new)
    return urdf().replace(old[0], new)


@pytest.mark.parametrize(
    ("soft", "kind", "limit", "expected"),
    [
        ('soft_lower_limit="-0.3" soft_upper_limit="0.3"', "revolute", None, (-0.3, 0.3)),
        ('soft_lower_limit="-0.3" soft_upper_limit="9"', "revolute", None, (-0.3, 2.9)),
        ('soft_upper_limit="0.3"', "revolute", None, (-2.9, 0.3)),
        ('soft_lower_limit="-9" soft_upper_limit="9"', "revolute", None, (-2.9, 2.9)),
        ('soft_lower_limit="-0.3" soft_upper_limit="0.3"', "continuous", "", (-0.3, 0.3)),
        ('soft_upper_limit="0.3"', "continuous", "", (-2 * np.pi, 0.3)),
        ('soft_lower_limit="-inf" soft_upper_limit="0.3"', "revolute", None, (-2.9, 0.3)),
        ('soft_upper_limit="1"/><safety_controller soft_upper_limit="0.3"', "revolute", None, (-2.9, 0.3)),
        ("", "revolute", None, (-2.9, 2.9)),
    ],
)
def test_the_stricter_of_hard_and_soft_limits_holds_and_is_noted(
    tmp_path: Path, soft: str, kind: str, limit: str | None, expected: tuple[float, float]
) -> None:
    robot = load(str(pair_of_urdf(tmp_path, with_soft(soft, kind, limit))))
    assert robot.limits(robot.larm)[0] == pytest.approx(expected)
    noted = "".join(robot.notes)
    assert ("soft limits" in noted and f"larm pan {expected[0]:g} to {expected[1]:g}" in noted) == (
        expected != (-2.9, 2.9)
    )


@pytest.mark.parametrize(
    ("soft", "said"),
    [
        ('soft_lower_limit="0" soft_upper_limit="0"', "joint pan: the soft limits must overlap the hard limits"),
        ('soft_lower_limit="3" soft_upper_limit="4"', "joint pan: the soft limits must overlap the hard limits"),
        ('soft_lower_limit="low"', "joint pan: soft_lower_limit must be a number, given 'low'"),
        ('soft_lower_limit="nan"', "joint pan: soft_lower_limit must be a number, given 'nan'"),
    ],
)
def test_soft_limits_that_leave_nothing_are_refused_by_name(tmp_path: Path, soft: str, said: str) -> None:
    assert said in refusal(load, str(pair_of_urdf(tmp_path, with_soft(soft))))


def test_a_plan_keeps_to_soft_limits_in_every_file_and_names_them(tmp_path: Path) -> None:
    fold = folder(tmp_path / "fold", span=0.24, width=0.18, height=0.1)
    free = plan_fold(fold, load(str(pair_of_urdf(tmp_path, urdf()))))
    widest = np.abs(free.motion.angles[:, free.task.robot.columns["larm_pan"]]).max()
    limit = round(float(widest) - 0.1, 2)
    softer = with_soft(f'soft_lower_limit="{-limit}" soft_upper_limit="{limit}"')
    plan = plan_fold(fold, load(str(pair_of_urdf(tmp_path, softer))))
    save(plan, tmp_path / "plan")
    planned = Planned.load(tmp_path / "plan")
    for joint in ("larm_pan", "rarm_pan"):
        assert np.abs(planned.angles[:, planned.plan.joints.index(joint)]).max() <= limit
        model = mujoco.MjModel.from_xml_path(str(tmp_path / "plan" / "robot.xml"))
        assert model.joint(joint).range == pytest.approx([-limit, limit])
    assert any("soft limits" in note and "larm pan" in note for note in planned.plan.notes)


@pytest.mark.parametrize(
    "drive",
    [
        DRIVE.format("-0.4 0.5"),
        DRIVE.format("-0.4 0.5").replace("joint=", "jointinparent="),
        DRIVE.format("-0.8 1").replace("kp", 'gear="2" kp'),
        DRIVE.format("-0.5 0.4").replace("kp", 'gear="-1" kp'),
        DRIVE.format("-0.4 0.5").replace("<position", "<intvelocity").replace("ctrlrange", "actrange"),
        '<default><position ctrlrange="-0.4 0.5" kp="50"/></default><actuator><position joint="pan"/></actuator>',
    ],
)
def test_the_range_that_a_position_drive_accepts_is_a_soft_limit(tmp_path: Path, drive: str) -> None:
    robot = load(str(pair_of_mjcf(tmp_path, mjcf(more=drive))))
    assert robot.limits(robot.larm)[0] == pytest.approx([-0.4, 0.5]) and "larm pan -0.4 to 0.5" in "".join(robot.notes)


def test_a_drive_that_inherits_a_part_of_its_joints_range_keeps_to_it(tmp_path: Path) -> None:
    more = '<actuator><position joint="pan" kp="50" gear="2" inheritrange="0.5"/></actuator>'
    robot = load(str(pair_of_mjcf(tmp_path, mjcf(more=more))))
    assert robot.limits(robot.larm)[0] == pytest.approx([-0.725, 0.725])


def test_a_drive_inherits_the_range_of_its_joint_and_not_that_of_another_drive(tmp_path: Path) -> None:
    inherits = '<position name="half" joint="pan" kp="50" inheritrange="0.5"/></actuator>'
    more = DRIVE.format("-1 1").replace("</actuator>", inherits)
    robot = load(str(pair_of_mjcf(tmp_path, mjcf(more=more))))
    assert robot.limits(robot.larm)[0] == pytest.approx([-1.0, 1.0])


@pytest.mark.parametrize("other", ["0.2 0.5", "3.5 4"])
def test_drives_that_share_no_position_are_refused_by_the_name_of_their_joint(tmp_path: Path, other: str) -> None:
    second = f'<position name="other" joint="pan" kp="50" ctrlrange="{other}"/></actuator>'
    more = DRIVE.format("-0.5 -0.2").replace("</actuator>", second) if other == "0.2 0.5" else DRIVE.format(other)
    said = refusal(load, str(pair_of_mjcf(tmp_path, mjcf(more=more))))
    assert "joint pan: the ranges of the joint and its drives must overlap" in said
    assert f"a drive from {other.replace(' ', ' to ')}" in said


def test_limits_of_a_continuous_joint_that_leave_nothing_are_refused_by_name(tmp_path: Path) -> None:
    text = urdf().replace('"pan" type="revolute"', '"pan" type="continuous"')
    text = text.replace('lower="-2.9" upper="2.9" velocity', 'upper="-7" velocity', 1)
    said = refusal(load, str(pair_of_urdf(tmp_path, text)))
    assert "joint pan: the lower limit must be below the upper limit, and both must be within ±6.28 rad" in said


def test_an_included_file_counts_as_mujoco_reads_its_name(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    field = '<asset><hfield name="h" nrow="2005" ncol="2005" size="1 1 1 1"/></asset>'
    (tmp_path / "parts" / "h.xml").write_text(f"<mujoco>{field}</mujoco>")
    path = pair_of_mjcf(tmp_path, mjcf(more='<include file="parts\\h.xml"/>'))
    assert "height field: must have" in refusal(load, str(path))


def test_the_stage_of_a_plan_has_limits_in_the_files_that_it_includes(tmp_path: Path) -> None:
    field = '<asset><hfield name="h" nrow="2005" ncol="2005" size="1 1 1 1"/></asset>'
    (tmp_path / "h.xml").write_text(f"<mujoco>{field}</mujoco>")
    (tmp_path / "robot.xml").write_text('<mujoco><include file="h.xml"/></mujoco>')
    assert "height field: must have" in refusal(read_stage, tmp_path / "robot.xml")


def test_a_file_with_a_backslash_in_its_name_is_not_read_as_another(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    for name in ("a/b.xml", "a\\b.xml"):
        (tmp_path / name).write_text(mjcf())
    path = pair_of(tmp_path, "a\\b.xml")
    path.write_text(path.read_text().replace('"a\\b.xml"', "'a\\b.xml'"))
    assert "must have a name without a backslash" in refusal(load, str(path))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            urdf()
            .replace('"pan" type="revolute"', '"pan" type="continuous"')
            .replace('lower="-2.9" upper="2.9" velocity', 'upper="2.9" velocity', 1),
            (-2 * np.pi, 2.9),
        ),
        (urdf().replace('"pan" type="revolute"', '"pan" type="continuous"'), (-2.9, 2.9)),
        (
            urdf()
            .replace('"pan" type="revolute"', '"pan" type="continuous"')
            .replace('lower="-2.9" upper="2.9" velocity', "velocity", 1),
            (-2 * np.pi, 2 * np.pi),
        ),
        (
            urdf()
            .replace('"pan" type="revolute"', '"pan" type="continuous"')
            .replace('lower="-2.9" upper="2.9"', 'lower="0" upper="0"', 1),
            (-2 * np.pi, 2 * np.pi),
        ),
        (mjcf().replace('range="-2.9 2.9"', "", 1), (-2 * np.pi, 2 * np.pi)),
        (mjcf().replace('range="-2.9 2.9"', 'range="-2.9 2.9" limited="false"', 1), (-2 * np.pi, 2 * np.pi)),
    ],
)
def test_a_continuous_joint_has_the_limits_of_its_file_or_one_turn(
    tmp_path: Path, text: str, expected: tuple[float, float]
) -> None:
    pair_of_text = pair_of_urdf if "<robot" in text else pair_of_mjcf
    robot = load(str(pair_of_text(tmp_path, text)))
    assert robot.limits(robot.larm)[0] == pytest.approx(expected)
    assert ("continuous joints" in "".join(robot.notes)) == (expected[1] > 6)


def test_degrees_of_an_mjcf_count_for_continuous_joints(tmp_path: Path) -> None:
    text = re.sub(
        'range="(.*?) (.*?)"',
        lambda found: f'range="{np.degrees(float(found[1]))} {np.degrees(float(found[2]))}"',
        mjcf().replace('<compiler angle="radian"/>', ""),
    )
    text = text.replace('name="pan" axis="0 0 1" range', 'name="pan" axis="0 0 1" user')
    robot = load(str(pair_of_mjcf(tmp_path, text)))
    assert robot.limits(robot.larm)[:2] == pytest.approx(np.array([[-2 * np.pi, 2 * np.pi], [-2.2, 2.2]]))


def test_a_revolute_joint_without_a_range_is_not_continuous(tmp_path: Path) -> None:
    text = urdf().replace('lower="-2.9" upper="2.9"', 'lower="0" upper="0"', 1)
    assert "larm.joints: must each have a range in the model, given pan" in refusal(
        load, str(pair_of_urdf(tmp_path, text))
    )


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (INERTIA, '<inertia ixx="0.001" iyy="0.001" izz="0.1" ixy="0" ixz="0" iyz="0"/>'),
        (INERTIA, '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0.05" ixz="0" iyz="0"/>'),
        (INERTIA, '<inertia ixx="0.01" iyy="0.01" izz="-0.01" ixy="0" ixz="0" iyz="0"/>'),
        (INERTIA, '<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>'),
        (INERTIA, '<inertia ixx="0.01"/>'),
        (INERTIA, '<inertia ixx="much" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'),
        ('<mass value="1"/>', '<mass value="0"/>'),
        ('<mass value="1"/>', '<mass value="-1"/>'),
        ('<mass value="1"/>', ""),
    ],
)
def test_an_impossible_inertia_is_mended_with_a_note(tmp_path: Path, old: str, new: str) -> None:
    robot = of_urdf(tmp_path, old, new)
    assert "impossible masses or inertias" in "".join(robot.notes) and "pan_link" in "".join(robot.notes)
    assert (robot.model.body_mass[robot.model.body("larm_pan_link").id :][:6] > 0).all()


@pytest.mark.parametrize("inertia", ["0.01 0.01 0.1", "0.01 0.01 -0.01", "0 0 0", "0.01 NaN 0.01"])
def test_an_impossible_inertia_of_an_mjcf_is_mended_too(tmp_path: Path, inertia: str) -> None:
    robot = load(str(pair_of_mjcf(tmp_path, mjcf().replace("0.01 0.01 0.01", inertia, 1))))
    assert "pan_link" in "".join(robot.notes)


def test_a_link_of_nothing_between_two_joints_is_mended(tmp_path: Path) -> None:
    found = re.search('<link name="pan_link">.*?</link>', urdf())
    assert found
    robot = of_urdf(tmp_path, found[0], '<link name="pan_link"/>')
    assert "pan_link" in "".join(robot.notes)


def test_a_plan_with_a_mended_link_is_rehearsed(tmp_path: Path) -> None:
    robot = of_urdf(tmp_path, INERTIA, '<inertia ixx="0.001" iyy="0.001" izz="0.1" ixy="0" ixz="0" iyz="0"/>')
    save(plan_fold(folder(tmp_path / "fold", span=0.24, width=0.18), robot, place=PLACE), tmp_path / "plan")
    assert rehearse(Planned.load(tmp_path / "plan")).tool_error < 0.01


def test_fingers_stay_within_the_range_of_their_joint(tmp_path: Path) -> None:
    jaw = "jaw = { fingers = { finger = [0.03, 0.0] } }"
    path = pair_of_mjcf(tmp_path, mjcf(hand=finger("finger", "0 0.02")), arm=jaw)
    said = refusal(load, str(path))
    assert "larm.jaw.fingers: finger must be from 0 to 0.02, given 0.03 and 0" in said


def test_a_finger_that_follows_another_moves_with_it_in_a_plan(tmp_path: Path) -> None:
    fingers = finger("one", "0 0.02") + finger("two", "0 0.02", "0 -1 0")
    model = mjcf(hand=fingers, more='<equality><joint joint1="two" joint2="one"/></equality>')
    jaw = 'jaw = { fingers = { one = [0.006, 0.0005] }, links = ["one", "two"] }'
    robot = load(str(pair_of_mjcf(tmp_path, model, arm=jaw)))
    plan = plan_fold(folder(tmp_path / "fold", span=0.24, width=0.18), robot, place=PLACE)
    one, two = (robot.model.joint(f"larm_{name}").qposadr[0] for name in ("one", "two"))
    assert plan.motion.angles[:, one].min() == pytest.approx(0.0005)
    assert np.allclose(plan.motion.angles[:, one], plan.motion.angles[:, two])


# Files and their names

NAMES = [
    "a?b",
    "a%41b",
    "a#b&c;d",
    "quote'\"",
    "two  spaces ",
    "Ärmel-größe",
    "折りたたみ-🤖",
    "-dash",
    "[x]{y}*",
    "a\\b",
    "x" * 200,
]


def write_mesh(path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(trimesh.creation.box([0.06, 0.06, 0.05]).export(file_type="stl"))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("kind", ["urdf", "package", "mjcf", "included"])
def test_files_of_any_name_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, kind: str) -> None:
    here = tmp_path / name
    write_mesh(here / "shapes" / "link.stl")
    if kind in ("urdf", "package"):
        shape = f"package://{name}/shapes/link.stl" if kind == "package" else "shapes/link.stl"
        shape = shape.replace("&", "&amp;").replace('"', "&quot;")
        (here / "arm.urdf").write_text(urdf(f'<mesh filename="{shape}"/>'))
    else:
        text = mjcf(more='<asset><mesh name="link" file="shapes/link.stl"/></asset>')
        text = text.replace('type="box" size="0.03 0.03 0.025"', 'type="mesh" mesh="link"')
        (here / ("inner.xml" if kind == "included" else "arm.xml")).write_text(text)
        (here / "outer.xml").write_text('<mujoco><include file="inner.xml"/></mujoco>')
    model = {"urdf": "arm.urdf", "package": "arm.urdf", "mjcf": "arm.xml", "included": "outer.xml"}[kind]
    pair_of(here, model)
    monkeypatch.chdir(tmp_path)
    assert load(f"{name}/pair.toml").model.nmesh == 2


@pytest.mark.parametrize("name", NAMES)
def test_a_plan_of_any_name_is_written_and_rehearsed(tmp_path: Path, short_plan: object, name: str) -> None:
    save(short_plan, tmp_path / name)  # type: ignore[arg-type]
    planned = Planned.load(tmp_path / name)
    assert load_stage(tmp_path / name).compile().nmesh
    if "\\" not in name:  # MuJoCo takes this for a slash
        assert mujoco.MjModel.from_xml_path(str(tmp_path / name / "robot.xml")).nmesh
    assert len(planned.times) > 100
    assert [path.name for path in tmp_path.iterdir()] == [name]


@pytest.fixture(scope="module")
def short_plan(tmp_path_factory: pytest.TempPathFactory) -> object:
    path = tmp_path_factory.mktemp("named")
    write_mesh(path / "link.stl")
    robot = of_urdf(path, shape='<mesh filename="link.stl"/>')
    return plan_fold(folder(path / "fold", span=0.24, width=0.18), robot, place=PLACE)


def test_an_included_file_of_another_folder_finds_its_meshes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_mesh(tmp_path / "mine" / "robot" / "assets" / "link.stl")
    text = mjcf(more='<asset><mesh name="link" file="assets/link.stl"/></asset>')
    text = text.replace('type="box" size="0.03 0.03 0.025"', 'type="mesh" mesh="link"')
    (tmp_path / "mine" / "robot" / "arm.xml").write_text(text)
    (tmp_path / "mine" / "scene.xml").write_text('<mujoco><include file="robot/arm.xml"/></mujoco>')
    pair_of(tmp_path / "mine", "scene.xml")
    for folder_, path in (
        (tmp_path, "mine/pair.toml"),
        (tmp_path / "mine", "pair.toml"),
        (tmp_path / "mine" / "robot", "../pair.toml"),
    ):
        monkeypatch.chdir(folder_)
        assert load(path).model.nmesh == 2


@pytest.mark.parametrize(
    "shape", ["shapes\\link.stl", "package://mine\\shapes\\link.stl", "package://mine/shapes\\link.stl"]
)
def test_paths_as_on_windows_are_read(tmp_path: Path, shape: str) -> None:
    write_mesh(tmp_path / "mine" / "shapes" / "link.stl")
    (tmp_path / "mine" / "arm.urdf").write_text(urdf(f'<mesh filename="{shape}"/>'))
    text = mjcf(more='<asset><mesh name="link" file="mine\\shapes\\link.stl"/></asset>')
    (tmp_path / "arm.xml").write_text(text.replace('type="box" size="0.03 0.03 0.025"', 'type="mesh" mesh="link"'))
    (tmp_path / "mine" / "hands.toml").write_text("[hands]\noffset = [0.001, 0.001, 0.001]\n")
    top = "packages = { mine = 'mine\\..\\mine' }\ndisturbances = 'mine\\hands.toml'"
    path = pair_of(tmp_path, "mine/arm.urdf", "arm.xml", top=top)
    path.write_text(path.read_text().replace('"mine/arm.urdf"', r"'mine\arm.urdf'"))
    robot = load(str(path))
    assert robot.model.nmesh == 2 and robot.disturbances is not None


def test_files_from_outside_the_folder_of_a_description_are_noted(tmp_path: Path) -> None:
    write_mesh(tmp_path / "elsewhere" / "link.stl")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "arm.urdf").write_text(urdf('<mesh filename="../elsewhere/link.stl"/>'))
    (note,) = load(str(pair_of(tmp_path / "mine", "arm.urdf"))).notes
    assert "from outside the folder" in note and str(tmp_path / "elsewhere" / "link.stl") in note


# Sizes


def png(side: int) -> bytes:
    """A grey picture that is small as a file."""

    def chunk(name: bytes, content: bytes) -> bytes:
        return struct.pack(">I", len(content)) + name + content + struct.pack(">I", zlib.crc32(name + content))

    header = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", b"") + chunk(b"IEND", b"")


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ('<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>', "height field: must have"),
        ('<asset><hfield name="h" file="hill.png" size="1 1 1 1"/></asset>', "height field: must have"),
        ('<worldbody><replicate count="100000"><geom size="1"/></replicate></worldbody>', "more than 20000 elements"),
        ("<size>" * 100_000 + "</size>" * 100_000, "nested more than 256 deep"),
        ("<worldbody>" + "<geom size='1'/>" * 30_000 + "</worldbody>", "more than 20000 elements"),
    ],
)
def test_a_model_that_is_too_large_is_one_line(tmp_path: Path, more: str, said: str) -> None:
    (tmp_path / "hill.png").write_bytes(png(50_000))
    assert said in refusal(load, str(pair_of_mjcf(tmp_path, mjcf(more=more))))
    if "hfield" not in more:
        assert said in refusal(load, str(pair_of_urdf(tmp_path, urdf(more=more))))


def test_pictures_are_never_opened(tmp_path: Path) -> None:
    (tmp_path / "wood.png").write_bytes(png(50_000))
    more = (
        '<asset><texture name="wood" type="2d" file="wood.png"/><material name="wood" texture="wood" rgba="1 0 0 1"/>'
        '<texture name="sky" type="skybox" builtin="flat" width="12000" height="72000"/></asset>'
    )
    text = mjcf(more=more).replace('type="box"', 'type="box" material="wood"')
    robot = load(str(pair_of_mjcf(tmp_path, text)))
    assert (robot.model.ntex, robot.model.nmat) == (0, 2)
    save(plan_fold(folder(tmp_path / "fold", span=0.24, width=0.18), robot, place=PLACE), tmp_path / "plan")
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "plan" / "robot.xml")).ntex == 0


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ('<asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset>', "height field: must have"),
        ("<size>" * 100_000 + "</size>" * 100_000, "nested more than 256 deep"),
    ],
)
def test_the_model_of_a_foreign_plan_has_the_same_limits(tmp_path: Path, more: str, said: str) -> None:
    (tmp_path / "robot.xml").write_text(mjcf(more=more))
    with pytest.raises(InputError, match=said):
        load_stage(tmp_path)


def test_the_pictures_of_a_foreign_plan_are_never_opened(tmp_path: Path) -> None:
    (tmp_path / "wood.png").write_bytes(png(50_000))
    (tmp_path / "robot.xml").write_text(mjcf(more='<asset><texture name="w" type="2d" file="wood.png"/></asset>'))
    assert load_stage(tmp_path).compile().ntex == 0
