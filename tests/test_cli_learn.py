"""What `tatamu learn` says: at once, while it works, at the end, and when it is interrupted."""

from __future__ import annotations

import io
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from rich.console import Console

from tatamu import InputError, Progress, Task, learn, load
from tatamu.cli import main
from tatamu.cli.learn import conclusion_of, kept, verdict_lines
from tatamu.cli.progress import LearningDisplay, prepare
from tatamu.folding.score import MEASURES
from tatamu.report.conclusion import Conclusion
from tatamu.simulation.native import CAPABILITIES
from tatamu.study.folder import ResultFolder
from tests.commands import refused, tatamu
from tests.fabricated import changed, write_fold
from tests.scenes import scene
from tests.small_studies import learn_plain, plain, timeless, towel

EXAMPLE = Path(__file__).parent.parent / "examples" / "measurements-towel.toml"


def conclusion(folder: Path) -> Conclusion:
    return conclusion_of(load(folder))


def test_something_is_said_before_anything_heavy_is_imported(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setitem(sys.modules, "tatamu.api", None)  # its import then fails
    monkeypatch.setattr("sys.argv", ["tatamu", "learn", "towel", "--out", str(tmp_path / "out")])
    with pytest.raises(ImportError):
        main()
    assert capsys.readouterr().out == "laying out towel\n"


def test_the_end_says_the_verdict_and_the_note_and_exits_with_0(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("tatamu.study.loop.SUCCESS_SIMULATIONS", 6)
    options = ["--size", "0.24x0.5", "--spacing", "0.04", "--sampler", "random", "--no-baselines", "--trials", "2"]
    done = tatamu("learn", "towel", *options, "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    said = done.stdout.splitlines()
    assert said[-1] == f"report: {tmp_path / 'report.html'}"
    verdicts = [line for line in said if line.startswith(("succeeded: ", "failed: "))]
    assert len(verdicts) == 1 and "success below 12.5 mm" in verdicts[0] and "success from 0.80" in verdicts[0]
    best = ResultFolder(tmp_path).record.best_score
    assert f"{1e3 * best.mean_vertex_distance:.1f} mm" in verdicts[0]
    assert any(line.startswith("succeeds in ") and "of 6 simulations" in line for line in said)
    warnings = ResultFolder(tmp_path).rollout.info["warnings"]  # of coarse cells
    assert warnings and [f"warning: {line}" for line in warnings] == [line for line in said if line[:7] == "warning"]


@pytest.mark.parametrize(("size", "succeeded"), [(0.0018, True), (0.0124, True), (0.0126, False), (0.03, False)])
def test_the_verdict_is_that_of_the_thresholds(tmp_path: Path, size: float, succeeded: bool) -> None:
    said = conclusion(write_fold(tmp_path, spacing=0.08, size=size, frames=24))
    assert said.succeeded == succeeded
    assert said.text.startswith("succeeded: " if succeeded else "failed: ")
    assert bool(said.advice) == (not succeeded)


def test_a_fold_whose_outline_misses_fails_however_near_its_vertices_are(folder: Path) -> None:
    best = json.loads((folder / "result.json").read_text())["best"]
    changed(folder / "result.json", lambda value: value["trials"][best].update(mask_iou=0.79))
    assert not conclusion(folder).succeeded


def failed_with_best(folder: Path, number: int) -> list[str]:
    """The advice on a search of 10 trials that failed, of which the best is that one."""

    def change(value: dict[str, Any]) -> None:
        value["trials"] = value["trials"][:10]
        value["best"] = number
        value["baselines"] = []
        for trial in value["trials"]:
            measures = {name: trial.get(name) or 0.0 for name in MEASURES}
            changes = {"objective": 2.0, "mean_vertex_distance": 0.03, "mask_iou": 0.7}
            trial.update({**measures, **changes, "state": "complete", "error": None})
        value["trials"][number]["objective"] = 1.0

    changed(folder / "result.json", change)
    return conclusion(folder).advice


def test_a_search_that_still_got_better_shall_have_more_trials(folder: Path) -> None:
    late = failed_with_best(folder, 9)
    assert "--trials 20" in late[0] and "likely to help" in late[0]


def test_a_search_that_no_longer_got_better_is_told_of_other_folds(folder: Path) -> None:
    early = failed_with_best(folder, 2)
    assert "best trial came early, trial 2 of 10" in early[0] and "tatamu plans" in early[1]


def test_another_trial_or_a_fixed_trajectory_that_succeeds_is_named(folder: Path) -> None:
    baselines = json.loads((folder / "result.json").read_text())["baselines"]
    failed_with_best(folder, 2)
    changed(folder / "result.json", lambda value: value["trials"][5].update(mean_vertex_distance=0.004, mask_iou=0.9))
    changed(folder / "result.json", lambda value: value.update(baselines=baselines))
    advice = conclusion(folder).advice
    assert "trial 5 succeeds (4.0 mm from the target), but the search preferred a shorter path" in advice[0]
    assert "Circular arc" in advice[1]


@pytest.mark.parametrize(
    ("name", "value", "noted"),
    [("z2", 0.001, True), ("z2", 0.02, False), ("x1", 0.799, True), ("g1", 26, True), ("g1", 0, False)],
)
def test_the_best_on_a_bound_is_noted(folder: Path, name: str, value: float, noted: bool) -> None:
    bounds = {"x1": [0.0, 0.8], "z2": [0.0, 0.6], "g1": [0, 26]}
    middle = {"x1": 0.4, "z2": 0.3, "g1": 10, name: value}
    best = json.loads((folder / "result.json").read_text())["best"]
    changed(folder / "result.json", lambda whole: whole["trials"][best]["parameters"].update(middle))
    changed(folder / "result.json", lambda whole: whole.update(bounds=bounds))
    notes = [line for line in verdict_lines(conclusion(folder)) if line.startswith("note: ")]
    assert len(notes) == noted
    assert all("is at a limit of the search" in note and f"({name}): " in note for note in notes)


def test_a_best_curve_that_was_given_is_said_and_its_bounds_are_not_noted(folder: Path) -> None:
    def give(whole: dict[str, Any]) -> None:
        parameters = whole["trials"][whole["best"]]["parameters"]
        parameters["z2"] = 0.0
        whole.update(bounds={"z2": [0.0, 0.6]}, first=[parameters])

    changed(folder / "result.json", give)
    notes = [line for line in verdict_lines(conclusion(folder)) if line.startswith("note: ")]
    best = ResultFolder(folder).record.best
    assert len(notes) == 1 and f"trial {best}, " in notes[0]


def test_what_the_search_found_is_compared_with_the_best_curve_that_it_was_given(folder: Path) -> None:
    best = ResultFolder(folder).record.best
    other = next(t.number for t in ResultFolder(folder).record.trials if t.state == "complete" and t.number != best)

    def give(whole: dict[str, Any]) -> None:
        whole.update(first=[whole["trials"][other]["parameters"]])

    changed(folder / "result.json", give)
    notes = [line for line in verdict_lines(conclusion(folder)) if "was found by the search" in line]
    assert len(notes) == 1 and f"trial {best} was" in notes[0] and f"trial {other}, " in notes[0]


@pytest.fixture(scope="module")
def quarters() -> Task:
    return towel(fold="quarters")


SEARCH: dict[str, Any] = {"sampler": "random", "baselines": False}


def stopping_after(count: int) -> Callable[[Progress], None]:
    """A listener that interrupts after so many trials, counted through all steps."""
    made = iter(range(1000))

    def show(progress: Progress) -> None:
        if progress.stage == "trials" and progress.done and next(made) + 1 == count:
            raise KeyboardInterrupt

    return show


def test_an_interrupted_study_leaves_a_report_and_goes_on(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        learn_plain(towel(), tmp_path / "cut", progress=stopping_after(3), trials=5, **SEARCH)
    assert (tmp_path / "cut" / "report.html").exists()
    assert len(ResultFolder(tmp_path / "cut").record.trials) == 3
    for folder in ("cut", "whole"):
        learn_plain(towel(), tmp_path / folder, trials=5, **SEARCH)
    assert timeless(tmp_path / "cut") == timeless(tmp_path / "whole")


@pytest.mark.parametrize(("trials", "steps"), [(1, 1), (3, 2)])
def test_an_interrupted_plan_leaves_a_report_of_its_finished_steps(
    quarters: Task, tmp_path: Path, trials: int, steps: int
) -> None:
    options = plain(trials=2, **SEARCH)
    with pytest.raises(KeyboardInterrupt):
        learn(quarters, options, out=tmp_path / "cut", progress=stopping_after(trials))
    assert len(ResultFolder(tmp_path / "cut").plan_record.steps) == steps
    title = "in 2 folds" if steps == 2 else "the first 1 of 2 folds"
    assert title in (tmp_path / "cut" / "report.html").read_text()
    for folder in ("cut", "whole"):
        learn(quarters, options, out=tmp_path / folder)
    assert timeless(tmp_path / "cut") == timeless(tmp_path / "whole")


def test_an_interrupted_command_says_how_to_go_on_and_exits_with_130(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("tatamu.api.learn", interrupted)
    write_fold(tmp_path, spacing=0.08, frames=24)
    (tmp_path / "study.db").touch()
    done = tatamu("learn", "towel", "--out", str(tmp_path))
    said = done.stderr
    assert done.returncode == 130 and said == f"tatamu: {kept(tmp_path)}\n"
    assert "run the same command again to resume" in said and str(tmp_path) in said


class Watched:
    """A display of a simulator that compiles so many functions."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, terminal: bool = False) -> None:
        self.text = io.StringIO()
        self.prepared = 0
        simulator = SimpleNamespace(prepare=self.prepare, compilation=lambda: (0, 80), CAPABILITIES=CAPABILITIES)
        monkeypatch.setattr("tatamu.simulation.simulators.named", lambda name: simulator)
        console = Console(file=self.text, force_terminal=terminal, width=200)
        self.display = LearningDisplay(towel(), 10, 3, console)

    def prepare(self) -> None:
        self.prepared += 1

    def show(self) -> str:
        """What is said of a study from its first curve to its page."""
        first = Progress(0, 10, 0.9, 0.0006, stage="first")
        trials = [Progress(done, 10, 1.0 if done else None, 0.002 if done else None) for done in range(11)]
        success = [Progress(10, 10, 1.0, 0.002, stage="success", simulated=n, simulations=36) for n in (0, 18, 36)]
        with self.display:
            for now in (first, *trials, *success, Progress(10, 10, 1.0, 0.002, stage="report")):
                self.display.show(now)
        return self.text.getvalue()


@pytest.mark.parametrize("terminal", [False, True])
def test_a_study_says_what_is_known_and_how_far_it_is(monkeypatch: pytest.MonkeyPatch, terminal: bool) -> None:
    watched = Watched(monkeypatch, terminal)
    said = watched.show()
    assert "10 trials, 3 fixed trajectories" in said and "0.6 mm from the target" in said
    assert "10 of 10 trials" in said and "36 of 36 simulations" in said
    assert "trial 10/10: best C = 1.0000, 2.0 mm from the target" in said
    assert ("━" in said) == terminal and watched.prepared == 1


def test_a_folder_without_a_fold_has_no_verdict(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"result\.json: cannot be read"):
        conclusion(tmp_path)


COMMANDS = [
    ["learn", "towel", "--out", "OUT", "--simulator", "blender"],
    ["simulate", "SCENE", "--out", "OUT", "--simulator", "blender"],
    ["calibrate", "MEASUREMENTS", "--out", "OUT.toml", "--simulator", "blender"],
    ["check", "FOLDER", "--simulator", "blender", "--out", "OUT"],
    ["margins", "FOLDER", "--simulator", "blender", "--out", "OUT"],
    ["rehearse", "FOLDER", "--simulator", "blender"],
]
"""Commands that need Blender."""


@pytest.mark.parametrize("words", COMMANDS, ids=" ".join)
def test_a_command_that_needs_blender_looks_for_it_before_it_begins(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, words: list[str]
) -> None:
    monkeypatch.setattr("tatamu.simulation.blender.discovery.python_of", lambda _: tmp_path / "none")
    monkeypatch.setattr("shutil.which", lambda *_: None)
    monkeypatch.delenv("TATAMU_BLENDER", raising=False)
    out = tmp_path / "out"
    scene(duration=0.1).save(tmp_path / "scene.json")
    places = {
        "OUT": str(out),
        "OUT.toml": str(out / "m.toml"),
        "SCENE": str(tmp_path / "scene.json"),
        "FOLDER": str(write_fold(tmp_path / "fold", spacing=0.08, frames=24)),
        "MEASUREMENTS": str(EXAMPLE),
    }
    said = refused(*(places.get(word, word) for word in words))
    assert said.startswith("tatamu: blender: must be installed")
    assert not out.exists()


@pytest.mark.parametrize("compiled", [0, 20])
def test_a_simulator_that_compiles_says_so_and_one_that_loads_does_not(
    monkeypatch: pytest.MonkeyPatch, compiled: int
) -> None:
    text = io.StringIO()

    def prepared() -> None:
        for _ in range(180_000 if compiled else 20):  # until it is said, on a machine however busy
            if "compiling the simulator" in text.getvalue():
                return
            time.sleep(0.01)

    simulator = SimpleNamespace(prepare=prepared, compilation=lambda: (compiled, 80))
    monkeypatch.setattr("tatamu.simulation.simulators.named", lambda name: simulator)
    monkeypatch.setattr("tatamu.cli.progress.BAR_EVERY", 0.01)
    prepare("native", Console(file=text))
    assert ("compiling the simulator" in text.getvalue()) == bool(compiled)


def test_the_first_step_that_fails_is_the_one_to_look_at(quarters: Task, tmp_path: Path) -> None:
    learn(quarters, plain(trials=1, **SEARCH), out=tmp_path)
    for step in ("step-1", "step-2"):
        changed(tmp_path / step / "result.json", lambda value: value["trials"][0].update(mean_vertex_distance=0.03))
    changed(tmp_path / "result.json", lambda value: value["final"].update(mean_vertex_distance=0.05))
    said = list(verdict_lines(conclusion(tmp_path)))
    assert said[0].startswith("step 1, in half across the length: failed: ")
    assert said[2].startswith("in all: failed: ")
    assert any(
        line.startswith("to do 1: look at step 1, in half across") and "step-1/report.html" in line for line in said
    )


def test_errors_of_steps_that_succeed_are_seen_to_add_up(quarters: Task, tmp_path: Path) -> None:
    learn(quarters, plain(trials=1, **SEARCH), out=tmp_path)
    for step in ("step-1", "step-2"):
        changed(
            tmp_path / step / "result.json",
            lambda value: value["trials"][0].update(
                mean_vertex_distance=0.01, moving_vertex_distance=0.01, mask_iou=0.9
            ),
        )

    def change(value: dict[str, Any]) -> None:
        value["steps"][0]["whole"]["mean_vertex_distance"] = 0.004
        value["steps"][1]["whole"]["mean_vertex_distance"] = value["final"]["mean_vertex_distance"] = 0.014

    changed(tmp_path / "result.json", change)
    advice = conclusion(tmp_path).advice
    assert "most in step 2, in half along the length (+10.0 mm)" in advice[0] and "--trials 2" in advice[1]
