"""Disturbances: files that are wrong are refused, worlds are reproducible, and scenes differ as the world says."""

from __future__ import annotations

import tomllib
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tatamu import InputError
from tatamu.evaluation.disturbances import (
    CHANNELS,
    NOMINAL,
    Disturbances,
    Scenario,
    Stream,
    default_disturbances,
    deviations,
    disturbed_hands,
    disturbed_scene,
    hand_failure,
    load_disturbances,
    sample_scenarios,
    with_calibrated,
)
from tatamu.evaluation.disturbances.channels import FIELDS, SHOWN
from tatamu.evaluation.disturbances.description import OWN
from tatamu.evaluation.draws import Draws, Subject, simulate_outcome
from tatamu.evaluation.nominal import Nominal
from tatamu.evaluation.outcome import BESIDE_TARGET, CRUSHED, UNSIMULATED, Outcome
from tatamu.evaluation.success import Success
from tatamu.folding.fingers import Fingers
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import Limits
from tatamu.folding.task import Task
from tatamu.folding.trial_scene import scene_of
from tatamu.simulation.material import Material
from tatamu.simulation.scene import Scene
from tests.refusals import refusal
from tests.small_studies import towel

LOW = {"x1": 0.02, "z1": 0.15, "x2": 0.3, "z2": 0.01, "g1": 0, "g2": 0}
MATRIX = "[correlation]\nparameters = ['bending_rigidity', 'friction_table']\nmatrix = "
BOTH = "[material]\nbending_rigidity = 0.2\nfriction_table = 0.1\n"


@pytest.fixture(scope="module")
def task() -> Task:
    return towel()


@pytest.fixture(scope="module")
def low(task: Task) -> Manipulation:
    return task.manipulation(LOW)


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("[hands]\noffset = [0.005, 0.005]", "hands.offset"),
        ("[hands]\noffset = [0.005, -0.001, 0.0]", "hands.offset.1"),
        ("[hands]\nyaw = -0.1", "hands.yaw"),
        ("[hands]\nspeed = 'fast'", "hands.speed"),
        ("[hands]\ntwist = 0.1", "hands.twist"),
        ("[table]\nheight = nan", "table.height"),
        ("[material]\ncolour = 0.1", "material.colour"),
        ("[material]\nbending_rigidity = -0.2", "material.bending_rigidity"),
        ("wind = 1", "wind"),
        (BOTH + MATRIX + "[[1.0, 0.5], [0.4, 1.0]]", "symmetric"),
        (BOTH + MATRIX + "[[2.0, 0.5], [0.5, 1.0]]", "correlation.matrix"),
        (BOTH + MATRIX + "[[1.0, 0.5]]", "matrix must have 2 rows"),
        (
            MATRIX + "[[1.0, 0.5], [0.5, 1.0]]",
            "correlation.parameters contains bending_rigidity, but [material] does not; add",
        ),
        (
            "[material]\nbending_rigidity = 0.1\nfriction_table = 0.1\nareal_density = 0.1\n[correlation]\n"
            "parameters = ['bending_rigidity', 'friction_table', 'areal_density']\n"
            "matrix = [[1.0, 0.9, -0.9], [0.9, 1.0, 0.9], [-0.9, 0.9, 1.0]]",
            "eigenvalues of at least 0",
        ),
    ],
)
def test_a_wrong_field_is_one_line_that_names_it(tmp_path: Path, text: str, field: str) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(text)
    said = refusal(load_disturbances, str(file))
    assert field in said and "mine.toml" in said


def test_what_is_neither_default_nor_none_nor_a_file_is_refused() -> None:
    with pytest.raises(InputError, match=r"default, none or a \.toml file"):
        load_disturbances("some")
    assert load_disturbances("none") is None and load_disturbances("default") == default_disturbances()


def test_every_default_has_a_source() -> None:
    file = tomllib.loads((OWN / "default.toml").read_text())
    given = {f"{table}.{name}" for table, values in file.items() if table != "source" for name in values}
    assert given == set(file["source"])


