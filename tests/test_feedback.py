"""Measured folds: numbers, posterior, correction, and learning after it; the simulator is a fake."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest
from PIL import Image

import tatamu as tt
from tatamu import InputError
from tatamu.after.feedback import FeedbackFolder, MeasuredFold, feedback_of, from_numbers, read_template, ruler
from tatamu.after.feedback.correction import as_disturbances, shifts_against
from tatamu.after.feedback.emulator import fit
from tatamu.after.feedback.measured import FORM
from tatamu.after.feedback.page import page
from tatamu.after.feedback.photo import read_photo
from tatamu.after.feedback.posterior import WIDER, Fold, posterior
from tatamu.after.feedback.texts import again, posterior_lines
from tatamu.cameras.pose import Pose
from tatamu.evaluation.disturbances import (
    Disturbances,
    Scenario,
    Stream,
    default_disturbances,
    disturbed_scene,
    join,
    load_disturbances,
    mean_scenario,
    sample_scenarios,
    split,
)
from tatamu.evaluation.disturbances.systematic import share
from tatamu.evaluation.outcome import Outcome
from tatamu.folding.manipulation import HandShift
from tatamu.folding.score import MARKS, marks
from tatamu.folding.task import Task, make_task
from tatamu.simulation.rollout import Rollout
from tatamu.study.options import LearnOptions
from tatamu.study.result import Result
from tests.browser import Phone
from tests.commands import refused, tatamu
from tests.refusals import refusal

SLOPES = {
    "hands.offset.along": ("left_along", "right_along"),
    "hands.offset.across": ("left_across", "right_across"),
    "grasp.into.left": ("left_along",),
    "grasp.into.right": ("right_along",),
    "grasp.along.left": ("left_across",),
    "grasp.along.right": ("right_across",),
}
"""The fake simulator: a disturbance moves these marks by as much."""


def ends(scenario: Scenario) -> dict[str, float]:
    """Where a fold ends in the fake simulator [m]."""
    found = dict.fromkeys(MARKS, 0.0)
    for name, moved in SLOPES.items():
        for mark in moved:
            found[mark] += scenario[name]
    found["slip_along"] -= 0.01 * scenario["material.friction_table"]
    return found


def known(task: Any, parameters: Any, scenario: Scenario) -> Outcome:
    """Return the verdict of the fake simulator."""
    found = ends(scenario)
    distance = float(np.sqrt(1e-6 + 0.25 * sum(value**2 for value in found.values())))
    return Outcome(distance, 0.95, marks=found)


@pytest.fixture(scope="module")
def task() -> Task:
    return make_task("towel", spacing=0.04, size=(0.24, 0.5))


@pytest.fixture(autouse=True)
def _fake_simulator(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("tatamu.evaluation.draws.simulate_outcome", known)
    monkeypatch.setattr("tatamu.after.feedback.page.simulated", lambda observed, correction: None)


@pytest.fixture(scope="module")
def made(task: Task, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A learned fold that ends on its target."""
    fold = task.fold
    info = {"simulator": "native", "version": "", "wall_seconds": 0.0, "setup_seconds": 0.0, "steps": 1, "warnings": []}
    rollout = Rollout(np.array([0.0, 4.0]), np.array([fold.start, fold.target]), fold.garment.faces, info)
    folder = tmp_path_factory.mktemp("observed")
    options = LearnOptions(trials=2, disturbances="none", baselines=False, parallel=1)
    with (
        patch("tatamu.evaluation.nominal.simulate", lambda scene, simulator: rollout),
        patch("tatamu.study.result.Result.write_report"),
    ):
        tt.learn(task, options, out=folder)
    return folder


@pytest.fixture
def learned(made: Path, tmp_path: Path) -> Result:
    """A copy of it with a folder of its own."""
    result = Result.load(made)
    result.save(tmp_path / "towel")
    return replace(result, folder=tmp_path / "towel")


def numbers(scenario: Scenario) -> MeasuredFold:
    """Measure a fold of the fake simulator exactly."""
    return from_numbers({name: (value, 0.0015) for name, value in ends(scenario).items()}, source="ruler")


