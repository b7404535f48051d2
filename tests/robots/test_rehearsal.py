import json
import re
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from PIL import Image

from tatamu.api import learn
from tatamu.base.errors import InputError
from tatamu.folding.manipulation import HANDS
from tatamu.folding.task import make_task
from tatamu.robots import load, plan_fold
from tatamu.robots import save as save_plan
from tatamu.robots.film import HEIGHT, WIDTH, framed, save_film
from tatamu.robots.page import page
from tatamu.robots.planfile import Planned
from tatamu.robots.refold import Refold, halvings_for, refold, rehearsed_scene
from tatamu.robots.rehearsal import Rehearsal, _inertia, rehearse
from tatamu.robots.report import save, summary
from tatamu.robots.stage import CORNERS, FACES, link_boxes
from tatamu.simulation.body import Body
from tatamu.simulation.material import Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
from tatamu.study.options import LearnOptions
from tests.browser import Phone
from tests.commands import tatamu
from tests.refusals import refusal

MATERIAL = Material(
    areal_density=0.2,
    stretch_stiffness=300,
    poisson_ratio=0.25,
    bending_rigidity=1.5e-5,
    thickness=0.001,
    friction_table=0.5,
    friction_cloth=0.5,
)


@pytest.fixture(scope="module")
def done(plan_folder: Path) -> Rehearsal:
    return rehearse(Planned.load(plan_folder))


def scene() -> Scene:
    """Two triangles held at two corners: what matters here is the grippers."""
    corners = [[-0.17, -0.15, 0.0005], [0.17, -0.15, 0.0005], [0.17, 0.15, 0.0005], [-0.17, 0.15, 0.0005]]
    still: dict[str, Any] = {"closes": 0, "opens": 3.5, "times": [0.0], "displacements": [[0, 0, 0]]}
    hands = [Gripper(hand=name, vertices=[v], **still) for name, v in (("left", 3), ("right", 0))]
    cloth = Cloth(vertices=corners, faces=[[0, 1, 2], [0, 2, 3]])
    return Scene(cloth=cloth, material=MATERIAL, table=Table(), grippers=hands, duration=4.5)


def lifted(done: Rehearsal) -> float:
    """How far the jaws lift cloth that lies on the table [m]."""
    return done.planned.plan.jaws["larm"].height - 0.0005


def test_joints_and_tools_follow_the_plan(done: Rehearsal) -> None:
    assert done.joint_error.max() < 0.01
    assert done.tool_error < 0.001


def test_drives_are_as_strong_as_the_outstretched_arm_needs() -> None:
    """At zero angles this arm points straight up, and its first joint turns almost nothing."""
    import mujoco

    rod = '<geom type="capsule" fromto="0 0 0 0 0 0.6" size="0.01" mass="2"/>'
    elbow = f'<body name="rod"><joint name="raise" axis="0 1 0"/>{rod}</body>'
    world = f'<body name="foot"><joint name="turn" axis="0 0 1"/><geom size="0.01" mass="0.1"/>{elbow}</body>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{world}</worldbody></mujoco>")
    plan = SimpleNamespace(plan=SimpleNamespace(joints=["turn", "raise"]), angles=np.array([[0.0, np.pi / 2]] * 3))
    turn, lift = _inertia(model, cast(Planned, plan), ["turn", "raise"], mujoco)
    assert turn == pytest.approx(lift, rel=0.01)
    assert turn == pytest.approx(2 * 0.6**2 / 3, rel=0.05)
    assert model.dof_M0[0] < 0.01 * turn


def test_it_comes_back_to_the_initial_pose(done: Rehearsal) -> None:
    assert np.allclose(done.angles[-1], done.planned.angles[0], atol=0.01)


def test_nothing_touches(done: Rehearsal) -> None:
    assert done.contacts == []