def test_every_number_of_a_material_may_be_off_and_everything_has_words() -> None:
    assert set(FIELDS) == set(Material.model_fields) - {"blender"}
    assert all(channel.title and channel.unit in SHOWN for channel in CHANNELS)


def test_scenarios_are_the_same_again_and_do_not_depend_on_how_many_there_are() -> None:
    few, many = (sample_scenarios(default_disturbances(), count, 7, Stream.MARGINS) for count in (4, 9))
    assert few == many[:4]
    assert sample_scenarios(default_disturbances(), 4, 8, Stream.MARGINS) != few
    assert sample_scenarios(default_disturbances(), 4, 7, Stream.JUDGING) != few


def test_what_one_scenario_draws_of_one_thing_does_not_depend_on_the_others() -> None:
    alone = sample_scenarios(Disturbances.model_validate({"table": {"height": 0.002}}), 5, 0, Stream.MARGINS)
    among = sample_scenarios(default_disturbances(), 5, 0, Stream.MARGINS)
    assert [scenario["table.height"] for scenario in alone] == [scenario["table.height"] for scenario in among]


def test_deviations_and_correlations_are_those_of_the_file() -> None:
    plain = {
        **default_disturbances().model_dump(exclude_defaults=True),
        "correlation": {
            "parameters": ["bending_rigidity", "friction_table"],
            "matrix": [[1.0, -0.8], [-0.8, 1.0]],
        },
    }
    disturbances = Disturbances.model_validate(plain)
    scenarios = sample_scenarios(disturbances, 3000, 1, Stream.MARGINS)
    for name, deviation in deviations(disturbances).items():
        values = np.array([scenario[name] for scenario in scenarios])
        assert values.std() == pytest.approx(deviation, rel=0.06)
        assert abs(values.mean()) < 0.08 * deviation
    both = np.array([[w["material.bending_rigidity"], w["material.friction_table"]] for w in scenarios])
    assert np.corrcoef(both.T)[0, 1] == pytest.approx(-0.8, abs=0.03)


def test_a_calibrated_material_brings_its_own(tmp_path: Path) -> None:
    file = tmp_path / "cloth.toml"
    file.write_text(
        "[material]\nareal_density = 0.2\nstretch_stiffness = 100.0\nbending_rigidity = 2e-5\n"
        "[uncertainty]\nbending_rigidity = 1e-6\nareal_density = 0.004\n"
        "[correlation]\nparameters = ['areal_density', 'bending_rigidity']\nmatrix = [[1.0, 0.5], [0.5, 1.0]]\n"
    )
    material = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=2e-5)
    own = with_calibrated(default_disturbances(), file, material)
    assert own.material["bending_rigidity"] == pytest.approx(0.05)
    assert own.material["areal_density"] == pytest.approx(0.02)
    assert own.material["friction_table"] == default_disturbances().material["friction_table"]
    assert own.correlation is not None
    file.write_text(file.read_text().replace("1e-6", "-1e-6"))
    with pytest.raises(InputError, match=r"uncertainty\.bending_rigidity"):
        with_calibrated(default_disturbances(), file, material)


def test_where_nothing_is_off_the_scene_is_the_usual_one(task: Task, low: Manipulation) -> None:
    usual = scene_of(task.fold, low)
    assert disturbed_scene(task.fold, low, NOMINAL).model_dump_json() == usual.model_dump_json()
    tiny = Scenario({channel.name: 1e-300 for channel in CHANNELS})
    near = disturbed_scene(task.fold, low, tiny)
    assert not tiny.is_nominal and near.duration == usual.duration and near.material == usual.material
    times = np.arange(near.frames) / near.frame_rate
    for one, other in zip(near.grippers, usual.grippers, strict=True):
        assert one.vertices == other.vertices and one.opens == other.opens
        assert one.path(times) == pytest.approx(other.path(times), abs=1e-12)


def ends(scene: Scene) -> np.ndarray:
    """Where the hands lay the cloth down [m], shape (h, 3)."""
    return np.array([gripper.displacements[-1] for gripper in scene.grippers])