def test_a_set_up_is_inferred_and_corrected(learned: Result) -> None:
    hidden = Scenario({"hands.offset.along": 0.012, "hands.offset.across": -0.006})
    found = tt.observe(learned, measured=numbers(hidden))
    mean = dict(zip(found.posterior.names, found.posterior.mean, strict=True))
    assert 0.006 < mean["hands.offset.along"] < 0.013 and -0.007 < mean["hands.offset.across"] < -0.003
    spread = {name: after / before for name, before, after in found.posterior.deviations}
    assert spread["hands.offset.along"] < 0.6 * spread["hands.difference.up"]
    pairs = found.posterior.alike(0.1)
    assert any({"hands.offset.along", "grasp.into.left"} & {pair.one, pair.other} for pair in pairs)
    undetermined = set(found.posterior.undetermined())
    assert {"hands.difference.up", "material.bending_rigidity"} <= undetermined
    assert "hands.offset.along" not in undetermined
    correction = found.correction
    assert correction.after.distance < 0.7 * correction.before.distance
    assert correction.before.within < 0.95 < 0.99 < correction.after.within <= 1.0
    for shift in correction.shifts:
        assert shift.release[0] == pytest.approx(-mean["hands.offset.along"], abs=0.003) and shift.release[1] > 0.002


def test_the_posterior_is_that_of_normal_variables(learned: Result) -> None:
    """With one number and one disturbance, the mean and the variance follow from two variances."""
    emulator = replace(feedback_of(learned, None).emulator, names=("hands.offset.along",), centre=np.zeros(1))
    slopes = np.zeros((len(MARKS), 1))
    slopes[0] = 1.0
    emulator = replace(emulator, base=np.zeros(len(MARKS)), slopes=slopes, residual=0.0 * emulator.residual)
    source = Disturbances.model_validate({"hands": {"offset": [0.005, 0.0, 0.0]}})
    fold = Fold(from_numbers({"left_along": (0.004, 0.001)}, source="ruler"), emulator, np.zeros(1))
    found = posterior(source, [fold, fold])
    same, new = 0.9 * 0.005**2, 0.1 * 0.005**2 + 0.001**2
    gain = WIDER * same / (WIDER * same + 0.5 * new)
    assert found.mean == pytest.approx([0.004 * gain])
    assert found.covariance[0, 0] == pytest.approx((1.0 - gain) ** 2 * same + gain**2 * 0.5 * new)


def test_two_folds_tell_more_than_one_and_the_corrected_one_counts_as_corrected(learned: Result) -> None:
    hidden = Scenario({"hands.offset.along": 0.012})
    once = tt.observe(learned, measured=numbers(hidden))
    corrected = tt.correct(once, out=FeedbackFolder.of(learned.folder or Path()).corrected(1))
    change = Scenario(as_disturbances(corrected.task.shift, ()))
    left = Scenario({name: hidden[name] + change[name] for name in (*SLOPES, "material.friction_table")})
    twice = tt.observe(corrected, measured=numbers(left))
    assert len(twice.folds) == 2 and twice.posterior.used == 2
    place = twice.posterior.names.index("hands.offset.along")
    assert twice.posterior.covariance[place, place] < once.posterior.covariance[place, place]
    assert abs(twice.posterior.mean[place] - 0.012) < abs(once.posterior.mean[place] - 0.012) + 0.0005
    again = tt.observe(learned.folder or "")
    assert np.array_equal(again.posterior.mean, twice.posterior.mean), "the same files give the same posterior"


def test_a_fold_beyond_all_scenarios_corrects_nothing(learned: Result) -> None:
    found = tt.observe(learned, left=(0.157, 0.0), right=(0.150, 0.0))
    assert found.implausible == [1] and found.posterior.used == 0 and found.correction.is_none
    assert np.allclose(found.posterior.mean, 0.0)


def test_a_failed_fold_and_a_turned_in_corner_can_be_given(learned: Result) -> None:
    failed = tt.observe(replace(learned, folder=None), failed=True)
    assert len(failed.folds) == 1 and failed.posterior.used == 0 and failed.correction.is_none
    turned = tt.observe(replace(learned, folder=None), right=(0.010, 0.0), turned_in=["left"])
    assert [number.name for number in turned.folds[0].measured.measured] == ["right_along", "right_across"]
    with pytest.raises(InputError, match="must not contain left, because"):
        ruler({"left": (0.0, 0.0)}, 0.5, turned_in=["left"])