def test_arms_that_are_driven_into_one_another_are_reported(plan_folder: Path, tmp_path: Path) -> None:
    planned = Planned.load(plan_folder)
    inwards = planned.angles[:400].copy()
    ramp = np.linspace(0, 1.1, 400)
    inwards[:, planned.plan.joints.index("LARM_JOINT0")] -= ramp
    inwards[:, planned.plan.joints.index("RARM_JOINT0")] += ramp
    found = rehearse(Planned(planned.folder, planned.plan, planned.times[:400], inwards))
    assert any({name[0] for name in contact.links} == {"L", "R"} for contact in found.contacts)
    assert "warning" in "\n".join(summary(save(found, tmp_path / "rehearsal")))


def test_the_hands_of_the_scene_go_where_the_tools_went(done: Rehearsal) -> None:
    rehearsed = rehearsed_scene(done, scene())
    left, right = rehearsed.grippers
    assert left.vertices == [3] and right.vertices == [0] and left.opens is not None
    # Both hands carry the edge over the whole span of the fold, up and down again.
    for hand in (left, right):
        assert np.allclose(hand.displacements[-1], [0.34, 0, 0.001 + lifted(done)], atol=1e-3)
        assert hand.displacements[:, 2].max() > 0.1
    assert rehearsed.duration == pytest.approx(left.opens + 1.0)
    assert Scene.model_validate(rehearsed.model_dump()).duration == rehearsed.duration


def test_fingers_of_the_learned_hands_are_the_robots_in_the_rehearsed_fold(done: Rehearsal) -> None:
    learned = scene()
    size = [0.01, 0.014, 0.004]
    hands = [Body(name=f"{hand} finger", hand=hand, shape="box", size=size, positions=[[9, 9, 9]]) for hand in HANDS]
    press = Body(name="press", shape="box", size=size, positions=[[9, 9, 9]])
    rehearsed = rehearsed_scene(done, learned.model_copy(update={"bodies": [*hands, press]}))
    assert [body.name for body in rehearsed.bodies] == [f"{h} {f} finger" for h in HANDS for f in ("lower", "upper")]
    jaw = done.planned.plan.jaws["larm"]
    lower = rehearsed.bodies[0]
    assert lower.size == pytest.approx([jaw.length / 2, jaw.width / 2, jaw.thickness / 2])
    middle = 0.5 * (done.planned.event("larm", "close") + done.planned.event("larm", "open")) - done.closes
    position, R = lower.pose(middle)
    assert R[2, 0] == pytest.approx(-np.cos(jaw.tilt), abs=1e-6), "the finger's axis is tilted as the tool is"
    tip = position + R @ [jaw.length / 2, 0, jaw.thickness / 2]
    row = int(np.searchsorted(done.times, middle + done.closes))
    X_BF = done.planned.plan.task_in_base.matrix
    assert np.linalg.norm(tip - (done.tools[0, row] - X_BF[:3, 3]) @ X_BF[:3, :3]) < 0.003
    assert rehearsed_scene(done, learned).bodies == []


def test_layers_that_fingers_press_down_go_with_the_hand(done: Rehearsal) -> None:
    held, down = scene(), np.array([0.0, 0.0, -0.02])
    left: dict[str, Any] = {"hand": "left", "closes": 0, "opens": 3.5}
    right = {**left, "hand": "right"}
    parts = [
        Gripper(vertices=[3], times=[0.1, 3.0], displacements=[[0, 0, 0], [0.3, 0, 0]], **left),
        Gripper(
            vertices=[2], times=[0, 0.1, 3.0], displacements=[[0, 0, 0], down, down + np.array([0.3, 0, 0])], **left
        ),
        Gripper(vertices=[0], times=[0.1, 3.0], displacements=[[0, 0, 0], [0.3, 0, 0]], **right),
    ]
    rehearsed = rehearsed_scene(done, held.model_copy(update={"grippers": parts}))
    first, pressed, other = rehearsed.grippers
    assert [gripper.vertices for gripper in rehearsed.grippers] == [[3], [2], [0]]
    assert pressed.displacements[-1] - first.displacements[-1] == pytest.approx(down)
    assert pressed.displacements[0] == pytest.approx(np.zeros(3), abs=1e-9)
    assert other.displacements[-1] == pytest.approx(np.array([0.34, 0, 0.001 + lifted(done)]), abs=1e-3)
    with pytest.raises(InputError, match="must have one item for each of 2 folding arms, given 1"):
        rehearsed_scene(done, held.model_copy(update={"grippers": parts[:2]}))