@pytest.mark.parametrize(
    ("name", "value", "moved"),
    [
        ("hands.offset.along", 0.005, [[0.005, 0, 0]] * 2),
        ("hands.offset.across", 0.005, [[0, 0.005, 0]] * 2),
        ("hands.offset.up", 0.003, [[0, 0, 0.003]] * 2),
        ("hands.difference.along", 0.004, [[0.002, 0, 0], [-0.002, 0, 0]]),
        ("hands.difference.up", 0.004, [[0, 0, 0.002], [0, 0, -0.002]]),
        ("table.height", -0.002, [[0, 0, 0.002]] * 2),
        ("grasp.along.left", 0.005, [[0, -0.005, 0], [0, 0, 0]]),
        ("grasp.into.right", 0.005, [[0, 0, 0], [0.005, 0, 0]]),
        ("cloth.place.along", 0.004, [[-0.008, 0, 0]] * 2),
        ("cloth.place.across", 0.004, [[0, 0, 0]] * 2),
    ],
)
def test_each_disturbance_moves_the_release_as_it_should(
    task: Task, low: Manipulation, name: str, value: float, moved: list[list[float]]
) -> None:
    usual = ends(scene_of(task.fold, low))
    assert ends(disturbed_scene(task.fold, low, Scenario({name: value}))) - usual == pytest.approx(
        np.array(moved), abs=1e-9
    )


def test_hands_turn_as_a_pair_about_the_middle_between_them(task: Task, low: Manipulation) -> None:
    shift = ends(disturbed_scene(task.fold, low, Scenario({"hands.yaw": 0.1}))) - ends(scene_of(task.fold, low))
    apart = low.positions[0][1] - low.positions[1][1]
    assert shift[:, 0] == pytest.approx(np.array([-1, 1]) * np.sin(0.1) * apart / 2)
    assert shift.sum(axis=0) == pytest.approx(0.0)


def test_hands_follow_their_path_faster_and_open_one_after_the_other(task: Task, low: Manipulation) -> None:
    usual = scene_of(task.fold, low)
    fast = disturbed_scene(task.fold, low, Scenario({"hands.speed": np.log(2.0)}))
    seconds = usual.grippers[0].times[-1] - usual.grippers[0].times[0]
    assert fast.grippers[0].times[-1] - fast.grippers[0].times[0] == pytest.approx(seconds / 2)
    assert fast.duration == pytest.approx(usual.duration - seconds / 2)
    for delay, late in ((0.1, 0), (-0.1, 1)):
        scene = disturbed_scene(task.fold, low, Scenario({"hands.opening_delay": delay}))
        opened = [gripper.opens for gripper in scene.grippers]
        assert opened[late] - opened[1 - late] == pytest.approx(0.1)  # type: ignore[operator]
        assert scene.duration == pytest.approx(usual.duration + 0.1)


def test_a_hand_that_is_too_low_meets_the_table(task: Task, low: Manipulation) -> None:
    scene = disturbed_scene(task.fold, low, Scenario({"hands.offset.up": -0.02}))
    half = 0.5 * task.fold.garment.material.thickness
    for gripper in scene.grippers:
        heights = scene.cloth.vertices[gripper.vertices, 2].min() + gripper.displacements[:, 2]
        assert heights.min() == pytest.approx(half)


def test_a_grasp_a_cell_farther_along_holds_the_next_vertex(task: Task, low: Manipulation) -> None:
    scene = disturbed_scene(task.fold, low, Scenario({"grasp.along.left": -0.04}))
    held = scene.cloth.vertices[scene.grippers[0].vertices, 1].mean()
    usual = scene_of(task.fold, low)
    assert held < usual.cloth.vertices[usual.grippers[0].vertices, 1].mean() - 0.02


def test_fingers_that_close_beside_the_cloth_hold_nothing(task: Task, low: Manipulation) -> None:
    scene = disturbed_scene(task.fold, low, Scenario({"grasp.into.left": -0.012}))
    assert len(scene.grippers) == 1