def test_hands_are_raised_and_never_lowered(learned: Result) -> None:
    """The fake cloth slips with the height of the hands."""
    for slip, raises in ((0.006, True), (-0.006, False)):
        with patch.dict(SLOPES, {"hands.offset.up": ("slip_along",)}):
            low = Scenario({"hands.offset.up": -slip, "hands.offset.along": 0.01})
            found = tt.observe(replace(learned, folder=None), measured=numbers(low))
        heights = [shift.height for shift in found.correction.shifts]
        assert len(heights) == 2 and all(height > 0.001 if raises else height == 0.0 for height in heights), heights


def test_a_sentence_says_how_much_is_expected_again(learned: Result) -> None:
    found = tt.observe(replace(learned, folder=None), left=(0.012, -0.003), right=(0.008, 0.004))
    text = again(found)
    assert text is not None and "of +10.0 mm along" in text and "of +0.5 mm across" in text
    expected = float(text.split(" mm of +10.0")[0].split()[-1])
    assert 4.0 < expected < 10.0
    lines = list(posterior_lines(found))
    known_names = [line.split(":")[0] for line in lines if "σ" in line]
    missing = next(line for line in lines if line.startswith("not determined"))
    assert known_names and not any(name in missing for name in known_names), "what is not determined is not listed"


def test_files_are_those_of_the_contract(learned: Result, tmp_path: Path) -> None:
    observed = tt.observe(learned, left=(0.012, -0.003), right=(0.008, 0.004))
    plain = json.loads((tmp_path / "towel" / "observed" / "1.json").read_text())
    assert plain["version"] == 1 and plain["held"] is True and plain["source"] == "ruler"
    assert plain["measured"][0] == {"name": "left_along", "value": 0.012, "deviation": 0.0015}
    read = load_disturbances(str(tmp_path / "towel" / "posterior.toml"))
    assert read is not None and read == observed.posterior.disturbances
    assert set(read.mean) <= set(observed.posterior.names) and "hands.offset.along" in read.systematic
    back = split(read)
    assert np.allclose(back.mean, observed.posterior.mean, atol=1e-6)
    assert np.allclose(back.systematic, observed.posterior.covariance, atol=1e-6)
    draws = (tmp_path / "towel" / "margins" / "simulated.jsonl").read_text().splitlines()
    tt.observe(learned, left=(0.010, -0.003))
    assert (tmp_path / "towel" / "margins" / "simulated.jsonl").read_text().splitlines() == draws, "all were kept"
    assert len(FeedbackFolder(tmp_path / "towel").files()) == 2


def test_learning_after_takes_posterior_correction_and_fold(learned: Result, tmp_path: Path) -> None:
    hidden = Scenario({"hands.offset.along": 0.012})
    observed = tt.observe(learned, measured=numbers(hidden))
    with patch("tatamu.api.learn_study") as study:
        study.side_effect = KeyboardInterrupt
        with pytest.raises(KeyboardInterrupt):
            tt.learn(learned.task, LearnOptions(trials=3), after=[tmp_path / "towel"])
    (task, options), first = study.call_args.args, study.call_args.kwargs["first"]
    assert options.disturbances == observed.posterior.disturbances and first == [learned.best.parameters]
    assert task.shift[0].release[0] == pytest.approx(
        -mean_scenario(options.disturbances)["hands.offset.along"], abs=5e-4
    )
    with pytest.raises(InputError, match="disturbances: must be left out"):
        tt.learn(learned.task, LearnOptions(disturbances="default"), after=[learned])
    with pytest.raises(InputError, match="observe"):
        tt.learn(learned.task, after=[replace(learned, folder=tmp_path)])


def test_a_shift_takes_the_errors_of_hands_away(task: Task) -> None:
    scenario = Scenario(
        {"hands.offset.along": 0.008, "hands.offset.up": -0.002, "hands.difference.across": 0.004, "hands.yaw": 0.01}
    )
    parameters = task.space.middle()
    corrected = replace(task, shift=shifts_against(task.fold, task.manipulation(parameters), scenario))
    wanted = disturbed_scene(task.fold, task.manipulation(parameters), Scenario({}))
    found = disturbed_scene(task.fold, corrected.manipulation(parameters), scenario)
    wrong = disturbed_scene(task.fold, task.manipulation(parameters), scenario)
    for a, b, c in zip(wanted.grippers, found.grippers, wrong.grippers, strict=True):
        assert np.abs(a.displacements[-1] - b.displacements[-1]).max() < 2e-5
        assert np.abs(a.displacements[-1] - c.displacements[-1]).max() > 5e-3
    grasp = replace(task, shift=(HandShift(grasp=[0.0, 0.004]), HandShift()))
    taken = disturbed_scene(task.fold, grasp.manipulation(parameters), Scenario({"grasp.along.left": -0.004}))
    assert np.abs(taken.grippers[0].displacements[-1] - wanted.grippers[0].displacements[-1]).max() < 2e-5
    described = grasp.manipulation(parameters).describe()
    assert described.arms[0].grasp.position[1] == pytest.approx(task.manipulation(parameters).positions[0][1] + 0.004)