def made_up(done: Rehearsal, learned: Scene, shift: np.ndarray) -> Refold:
    """A fold by the robot's hands that ends `shift` [m] from the one by floating hands; the target is as far in y."""
    rehearsed = rehearsed_scene(done, learned)
    positions = np.array(rehearsed.cloth.vertices)[None]
    toy = {"simulator": "toy"}
    robot = Rollout(np.zeros(1), positions + shift, rehearsed.cloth.faces, toy)
    floating = Rollout(np.zeros(1), positions, rehearsed.cloth.faces, toy)
    return Refold("toy", 0, 4, rehearsed, robot, floating, positions[0] + shift * [0, 1, 0], unscored="made up")


def test_figures_of_the_fold_are_distances_of_vertices(done: Rehearsal, tmp_path: Path) -> None:
    figures = save(done, tmp_path, made_up(done, scene(), np.array([0, 0.003, 0.004])))
    assert figures["fold"]["distance_to_floating_hands"] == pytest.approx(0.005)
    assert figures["fold"]["mean_vertex_distance"] == pytest.approx(0.004)
    assert json.loads((tmp_path / "rehearsal.json").read_text()) == figures
    assert Scene.load(tmp_path / "scene.json").grippers[0].vertices == [3]
    assert (tmp_path / "floating.npz").is_file()
    assert "not scored: made up" in summary(figures)


@pytest.mark.parametrize(("shift", "word"), [(0.009, "as planned"), (0.011, "not as planned")])
def test_the_page_says_whether_it_went_as_planned(
    done: Rehearsal, tmp_path: Path, shift: float, word: str, phone: Phone
) -> None:
    fold = made_up(done, scene(), np.array([shift, 0.0, 0.0]))
    text = page(done, save(done, tmp_path, fold), fold)
    phone(text)
    assert f">{word}</span>" in text
    assert "at least 0.01" in text and "while they hold the cloth" in text
    assert "No forbidden contact between links" in text and "joint limit margin" in text and 'data-show="robot"' in text


def test_boxes_of_the_links_go_where_the_tools_went(done: Rehearsal) -> None:
    rows = np.flatnonzero(done.holding("larm"))[[300, 700]].tolist()  # the fingers are closed
    points, faces = link_boxes(done.planned, done.angles[rows], done.times[rows])
    X_BF = done.planned.plan.task_in_base.matrix
    tools = (done.tools[:, rows] - X_BF[:3, 3]) @ X_BF[:3, :3]
    nearest = np.linalg.norm(points - tools[:, :, None], axis=3).min(axis=2)  # corners of the fingers
    assert nearest.max() < 0.04 and np.ptp(nearest, axis=1).max() < 1e-4
    assert np.abs(np.diff(tools, axis=1)).max() > 0.1
    assert faces.max() == points.shape[1] - 1


def test_the_sides_of_a_box_face_outwards() -> None:
    a, b, c = CORNERS[FACES].transpose(1, 0, 2)
    assert (np.einsum("ij,ij->i", np.cross(b - a, c - a), a) > 0).all()


def fine(spacing: float) -> Scene:
    """A square of a few cells, whose bending length is about 20 mm."""
    grid = np.array([[x, y, 0.0005] for y in range(3) for x in range(3)]) * [spacing, spacing, 1.0]
    faces = [[a, a + 1, a + 4] for a in (0, 1, 3, 4)] + [[a, a + 4, a + 3] for a in (0, 1, 3, 4)]
    return Scene(cloth=Cloth(vertices=grid, faces=faces), material=MATERIAL, table=Table(), grippers=[], duration=1.0)


