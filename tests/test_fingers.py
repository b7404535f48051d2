"""Fingers: cloth is carried, and let go, no lower than the lower finger allows."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import InputError
from tatamu.api import learn
from tatamu.disturbances import Disturbances, World, disturbed_scene, load_disturbances
from tatamu.evaluation import Nominal
from tatamu.folding.baselines import BASELINES
from tatamu.folding.finger_clearance import lowest_lift
from tatamu.folding.fingers import Fingers
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.parameters import first_curves, later_curves, search_space
from tatamu.folding.task import Task, make_task
from tatamu.folding.trial_scene import scene_of
from tatamu.options import LearnOptions
from tatamu.study import Result

SMALL: dict[str, Any] = {"spacing": 0.04, "size": (0.24, 0.5)}
THICK = Fingers(thickness=0.008, width=0.02)
LOW = {"x1": 0.3, "z1": 0.002, "x2": 0.4, "z2": 0.002, "g1": 0, "g2": 0}


@pytest.fixture(scope="module")
def task() -> Task:
    return make_task("towel", fingers=THICK, **SMALL)


def clearance(task: Task, manipulation: Manipulation) -> float:
    """The least distance of a lower finger from what lies below it [m]."""
    fold = task.fold
    gaps = [
        (gripper.displacements[:, 2] - lowest_lift(fold, vertex, gripper.displacements))[
            len(gripper.times) - frames :
        ].min()
        for gripper, vertex in zip(scene_of(fold, manipulation).grippers, manipulation.grasps, strict=True)
        for frames in [len(manipulation.motion()[0])]
    ]
    return float(min(gaps))


def test_hands_without_fingers_are_as_they_were() -> None:
    bare = make_task("towel", **SMALL)
    thin = make_task("towel", fingers=Fingers(), **SMALL)
    scenes = [scene_of(each.fold, each.manipulation(LOW)).model_dump_json() for each in (bare, thin)]
    assert scenes[0] == scenes[1]
    assert bare.space.bounds["z1"].low == 0.0


def test_no_finger_touches_what_lies_below_it(task: Task) -> None:
    bare = replace(task, fingers=Fingers())
    for name, (_, make) in BASELINES.items():
        assert clearance(task, make(task.fold)) > -1e-6, name
    assert clearance(task, task.manipulation(LOW)) > -1e-6
    low = scene_of(bare.fold, bare.manipulation(LOW)).grippers[0].displacements[:, 2]
    assert low.max() < THICK.thickness  # without fingers it is drawn over the table


def test_hands_take_the_cloth_off_the_table_and_let_go_a_finger_above_the_layers(task: Task) -> None:
    manipulation = task.manipulation(LOW)
    gripper = scene_of(task.fold, manipulation).grippers[0]
    assert gripper.displacements[0, 2] == 0.0 and gripper.times[0] == 0.0
    assert gripper.displacement(0.1)[2] == pytest.approx(THICK.thickness, abs=1e-6)
    thickness = task.fold.garment.material.thickness
    assert gripper.displacements[-1, 2] == pytest.approx(THICK.thickness + thickness, abs=1e-6)
    assert manipulation.curves[0].control[0, 2] - manipulation.positions[0][2] == pytest.approx(THICK.thickness)


def test_the_search_stays_above_the_release(task: Task) -> None:
    space = task.space.bounds
    assert space["z1"].low == space["z2"].low == pytest.approx(task.fold.garment.material.thickness, abs=1e-6)


def test_a_fold_with_fingers_lies_as_well(task: Task) -> None:
    found = Nominal(task)({**LOW, "x1": 0.05, "z1": 0.2, "z2": 0.1})
    assert found.score is not None and found.score.mean_vertex_distance < 0.006


def test_a_finger_that_is_too_low_bears_down(task: Task) -> None:
    manipulation = task.manipulation(LOW)
    scene = disturbed_scene(task.fold, manipulation, World({"hands.offset.up": -0.003}))
    below = scene.cloth.vertices[scene.grippers[0].vertices, 2].min() + scene.grippers[0].displacements[:, 2]
    assert below.min() == pytest.approx(0.5 * task.fold.garment.material.thickness, abs=1e-6)
    high = disturbed_scene(task.fold, manipulation, World({"hands.offset.up": 0.003}))
    assert high.grippers[0].displacements[-1, 2] == pytest.approx(THICK.thickness + 0.002 + 0.003, abs=1e-6)


def test_fingers_stand_in_the_file_and_in_the_folder(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("[fingers]\nthickness = 0.008\nwidth = 0.02\n")
    disturbances = load_disturbances(str(tmp_path / "mine.toml"))
    assert disturbances is not None and disturbances.fingers == THICK
    (tmp_path / "mine.toml").write_text("[fingers]\nthickness = -0.008\n")
    with pytest.raises(InputError, match=r"fingers\.thickness"):
        load_disturbances(str(tmp_path / "mine.toml"))
    assert Disturbances().fingers == Fingers()
    folder = tmp_path / "learned"
    options = LearnOptions(trials=4, disturbances="none", coarse=False, baselines=False)
    learn(make_task("towel", fingers=THICK, **SMALL), options, out=folder)
    again = Result.load(folder)
    assert again.record.task.fingers == THICK
    assert again.task.fold.fingers == THICK
    scene = scene_of(again.task.fold, again.task.manipulation(again.best.parameters))
    for one, other in zip(scene.grippers, again.scene.grippers, strict=True):
        assert one.displacements == pytest.approx(np.asarray(other.displacements), abs=1e-9)


def test_a_preset_stands_for_the_sizes_of_its_hand(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('[fingers]\npreset = "robotiq-2f-85"\nwidth = 0.03\n')
    known = load_disturbances(str(path))
    assert known is not None and known.fingers == Fingers(thickness=0.008, width=0.03)
    assert Fingers.model_validate(known.fingers.model_dump()) == known.fingers
    path.write_text('[fingers]\npreset = "claw"\n')
    with pytest.raises(InputError, match=r"mine.toml: fingers: preset must be one of franka-hand, .*given 'claw'"):
        load_disturbances(str(path))


def test_a_search_begins_with_curves_that_fingers_can_follow(task: Task) -> None:
    space = search_space(task.fold, "integer").bounds
    for curve in [*first_curves(task.fold), *later_curves(task.fold)]:
        assert all(space[name].low <= value <= space[name].high for name, value in curve.items())


def test_a_plain_search_with_fingers_is_learned(tmp_path: Path) -> None:
    options = LearnOptions(trials=6, disturbances="none", coarse=False, baselines=False)
    learn(make_task("towel", fingers=THICK, **SMALL), options, out=tmp_path)
    assert (tmp_path / "report.html").exists()


def test_a_preset_that_is_no_name_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('[fingers]\npreset = ["franka-hand"]\n')
    with pytest.raises(InputError, match="preset must be one of"):
        load_disturbances(str(path))