def test_marks_are_along_the_fold_and_across_it(task: Task) -> None:
    fold = task.fold
    moved = fold.target.copy()
    moved[fold.left[0], :2] += 0.012 * fold.normal - 0.003 * fold.crease.along
    found = marks(fold, moved)
    assert found["left_along"] == pytest.approx(0.012) and found["left_across"] == pytest.approx(-0.003)
    assert found["right_along"] == found["slip_along"] == 0.0


def test_systematic_and_random_parts_add_up_and_are_read_again() -> None:
    disturbances = default_disturbances()
    parts = split(disturbances)
    assert np.allclose(parts.deviations[:3], [0.005, 0.005, 0.003])
    assert share(disturbances, "hands.offset.up") == 0.9 and share(disturbances, "material.thickness") == 1.0
    own = disturbances.model_copy(update={"systematic": {"hands": 0.5, "hands.offset": 0.1}})
    assert share(own, "hands.offset.up") == 0.1 and share(own, "hands.yaw") == 0.5 and share(own, "table.height") == 1.0
    matrix = np.eye(len(parts.names))
    matrix[0, 9] = matrix[9, 0] = 0.3
    scale = np.sqrt(np.diag(parts.systematic))
    known_parts = replace(parts, mean=0.3 * scale, systematic=matrix * np.outer(scale, scale))
    read = split(join(known_parts, disturbances))
    used = [parts.names.index(name) for name in read.names]
    assert np.allclose(read.systematic, known_parts.systematic[np.ix_(used, used)], atol=1e-9)
    assert np.allclose(read.random, known_parts.random[used], atol=1e-9)


def test_means_move_scenarios_and_nothing_else() -> None:
    still = Disturbances.model_validate({"hands": {"offset": [0.005, 0.0, 0.0]}})
    moved = Disturbances.model_validate(
        {**still.describe(), "mean": {"hands": {"offset": {"along": 0.02}}, "table.height": 0.001}}
    )
    for a, b in zip(
        sample_scenarios(still, 5, 3, Stream.MARGINS), sample_scenarios(moved, 5, 3, Stream.MARGINS), strict=True
    ):
        assert b["hands.offset.along"] == pytest.approx(a["hands.offset.along"] + 0.02) and b["table.height"] == 0.001
    assert sample_scenarios(still, 1, 0, Stream.MARGINS)[0].values == {"hands.offset.along": -0.002999252499722477}


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("left = [1.0]", "left"),
        ("left = [1.0, 'a']", "left.1"),
        ("left = [5000.0, 0.0]", "left: must be two numbers from -500 to 500 mm"),
        ("left = [1.0, 2.0]\nturned_in = ['left']", "must not contain left, because"),
        ("middle = [1.0, 2.0]", "middle"),
        ("failed = false", "at least one measured number is needed, unless the fold failed"),
        ("left = [1.0, 2.0]\ndeviation = 0.0", "deviation"),
        ("failed = 1", "failed"),
    ],
)
def test_forms_that_are_wrong_are_refused(tmp_path: Path, text: str, field: str) -> None:
    path = tmp_path / "form.toml"
    path.write_text(text)
    said = refusal(read_template, path, 0.5)
    assert re.search(field, said) and str(path) in said


def test_the_empty_form_can_be_read(tmp_path: Path) -> None:
    path = tmp_path / "form.toml"
    path.write_text(FORM)
    assert len(read_template(path, 0.5).measured) == 6