@pytest.mark.parametrize(("spacing", "halvings"), [(0.006, 0), (0.012, 1), (0.024, 2), (0.1, 2)])
def test_meshes_are_halved_until_mujoco_can_fold_them(spacing: float, halvings: int) -> None:
    assert MATERIAL.bending_length == pytest.approx(0.0197, abs=1e-4)
    assert halvings_for(fine(spacing), "mujoco") == halvings
    assert halvings_for(fine(spacing), "native") == 0


@pytest.fixture(scope="module")
def towel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The plan of a small towel that was really learned, in few trials on a coarse mesh."""
    folder = tmp_path_factory.mktemp("towel")
    task = make_task("towel", size=(0.30, 0.30), spacing=0.03)
    learn(task, LearnOptions(trials=1, baselines=False, disturbances="none"), out=folder / "learned")
    save_plan(plan_fold(folder / "learned", load("hironx")), folder / "plan")
    return folder / "plan"


def test_the_rehearsed_fold_is_scored_as_learned_folds_are(towel: Path, tmp_path: Path) -> None:
    rehearsed = rehearse(Planned.load(towel))
    fold = refold(rehearsed, "native")
    assert fold is not None and fold.learned is not None
    told = json.loads((towel / "fold" / "result.json").read_text())
    best = told["trials"][told["best"]]
    for scores in (fold.scores["learned"], fold.scores["floating"]):
        assert scores.model_dump() == pytest.approx({name: best[name] for name in scores.model_dump()}, abs=1e-6)
    assert fold.apart.mean() < 0.010
    figures = save(rehearsed, tmp_path, fold)
    assert figures["fold"]["scores"]["robot"]["mask_iou"] == fold.scores["robot"].mask_iou
    assert any(line.split()[:2] == ["mask", "iou"] for line in summary(figures))
    assert "Mask IoU" in page(rehearsed, figures, fold)


def test_on_a_finer_mesh_it_is_the_same_fold_on_the_learned_vertices(towel: Path) -> None:
    rehearsed = rehearse(Planned.load(towel))
    coarse, halved = (refold(rehearsed, "native", halvings) for halvings in (0, 1))
    assert coarse is not None and halved is not None
    assert halved.simulated_vertices > 3 * coarse.simulated_vertices
    assert halved.robot.positions.shape == coarse.robot.positions.shape
    assert np.linalg.norm(halved.robot.positions[-1] - coarse.robot.positions[-1], axis=1).mean() < 0.02


def test_a_plan_without_results_is_rehearsed_and_not_scored(towel: Path, tmp_path: Path) -> None:
    shutil.copytree(towel, tmp_path / "plan")
    (tmp_path / "plan" / "fold" / "result.json").unlink()
    fold = refold(rehearse(Planned.load(tmp_path / "plan")), "native")
    assert fold is not None and fold.scores == {} and "result.json" in str(fold.unscored)


def test_the_film_lasts_as_long_as_the_motion(done: Rehearsal, tmp_path: Path) -> None:
    why_not = save_film(done, None, tmp_path / "film.gif")
    if why_not:
        pytest.skip(f"this machine cannot draw: {why_not}")
    opened: Any = Image.open(tmp_path / "film.gif")
    with opened as film:
        lasting = 0
        for frame in range(film.n_frames):
            film.seek(frame)
            lasting += film.info["duration"]
        assert film.n_frames > 50  # still frames are written as one
        assert lasting == pytest.approx(1000 * done.times[-1], abs=200)


@pytest.fixture
def broken(plan_folder: Path, tmp_path: Path) -> Path:
    """A copy of a plan, for tests to break."""
    shutil.copytree(plan_folder, tmp_path / "broken")
    return tmp_path / "broken"


@pytest.mark.parametrize(
    ("name", "text", "field"),
    [
        ("plan.json", "{}", "version"),
        ("plan.json", "[", "JSON"),
        ("joint_trajectory.csv", "time,a\n0,0\n", "header"),
        ("robot.xml", "<mujoco>", "robot.xml: cannot be read as URDF or MJCF .*no element found"),
        ("robot.xml", ("larm_tool", "larm_t"), "robot.xml: .*larm_tool"),
        ("plan.json", ('"WAIST"', '"HIP"'), "robot.xml: .*HIP"),
    ],
)
def test_a_broken_plan_is_named(broken: Path, name: str, text: str | tuple[str, str], field: str) -> None:
    path = broken / name
    path.write_text(text if isinstance(text, str) else path.read_text().replace(*text))
    assert re.search(field, refusal(lambda: rehearse(Planned.load(broken))))


@pytest.mark.parametrize(
    ("row", "column", "value", "named"),
    [
        (5, 3, "inf", "two rows of finite numbers"),
        (5, 3, "nan", "two rows of finite numbers"),
        (5, 3, "fast", "a number in every field"),
        (5, 3, "1e300", "CHEST.*|HEAD.*: must be within ±100 rad, given 1e"),
        (-1, 0, "1e9", "time: must increase from row to row, and lie between 0 and 3600 s"),
        (1, 0, "-1", "time: must increase from row to row, and lie between 0"),
        (9, 0, "0", "time: must increase from row to row, and lie between 0"),
        (5, 3, "9" * 200_000, "must be a table of numbers"),
        (5, 3, "1,1", "a number in every field"),
    ],
)
def test_a_table_that_is_none_of_a_robot_is_one_line(
    broken: Path, row: int, column: int, value: str, named: str
) -> None:
    path = broken / "joint_trajectory.csv"
    rows = [line.split(",") for line in path.read_text().splitlines()]
    rows[row][column] = value
    path.write_text("\n".join(",".join(fields) for fields in rows))
    assert re.search(named, refusal(Planned.load, broken))


@pytest.mark.parametrize("value", [1e308, "NaN", "far"])
def test_a_place_that_is_none_is_one_line(broken: Path, value: float | str) -> None:
    path = broken / "plan.json"
    plan = json.loads(path.read_text())
    plan["task_in_base"]["yaw"] = float("nan") if value == "NaN" else value
    path.write_text(json.dumps(plan))
    assert "task_in_base.yaw" in refusal(Planned.load, broken)


def test_a_table_that_ends_before_the_hands_open_is_refused(broken: Path) -> None:
    path = broken / "joint_trajectory.csv"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:1700]))
    said = refusal(Planned.load, broken)
    assert "joint_trajectory.csv: must last until the last event in plan.json, but ends at 8.49 s" in said


def test_a_folder_that_is_no_plan_is_named(fold: Path) -> None:
    with pytest.raises(InputError, match=r"fold: must be the folder of a plan, but has no plan.json"):
        Planned.load(fold)


def test_a_plan_without_a_scene_says_that_no_cloth_is_folded(plan_folder: Path, tmp_path: Path) -> None:
    shutil.copytree(plan_folder, tmp_path / "plan")
    done = tatamu("rehearse", str(tmp_path / "plan"), "--simulator=native", "--no-film")
    assert done.returncode == 0 and "fold/scene.json is missing" in done.stdout


def test_the_camera_is_as_near_as_shows_everything() -> None:
    points = np.random.default_rng(0).uniform([-1, -0.3, 0], [0.5, 2, 1], (50, 3))
    middle, distance = framed(points, np.full(50, 0.05), (215.0, -28.0), 45.0)
    a, e = np.radians([215.0, -28.0])
    ahead = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    seen = points - (middle - distance * ahead)
    depth = seen @ ahead
    right = np.cross(ahead, [0, 0, 1]) / np.cos(e)
    up = np.cross(right, ahead)
    high = np.tan(np.radians(22.5))
    share = (np.abs(seen @ np.array([right, up]).T) + 0.05) / depth[:, None] / [high * WIDTH / HEIGHT, high]
    assert share.max() == pytest.approx(1.0)
