"""Fingers are rigid bodies: they come under the hem, close, carry it, open, and leave along their own axis."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import InputError
from tatamu.api import learn
from tatamu.evaluation.disturbances import Disturbances, Scenario, disturbed_scene, load_disturbances
from tatamu.evaluation.nominal import Nominal
from tatamu.folding.fingers import PRESETS, Fingers
from tatamu.folding.hand import AWAY, LEAVING, OPENING, leaves
from tatamu.folding.manipulation import WAIT
from tatamu.folding.parameters import initial_curves, later_curves, search_space
from tatamu.folding.task import Task, make_task
from tatamu.folding.trial_scene import scene_of
from tatamu.simulation.clearance import deepest
from tatamu.simulation.scene import Scene
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result

SMALL: dict[str, Any] = {"spacing": 0.04, "size": (0.24, 0.5)}
THICK = Fingers(thickness=0.008, width=0.02)
LOW = {"x1": 0.3, "z1": 0.002, "x2": 0.4, "z2": 0.002, "g1": 0, "g2": 0}
ARCH = {"x1": 0.05, "z1": 0.2, "x2": 0.4, "z2": 0.1, "g1": 0, "g2": 0}


@pytest.fixture(scope="module")
def task() -> Task:
    return make_task("towel", fingers=THICK, **SMALL)


@pytest.fixture(scope="module")
def scene(task: Task) -> Scene:
    return scene_of(task.fold, task.manipulation(ARCH))


def lowest(scene: Scene, number: int, time: float) -> float:
    """The lowest point of a body [m]."""
    body = scene.bodies[number]
    centre, turned = body.pose(time)
    return float(centre[2] - np.abs(turned[2]) @ body.core)


def test_hands_without_fingers_are_as_they_were() -> None:
    bare = make_task("towel", **SMALL)
    thin = make_task("towel", fingers=Fingers(), **SMALL)
    scenes = [scene_of(each.fold, each.manipulation(LOW)).model_dump_json() for each in (bare, thin)]
    assert scenes[0] == scenes[1]
    assert not scene_of(bare.fold, bare.manipulation(LOW)).bodies
    assert bare.space.bounds["z1"].low == 0.0 and leaves(Fingers()) == 0.0


def test_a_hand_is_two_fingers(scene: Scene) -> None:
    names = ["left lower finger", "left upper finger", "right lower finger", "right upper finger"]
    assert [body.name for body in scene.bodies] == names
    assert all(body.size == [0.01, 0.01, 0.004] for body in scene.bodies)


def test_the_lower_finger_stands_on_the_table_under_the_hem(task: Task, scene: Scene) -> None:
    hem = task.fold.start[scene.grippers[0].vertices] + scene.grippers[0].displacement(WAIT)
    assert lowest(scene, 0, WAIT) == pytest.approx(0.0, abs=2e-4)
    assert hem[0, 2] == pytest.approx(THICK.lift + 0.5 * scene.material.thickness, abs=1e-6)
    half = 0.5 * scene.material.thickness
    for number in (0, 1):  # the cloth between the fingers touches both
        distance = scene.bodies[number].distance(scene.bodies[number].local(hem, WAIT))
        assert distance.min() == pytest.approx(half, abs=1e-5)
    axis = scene.bodies[0].pose(WAIT)[1][:, 0]
    assert axis[:2] @ task.fold.normal == pytest.approx(np.cos(THICK.tilt)) and axis[2] < 0.0


def test_the_orientation_is_fixed_and_the_hand_leaves_along_its_axis(task: Task, scene: Scene) -> None:
    opens = task.manipulation(ARCH).timing.opens
    poses = [scene.bodies[0].pose(time) for time in (0.0, 0.5, opens, opens + OPENING, opens + OPENING + LEAVING)]
    for _, turned in poses[1:]:
        assert turned == pytest.approx(poses[0][1])
    stood, opened, left = (position for position, _ in poses[2:])
    assert opened == pytest.approx(stood), "the lower finger has layers below it"
    assert left - opened == pytest.approx(-AWAY * poses[0][1][:, 0], abs=1e-9)
    up = scene.bodies[1].pose(opens + OPENING)[0] - scene.bodies[1].pose(opens)[0]
    assert up == pytest.approx(THICK.opening * poses[0][1][:, 2], abs=1e-9)
    under = task.fold.stacks.under[scene.grippers[0].vertices[0]]
    on_top = under + scene.material.thickness
    assert lowest(scene, 0, opens) == pytest.approx(on_top, abs=2e-4), "it lies on the flap, inside the turned hem"


def test_the_search_stays_above_the_release(task: Task) -> None:
    space = task.space.bounds
    assert space["z1"].low == space["z2"].low == pytest.approx(2.0 * task.fold.garment.material.thickness, abs=1e-6)


def test_a_fold_with_fingers_lies_as_well_and_no_finger_stands_in_the_cloth(task: Task, scene: Scene) -> None:
    found = Nominal(task)(ARCH)
    assert found.score is not None and found.score.mean_vertex_distance < 0.008
    assert found.rollout is not None
    held = np.isin(scene.cloth.faces, scene.grippers[0].vertices + scene.grippers[1].vertices).any(axis=1)
    for frame in range(0, len(found.rollout.times), 5):
        time, points = float(found.rollout.times[frame]), found.rollout.positions[frame]
        for body in scene.bodies:
            assert deepest(body, points, scene.cloth.faces[~held], time) < -0.2 * scene.material.thickness


def test_fingers_that_are_too_low_stop_at_the_table(task: Task) -> None:
    scene = disturbed_scene(task.fold, task.manipulation(LOW), Scenario({"hands.offset.up": -0.003}))
    assert min(lowest(scene, 0, time) for time in np.linspace(WAIT, scene.duration, 50)) > -1e-6
    usual = scene_of(task.fold, task.manipulation(LOW))
    ends = [lowest(each, 0, task.manipulation(LOW).timing.opens) for each in (scene, usual)]
    assert ends[1] - ends[0] == pytest.approx(0.25 * scene.material.thickness, abs=1e-6), "it presses on the layers"
    high = disturbed_scene(task.fold, task.manipulation(LOW), Scenario({"hands.offset.up": 0.003}))
    assert lowest(high, 0, WAIT) == pytest.approx(0.003, abs=2e-4)


def test_fingers_stand_where_a_grasp_went_wrong(task: Task) -> None:
    manipulation = task.manipulation(ARCH)
    usual = scene_of(task.fold, manipulation)
    wrong = disturbed_scene(task.fold, manipulation, Scenario({"grasp.into.left": 0.007, "grasp.along.right": 0.004}))
    moved = [wrong.bodies[n].pose(WAIT)[0] - usual.bodies[n].pose(WAIT)[0] for n in (0, 2)]
    assert moved[0][:2] == pytest.approx(0.007 * task.fold.normal, abs=1e-6)
    assert moved[1][:2] == pytest.approx(0.004 * task.fold.crease.along, abs=1e-6)


def test_fingers_stand_in_the_file_and_in_the_folder(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("[fingers]\nthickness = 0.008\nwidth = 0.02\n")
    disturbances = load_disturbances(str(tmp_path / "mine.toml"))
    assert disturbances is not None and disturbances.fingers == THICK
    for wrong in ("thickness = -0.008", "length = 0.0", "tilt = 1.6", "opening = 'wide'", "compliance = -1"):
        (tmp_path / "mine.toml").write_text(f"[fingers]\n{wrong}\n")
        with pytest.raises(InputError, match=rf"mine.toml: fingers\.{wrong.split()[0]}: "):
            load_disturbances(str(tmp_path / "mine.toml"))
    assert Disturbances().fingers == Fingers()
    folder = tmp_path / "learned"
    options = LearnOptions(trials=4, disturbances="none", baselines=False)
    learn(make_task("towel", fingers=THICK, **SMALL), options, out=folder)
    again = Result.load(folder)
    assert again.record.task.fingers == THICK
    assert again.task.fold.fingers == THICK
    assert (folder / "report.html").exists()
    scene = scene_of(again.task.fold, again.task.manipulation(again.best.parameters))
    for one, other in zip(scene.bodies, again.scene.bodies, strict=True):
        assert one.name == other.name and one.positions == pytest.approx(np.asarray(other.positions), abs=1e-9)


def test_a_preset_stands_for_the_sizes_of_its_hand(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('[fingers]\npreset = "robotiq-2f-85"\nwidth = 0.03\n')
    known = load_disturbances(str(path))
    assert known is not None and known.fingers == Fingers(**{**PRESETS["robotiq-2f-85"], "width": 0.03})
    assert Fingers.model_validate(known.fingers.model_dump()) == known.fingers
    path.write_text('[fingers]\npreset = "claw"\n')
    with pytest.raises(InputError, match=r"mine.toml: fingers: preset must be one of franka-hand, .*given 'claw'"):
        load_disturbances(str(path))
    path.write_text('[fingers]\npreset = ["franka-hand"]\n')
    with pytest.raises(InputError, match="preset must be one of"):
        load_disturbances(str(path))


def test_a_search_begins_with_curves_that_fingers_can_follow(task: Task) -> None:
    space = search_space(task.fold, "integer").bounds
    for curve in [*initial_curves(task.fold, robust=True), *later_curves(task.fold)]:
        assert all(space[name].low <= value <= space[name].high for name, value in curve.items())


def test_hems_are_let_go_before_their_place_by_what_goes_round_the_finger(task: Task) -> None:
    bare = replace(task, fingers=Fingers())
    vertex = int(task.fold.left[0])
    short = bare.fold.translation(vertex) - task.fold.translation(vertex)
    assert short[:2] @ task.fold.normal == pytest.approx(THICK.setback)
    assert short[2] == pytest.approx(-task.fold.garment.material.thickness), "the layers go under the finger, too"
    lengths = [Nominal(each).task.space.known_part for each in (bare, task)]
    assert all(lengths) and task.manipulation(ARCH).trajectory_length < bare.manipulation(ARCH).trajectory_length