def test_the_emulator_ignores_scenarios_that_end_unlike_others(learned: Result) -> None:
    scenarios = sample_scenarios(default_disturbances(), 100, 5, Stream.MARGINS)
    generator = np.random.default_rng(0)

    def end(scenario: Scenario, index: int) -> Outcome:
        lost = 0.2 * generator.standard_normal() if index % 20 == 0 else 0.0
        noise = {name: value + 1e-3 * generator.standard_normal() for name, value in ends(scenario).items()}
        return Outcome(0.01, 0.9, marks={**noise, "left_along": noise["left_along"] + lost})

    parts = split(default_disturbances())
    fitted = fit(parts, [(scenario, end(scenario, index)) for index, scenario in enumerate(scenarios)])
    place = parts.names.index("hands.offset.along")
    assert fitted.slopes[0, place] == pytest.approx(1.0, abs=0.15) and fitted.residual[0, 0] < 0.004**2


def test_a_command_that_is_killed_counts_a_fold_once(learned: Result) -> None:
    """Killed before any write, and repeated: the posterior is that of one fold."""
    folder = FeedbackFolder.of(learned.folder or Path())
    values = {"left": (0.012, 0.0), "right": (0.012, 0.0)}
    wanted = tt.observe(replace(learned, folder=None), **values)  # type: ignore[arg-type]
    writes = ("feedback.folder.write_text", "feedback.page.write_text", "feedback.observe.write_json")
    for name in writes:
        with patch(f"tatamu.after.{name}", side_effect=KeyboardInterrupt), pytest.raises(KeyboardInterrupt):
            tt.observe(learned, **values)  # type: ignore[arg-type]
        assert not folder.files(), name
    found = tt.observe(learned, **values)  # type: ignore[arg-type]
    assert len(folder.files()) == 1 and np.array_equal(found.posterior.mean, wanted.posterior.mean)


@pytest.mark.parametrize("name", ["write_record", "write_best"])
def test_a_correction_that_is_killed_leaves_no_mixture(learned: Result, name: str) -> None:
    folder = FeedbackFolder.of(learned.folder or Path())
    path = folder.corrected(1)
    found = tt.observe(learned, left=(0.012, 0.0), right=(0.012, 0.0))
    tt.correct(found, out=path)
    whole = (path / "manipulation.json").read_text()
    with patch(f"tatamu.study.folder.ResultFolder.{name}", side_effect=KeyboardInterrupt):
        with pytest.raises(KeyboardInterrupt):
            tt.correct(found, out=path)
    with pytest.raises(InputError, match="cannot be read"):
        Result.load(path)
    assert tatamu("correct", str(folder.path)).returncode == 0
    assert (path / "manipulation.json").read_text() == whole
    with pytest.raises(InputError, match="but contains a learned fold; give another folder"):
        tt.correct(found, out=folder.path)


