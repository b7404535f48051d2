import json
import shutil
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mink")
pytest.importorskip("toppra")

from tatamu.errors import InputError
from tatamu.material import Material
from tatamu.robots.film import save_film
from tatamu.robots.planned import Planned
from tatamu.robots.rehearsal import Rehearsal, rehearse
from tatamu.robots.report import save, summary
from tatamu.rollout import Rollout
from tatamu.scene import Cloth, Gripper, Scene, Table

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
    hands = [Gripper(vertices=[v], closes=0, opens=3.5, times=[0.0], displacements=[[0, 0, 0]]) for v in (3, 0)]
    cloth = Cloth(vertices=corners, faces=[[0, 1, 2], [0, 2, 3]])
    return Scene(cloth=cloth, material=MATERIAL, table=Table(), grippers=hands, duration=4.5)


def test_joints_and_tools_follow_the_plan(done: Rehearsal) -> None:
    assert done.joint_error.max() < 0.01
    assert done.tool_error < 0.001


def test_it_comes_back_to_the_initial_pose(done: Rehearsal) -> None:
    assert np.allclose(done.angles[-1], done.planned.angles[0], atol=0.01)


def test_nothing_touches(done: Rehearsal) -> None:
    assert done.contacts == []


def test_arms_that_are_driven_into_one_another_are_reported(plan_folder: Path, tmp_path: Path) -> None:
    shutil.copytree(plan_folder, tmp_path / "bad")
    planned = Planned.load(tmp_path / "bad")
    inwards = planned.angles[:400].copy()
    ramp = np.linspace(0, 1.1, 400)
    inwards[:, planned.plan.joints.index("LARM_JOINT0")] -= ramp
    inwards[:, planned.plan.joints.index("RARM_JOINT0")] += ramp
    found = rehearse(Planned(planned.folder, planned.plan, planned.times[:400], inwards))
    assert any({name[0] for name in contact.links} == {"L", "R"} for contact in found.contacts)
    assert "warning" in "\n".join(summary(save(found, tmp_path / "bad" / "rehearsal")))


def test_the_hands_of_the_scene_go_where_the_tools_went(done: Rehearsal) -> None:
    rehearsed = done.scene(scene())
    left, right = rehearsed.grippers
    assert left.vertices == [3] and right.vertices == [0] and left.opens is not None
    # Both hands carry the edge over the whole span of the fold, up and down again.
    for hand in (left, right):
        assert np.allclose(hand.displacements[-1], [0.34, 0, 0.001], atol=1e-3)
        assert hand.displacements[:, 2].max() > 0.1
    assert rehearsed.duration == pytest.approx(left.opens + 1.0)
    assert Scene.model_validate(rehearsed.model_dump()).duration == rehearsed.duration


def test_figures_of_the_fold_are_distances_of_vertices(done: Rehearsal, tmp_path: Path) -> None:
    rehearsed = done.scene(scene())
    positions = np.array(rehearsed.cloth.vertices)[None]
    robot = Rollout(np.zeros(1), positions + np.array([0, 0.003, 0.004]), rehearsed.cloth.faces, {"simulator": "toy"})
    floating = Rollout(np.zeros(1), positions, rehearsed.cloth.faces, {"simulator": "toy"})
    figures = save(done, tmp_path, (rehearsed, robot, floating, positions[0] + np.array([0, 0.003, 0])))
    assert figures["fold"]["distance_to_floating_hands"] == pytest.approx(0.005)
    assert figures["fold"]["mean_vertex_distance"] == pytest.approx(0.004)
    assert json.loads((tmp_path / "rehearsal.json").read_text()) == figures
    assert Scene.load(tmp_path / "scene.json").grippers[0].vertices == [3]


def test_the_film_lasts_as_long_as_the_motion(done: Rehearsal, tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image")
    why_not = save_film(done, None, tmp_path / "film.gif")
    if why_not:
        pytest.skip(f"this machine cannot draw: {why_not}")
    with image.open(tmp_path / "film.gif") as film:
        lasting = 0
        for frame in range(film.n_frames):
            film.seek(frame)
            lasting += film.info["duration"]
        assert film.n_frames > 50  # still frames are written as one
        assert lasting == pytest.approx(1000 * done.times[-1], abs=200)


@pytest.mark.parametrize(
    ("name", "text", "field"),
    [
        ("plan.json", "{}", "version"),
        ("plan.json", "[", "JSON"),
        ("joint_trajectory.csv", "time,a\n0,0\n", "header"),
        ("robot.xml", "<mujoco>", "cannot be rehearsed"),
    ],
)
def test_a_broken_plan_is_named(plan_folder: Path, tmp_path: Path, name: str, text: str, field: str) -> None:
    shutil.copytree(plan_folder, tmp_path / "broken")
    (tmp_path / "broken" / name).write_text(text)
    with pytest.raises(InputError, match=field) as error:
        rehearse(Planned.load(tmp_path / "broken"))
    assert "\n" not in str(error.value)