def judged(task: Task, scenario: Scenario) -> Outcome:
    return simulate_outcome(task, LOW, scenario)


@pytest.mark.parametrize(
    ("values", "says"),
    [
        (
            {"hands.offset.up": -0.018},
            "the left hand meets the table: the hand is 18.0 mm too low, but its fingers yield by only 6.7 mm",
        ),
        ({"table.height": 0.008}, "the left hand meets the table"),
        ({"hands.difference.up": 0.02}, "the right hand meets the table"),
        ({"grasp.along.left": 0.018}, "the left hand grasps beside the cloth"),
        ({"grasp.along.right": -0.018}, "the right hand grasps beside the cloth"),
        ({"grasp.into.right": -0.009}, "the right hand grasps beside the cloth"),
        ({"cloth.place.across": -0.018}, "the left hand grasps beside the cloth"),
        ({"hands.offset.up": -0.006}, None),
        ({"hands.offset.up": 0.018}, None),
        ({"grasp.along.left": 0.008, "grasp.into.left": -0.003}, None),
        ({"grasp.into.left": 0.018}, None),
    ],
)
def test_a_hand_that_cannot_do_its_part_has_failed_whatever_the_cloth_does(
    task: Task, low: Manipulation, values: dict[str, float], says: str | None
) -> None:
    found = hand_failure(disturbed_hands(task.fold, low, Scenario(values)))
    assert (found is None) if says is None else (found or "").startswith(says)
    if says is not None:
        verdict = judged(task, Scenario(values))
        assert not Limits().hold(verdict) and verdict.error == found


def test_how_far_a_hand_yields_is_stated_with_its_fingers(task: Task, low: Manipulation) -> None:
    soft = replace(task.fold, fingers=Fingers(compliance=0.02))
    assert hand_failure(disturbed_hands(soft, low, Scenario({"hands.offset.up": -0.018}))) is None


def test_the_part_that_moves_is_judged_as_well_as_the_whole() -> None:
    hidden = Outcome(0.011, 0.9, None, 0.022)
    assert Limits().hold(Outcome(0.011, 0.9)) and not Limits().hold(hidden)
    assert Limits().slack(hidden) == pytest.approx(1.0 - 0.022 / 0.0125)


def test_the_material_is_off_within_what_a_material_may_be(task: Task, low: Manipulation) -> None:
    usual = task.fold.garment.material
    values = {f"material.{name}": 0.1 for name in FIELDS} | {"material.friction_table": 9.0}
    scene = disturbed_scene(task.fold, low, Scenario(values))
    assert scene.material.bending_rigidity == pytest.approx(usual.bending_rigidity * np.exp(0.1))
    assert scene.material.friction_table == 10.0
    assert scene.material.compression == 1.0
    thicker = scene.material.thickness / usual.thickness
    assert scene.cloth.vertices[:, 2] == pytest.approx(task.fold.start[:, 2] * thicker)
    assert Material.model_validate(scene.material.model_dump()) == scene.material


def test_hands_that_would_grasp_one_place_fail_and_end_nothing(task: Task) -> None:
    scenario = Scenario({"grasp.along.left": -0.1, "grasp.along.right": 0.1})
    found = Outcome.of(Nominal(task).simulate(LOW, scenario), task.fold)
    assert found.error == "both hands would grasp the same place" and not Limits().hold(found)


def test_a_rate_counts_failures_by_cause_and_has_the_interval_of_clopper_and_pearson(task: Task) -> None:
    good, far = Outcome(0.005, 0.9), Outcome(0.02, 0.9, aligned_distance=0.001)
    failed, apart = Outcome(None, None, "tore"), Outcome(0.005, 0.7, aligned_distance=0.02)
    found = Success.of(task.fold, [good, far, failed, apart, failed], Limits())
    assert (found.simulations, found.succeeded, found.rate) == (5, 1, 0.2)
    assert found.causes == {UNSIMULATED: 2, BESIDE_TARGET: 1, CRUSHED: 1}
    low, high = Success.of(task.fold, [good] * 196 + [far] * 4, Limits()).interval
    assert (low, high) == pytest.approx((0.9496, 0.9945), abs=1e-4)