def test_correct_says_that_nothing_is_written(learned: Result) -> None:
    folder = str(learned.folder)
    assert f"run `tatamu observe {folder} --left A,B --right A,B` first" in refused("correct", folder)
    tt.observe(learned, left=(0.0, 0.0), right=(0.0, 0.0))
    done = tatamu("correct", folder)
    assert done.returncode == 0 and done.stdout.endswith("written: nothing\n"), done.stdout
    assert not FeedbackFolder(Path(folder)).variants()[1:]
    tt.observe(learned, left=(0.012, 0.0), right=(0.012, 0.0))
    done = tatamu("correct", folder)
    plain = json.loads((Path(folder) / "corrected-2" / "correction.json").read_text())
    assert plain["observed"] == 2 and plain["hands"][0]["release"][0] < -0.003, done.stdout


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (
            {"left": (12, -3)},
            r"left: must be two numbers from -0\.5 to 0\.5 m \(the size of the cloth\), given 12, -3; the first is "
            "along the fold, the second across it",
        ),
        ({"right": (0.6, 0.0)}, "right: must be .* given 0.6, 0.0"),
        ({"slip": (0.01,)}, "slip: must be two numbers"),
        ({"slip": 0.01}, "slip: must be two numbers from .*, given 0.01"),
        ({"left": (0.01, float("nan"))}, "left: must be two numbers"),
        ({"left": (0.01, 0.0), "deviation": 0.0}, "deviation: must be above 0 and at most 2 m, given 0.0"),
    ],
)
def test_python_names_argument_and_unit(learned: Result, given: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        tt.observe(learned, **given)
    assert not FeedbackFolder.of(learned.folder or Path()).files()


def test_the_page_shows_the_photograph_of_a_fold(learned: Result, phone: Phone) -> None:
    ours = FeedbackFolder.of(learned.folder or Path())
    fold = from_numbers({"left_along": (0.012, 0.002)}, source="sha256:0")
    found = tt.observe(learned, measured=fold)
    Image.new("RGB", (8, 8)).save(ours.files()[0].with_suffix(".jpg"))
    assert page(found).count("data:image/jpeg") == 1
    phone(page(found))


def test_a_photograph_gives_the_numbers_of_a_ruler(learned: Result, tmp_path: Path) -> None:
    photo = tmp_path / "after.jpg"
    photo.write_bytes(b"pixels")
    values = {"left_along": (0.012, 0.002), "right_along": (0.008, 0.003), "slip_across": (0.0, 0.001)}
    with patch("tatamu.after.feedback.photo.view_fold") as view:
        view.return_value.values = values
        seen, _ = read_photo(learned, photo, "a4", frame=Pose(0.0, 0.0, 0.0))
        turned, _ = read_photo(learned, photo, "a4", frame=Pose(0.0, 0.0, 0.0), turned_in=["left"])
        with pytest.raises(InputError, match="before, frame"):
            read_photo(learned, photo, "a4")
    assert {each.name: (each.value, each.deviation) for each in seen.measured} == values
    assert seen.source.startswith("sha256:") and [each.name for each in turned.measured] == [
        "right_along",
        "slip_across",
    ]
    assert tt.observe(replace(learned, folder=None), measured=seen).posterior.used == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--left", "12;3"], "--left: must be two numbers in millimetres, such as 12,-3, given '12;3'"),
        (["--left", "1200,0"], "--left: must be two numbers from -500 to 500 mm"),
        (["--left", "12,0", "--deviation", "-1"], "--deviation: must be above 0 and at most 2000 mm, given -1.0"),
        (["--turned-in", "top"], "--turned-in: must be left, right or both, given 'top'"),
        (["--board", "b.toml"], "--photo: must be given, because --board"),
        (["--photo", "a.jpg", "--left", "1,2"], "--photo: must be given without other numbers"),
        (["--template", "f.toml", "--failed"], "--template: must be given without measured numbers"),
        (["--photo", "a.jpg"], "--board, --sheet: exactly one is needed, given neither"),
        (["--from", "nothing.toml"], "nothing.toml: cannot be read"),
        ([], "contains no measured fold; run `tatamu observe "),
    ],
)
def test_the_command_line_names_what_is_wrong(learned: Result, words: list[str], message: str) -> None:
    assert message in refused("observe", str(learned.folder), *words)


def test_the_commands_of_the_guide_run_as_written(
    learned: Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Commands that need a photograph or a robot are left out; what they read is there."""
    (tmp_path / "runs").mkdir()
    (learned.folder or Path()).rename(tmp_path / "runs" / "towel")
    monkeypatch.chdir(tmp_path)
    page = (Path(__file__).parents[1] / "docs" / "guide" / "observation.md").read_text()
    lines = [line.split() for line in page.splitlines() if line.startswith("    tatamu ")]
    for _, command, *words in lines:
        if command in ("observe", "correct") and "--photo" not in words:
            done = tatamu(command, *words)
            assert done.returncode == 0, (words, done.stderr)
        elif command == "plan":
            assert Result.load(words[0]).task.shift, words
    assert sorted(path.name for path in (tmp_path / "runs" / "towel").glob("corrected-*")) == [
        "corrected-1",
        "corrected-2",
    ]


def test_learn_after_takes_the_options_of_the_fold(learned: Result, tmp_path: Path) -> None:
    tt.observe(learned, left=(0.008, 0.0), right=(0.008, 0.0))
    with patch("tatamu.api.learn") as learn:
        learn.side_effect = InputError("seen")
        for words, trials in (([], 20), (["--trials", "50"], 50)):
            done = tatamu("learn", "--after", str(learned.folder), "--out", str(tmp_path / "next"), *words)
            assert done.stderr.endswith("tatamu: seen\n") and done.returncode == 2
            task, options = learn.call_args.args
            assert options.trials == trials and options.disturbances is None and task.garment.size == (0.24, 0.5)
            assert learn.call_args.kwargs["after"] == [learned.folder]
    assert "GARMENT: must be given, unless --after" in refused("learn", "--out", str(tmp_path / "next"))