@pytest.mark.parametrize(
    ("field", "value"), [("shear_stiffness", 30.0), ("bending_rigidity_initial", 5e-5), ("bending_rigidity_bias", 2e-5)]
)
def test_no_scenario_has_a_material_that_cannot_be(task: Task, low: Manipulation, field: str, value: float) -> None:
    usual = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=4e-5, friction_table=0.5)
    woven = Material.model_validate({**usual.model_dump(), field: value})
    garment = replace(task.fold.garment, material=woven)
    scenario = Scenario({f"material.{field}": -0.9, "material.compression": -0.2, "material.bending_rigidity": 0.1})
    found = disturbed_scene(replace(task.fold, garment=garment), low, scenario).material
    assert Material.model_validate(found.model_dump()) == found


@pytest.mark.parametrize(
    ("uncertainty", "says"),
    [
        ("shear_stiffness = 1.0", "the material has no shear_stiffness"),
        ("bending_rigidity = '1'", "must be a number"),
        ("bending_rigidity = 1" + 400 * "0", "must be a number"),
    ],
)
def test_an_uncertainty_of_nothing_is_refused(tmp_path: Path, uncertainty: str, says: str) -> None:
    file = tmp_path / "cloth.toml"
    file.write_text(f"[uncertainty]\n{uncertainty}\n")
    material = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=2e-5)
    with pytest.raises(InputError, match=says):
        with_calibrated(default_disturbances(), file, material)


def test_what_a_calibration_leaves_nearly_unknown_may_still_be_disturbed(tmp_path: Path) -> None:
    file = tmp_path / "cloth.toml"
    file.write_text("[uncertainty]\nair_added_mass = 0.026\n")
    material = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=2e-5, air_added_mass=0.01)
    assert with_calibrated(default_disturbances(), file, material).material["air_added_mass"] == 2.0


def test_what_another_version_of_the_simulator_said_is_not_asked(task: Task, monkeypatch: pytest.MonkeyPatch) -> None:
    here = Subject(task, LOW).digest
    assert Subject(task, LOW).digest == here
    monkeypatch.setattr("tatamu.evaluation.draws.source_digest", lambda: "another")
    assert Subject(task, LOW).digest != here


def test_outcomes_are_kept_and_what_is_none_is_passed_over(task: Task, tmp_path: Path) -> None:
    file, subject = tmp_path / "kept" / "simulated.jsonl", Subject(task, LOW)
    scenario = Scenario({"hands.offset.up": 0.001})
    with ThreadPoolExecutor(1) as workers:
        found = Draws(subject, workers, file).outcomes([scenario])
        with file.open("a") as kept:
            kept.write('{"key": "b", "mean_vertex_distance": "x", "mask_iou": 0.9, "error": null}\n{"key": "c"')
        seen: list[int] = []
        again = Draws(subject, workers, file, lambda done, total: seen.append(done))
        assert again.outcomes([scenario]) == found and not seen
        (tmp_path / "a-file").touch()
        with pytest.raises(InputError, match="cannot be written"):
            Draws(subject, workers, tmp_path / "a-file" / "simulated.jsonl")


def test_a_low_fold_suffers_where_hands_are_low_and_a_high_one_does_not(task: Task) -> None:
    high = {**LOW, "z1": 0.2, "x2": 0.4, "z2": 0.2}
    evaluate = Nominal(task)
    below = Scenario({"hands.offset.up": -0.006})
    worse = []
    for parameters in (LOW, high):
        usual, lowered = (evaluate.simulate(parameters, scenario).score for scenario in (NOMINAL, below))
        assert usual is not None and lowered is not None
        worse.append(lowered.mean_vertex_distance - usual.mean_vertex_distance)
    assert worse[0] > 0.010 and abs(worse[1]) < 0.003
