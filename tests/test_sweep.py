"""Sweeps: what the file says is what is learned, whatever fails or interrupts."""

from __future__ import annotations

import inspect
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tatamu.base.errors import InputError, TatamuError, UnavailableError
from tatamu.study.options import TaskRequest
from tatamu.sweep import SweepFolder, TaskRecord, read_sweep, run_sweep
from tatamu.sweep.page import page
from tatamu.sweep.table import LiveTable, counts, varied, write_parquet
from tests.browser import Phone
from tests.commands import refused, tatamu
from tests.fabricated import write_fold
from tests.foreign import written
from tests.refusals import refusal

GRID = """
[all]
garment = "towel"
trials = 2
[grid]
size = ["0.24x0.5", "0.3x0.5"]
seed = [0, 1]
[[task]]
name = "alone"
spacing = 0.04
"""


def learned(options: dict[str, Any], folder: Path, progress: Callable[[Any], None]) -> None:
    """A fabricated study in place of a learned one."""
    progress("trial 1/2")
    write_fold(folder, spacing=0.08, frames=6)
    (folder / "report.html").write_text("")


def test_options_of_a_task_are_those_of_learn() -> None:
    from tatamu.cli.learn import learn

    apart = {"out", "scheduler", "storage", "after", "context"}
    parameters = {name: each for name, each in inspect.signature(learn).parameters.items() if name not in apart}
    assert set(parameters) == set(TaskRequest.model_fields)
    for name, field in TaskRequest.model_fields.items():
        given = parameters[name].default
        if name == "garment":
            assert field.is_required() and given is None  # `--after` may name it in a command
            continue
        if name == "trials":
            given = int(given)  # the command line has text: a number, or auto
        assert field.is_required() if given is inspect.Parameter.empty else field.default == given, name


def test_the_grid_and_single_tasks_are_read(tmp_path: Path) -> None:
    tasks = read_sweep(written(tmp_path, "sweep.toml", GRID), TaskRequest)
    assert [(task.options.get("size"), task.options.get("seed")) for task in tasks] == [
        ("0.24x0.5", 0),
        ("0.24x0.5", 1),
        ("0.3x0.5", 0),
        ("0.3x0.5", 1),
        (None, None),
    ]
    assert tasks[-1].name == "alone" and len({task.name for task in tasks}) == 5
    more = read_sweep(written(tmp_path, "sweep.toml", GRID.replace("trials = 2", "trials = 9")), TaskRequest)
    assert [task.name for task in more] == [task.name for task in tasks], "trials may grow"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "1 to 100000 tasks"),
        ("[grid]\nseed = [0]", r"grid\[0\]: garment"),
        ('[grid]\ngarment = ["towel"]\nsise = ["1x1"]', r"grid\[0\]: sise"),
        ('[grid]\ngarment = "towel"', "grid.garment"),
        ("[grid]\ngarment = []", "grid.garment"),
        ('[[task]]\ngarment = "towel"\nseed = "x"', r"task\[0\]: seed"),
        ('[[task]]\ngarment = "towel"\nseed = true', r"task\[0\]: seed"),
        ('[[task]]\ngarment = "towel"\nname = "../x"', r"task\[0\].name"),
        (
            '[[task]]\ngarment = "towel"\n[[task]]\ngarment = "towel"',
            r"task\[1\] has the same name as task\[0\]; give each task a name",
        ),
        ('version = 2\n[[task]]\ngarment = "towel"', "version"),
        ('tasks = 3\n[[task]]\ngarment = "towel"', "tasks"),
        ("[grid", "is not valid TOML"),
    ],
)
def test_a_wrong_file_is_refused_in_one_line(tmp_path: Path, text: str, said: str) -> None:
    message = refusal(read_sweep, written(tmp_path, "sweep.toml", text), TaskRequest)
    assert re.search(said, message) and "sweep.toml" in message


@pytest.mark.parametrize(
    "wrong", ['garment = "towl"', 'garment = "towel"\nsize = "x"', 'garment = "towel"\ntrials = 0']
)
def test_a_task_that_cannot_be_is_refused_before_anything_is_made(tmp_path: Path, wrong: str) -> None:
    file = written(tmp_path, "sweep.toml", f'[[task]]\ngarment = "towel"\n[[task]]\n{wrong}\n')
    assert "sweep.toml" in refused("sweep", str(file), "--out", str(tmp_path / "out"))
    assert not (tmp_path / "out").exists()


def test_a_task_that_fails_does_not_end_the_sweep(tmp_path: Path) -> None:
    tasks = read_sweep(written(tmp_path, "sweep.toml", GRID), TaskRequest)
    folder = SweepFolder(tmp_path / "out")

    def fails(options: dict[str, Any], path: Path, progress: Callable[[Any], None]) -> None:
        if options.get("seed") == 0:
            raise TatamuError("all trials failed")
        if path.name == "alone":
            raise ZeroDivisionError("a mistake")
        learned(options, path, progress)

    records = run_sweep(tasks, folder, fails, at_a_time=2)
    assert [record.state for record in records] == ["failed", "complete", "failed", "complete", "failed"]
    assert [record.error for record in records if record.error] == [
        "all trials failed",
        "all trials failed",
        "ZeroDivisionError: a mistake",
    ]
    assert folder.read() == records, "sweep.json says so"
    again = run_sweep(tasks, folder, learned)
    assert {record.state for record in again} == {"complete"} and {record.error for record in again} == {None}


def test_complete_tasks_are_left_alone_and_others_go_on(tmp_path: Path) -> None:
    tasks = read_sweep(written(tmp_path, "sweep.toml", GRID), TaskRequest)
    folder = SweepFolder(tmp_path / "out")
    asked: list[str] = []

    def counted(options: dict[str, Any], path: Path, progress: Callable[[Any], None]) -> None:
        asked.append(path.name)
        learned(options, path, progress)

    run_sweep(tasks, folder, counted, trials=2)
    trials = len(json.loads((folder.of_task("alone") / "result.json").read_text())["trials"])
    asked.clear()
    for task in tasks:
        task.options["trials"] = trials
    run_sweep(tasks, folder, counted)
    assert asked == []
    (folder.of_task("alone") / "report.html").unlink()
    run_sweep(tasks, folder, counted)
    assert asked == ["alone"]
    tasks[0].options["trials"] = trials + 1
    run_sweep(tasks, folder, counted)
    assert asked == ["alone", tasks[0].name]


@pytest.mark.parametrize("at_a_time", [1, 3])
def test_what_is_gone_ends_the_sweep_and_what_was_finished_is_kept(tmp_path: Path, at_a_time: int) -> None:
    tasks = read_sweep(written(tmp_path, "sweep.toml", GRID), TaskRequest)
    folder = SweepFolder(tmp_path / "out")

    def gone(options: dict[str, Any], path: Path, progress: Callable[[Any], None]) -> None:
        if path.name == "alone":
            raise UnavailableError("the disk is full")
        learned(options, path, progress)

    with pytest.raises(UnavailableError, match="the disk is full"):
        run_sweep(tasks, folder, gone, at_a_time=at_a_time)
    states = [record.state for record in folder.read()]
    assert states[-1] == "waiting" and states.count("complete") >= 5 - at_a_time
    assert {record.state for record in run_sweep(tasks, folder, learned)} == {"complete"}


def test_a_folder_has_one_sweep_at_a_time(tmp_path: Path) -> None:
    tasks = read_sweep(written(tmp_path, "sweep.toml", GRID), TaskRequest)
    folder = SweepFolder(tmp_path / "out")

    def within(options: dict[str, Any], path: Path, progress: Callable[[Any], None]) -> None:
        with pytest.raises(InputError, match="another sweep"):
            run_sweep(tasks, folder, learned)
        learned(options, path, progress)

    assert run_sweep(tasks[:1], folder, within)[0].state == "complete"


def records() -> list[TaskRecord]:
    options = [{"garment": "towel", "seed": seed, "size": size} for size in ("a", "b") for seed in (0, 1)]
    made = [
        TaskRecord(
            name=f"task-{number}",
            options=each,
            state="complete",
            trials=3,
            failed_trials=0,
            objective=0.8 + 0.01 * number,
            trajectory_length=0.8,
            mean_vertex_distance=0.001 * (number + 1),
            mask_iou=0.99,
            area_error=2.0,
            crossings=0,
            seconds=1.5,
        )
        for number, each in enumerate(options)
    ]
    plan = made[0].model_copy(update={"name": "plan", "objective": None, "trajectory_length": None})
    failed = TaskRecord(
        name="bad", options={"garment": "towel", "material": "<b>mine</b>"}, state="failed", error="all <i>failed</i>"
    )
    return [*made, plan, failed]


def test_the_table_has_a_row_for_each_task(tmp_path: Path) -> None:
    from pyarrow import parquet

    write_parquet(records(), tmp_path / "sweep.parquet")
    rows = parquet.read_table(tmp_path / "sweep.parquet").to_pylist()
    assert [row["name"] for row in rows] == [record.name for record in records()]
    assert rows[1]["option.seed"] == 1 and rows[1]["mean_vertex_distance"] == 0.002
    assert rows[-1]["objective"] is None and rows[-1]["option.seed"] is None and rows[-1]["state"] == "failed"


def test_without_pyarrow_it_is_said_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    from tatamu.sweep.table import check_parquet

    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"tatamu\[cluster\]"):
        check_parquet()


def test_the_page_says_what_came_out(phone: Phone) -> None:
    text = page(records())
    phone(text)
    assert "5 of 5 succeed" in text and "6 tasks: 5 complete, 1 failed" in text
    assert "all &lt;i&gt;failed&lt;/i&gt;" in text and "<b>mine" not in text and "&lt;b&gt;mine" in text
    assert 'href="task-0/report.html"' in text
    assert varied(records()) == ["seed", "size", "material"]


def test_a_page_of_failures_alone_has_no_charts() -> None:
    text = page(records()[-1:])
    assert "0 of 0 succeed" in text and 'id="chart-data"' not in text


def test_the_live_table_shows_what_runs_first() -> None:
    made = records()[:3]
    table = LiveTable(made)
    table.update(made[0], None)
    running = TaskRecord(name="task-9", options={}, state="running")
    table.update(running, "trial 1/3")
    table.update(made[1], None)
    shown = table.__rich__()
    assert list(shown.columns[0].cells) == ["task-9", "task-1", "task-0"]
    assert next(iter(shown.columns[2].cells)) == "trial 1/3"
    assert counts(made) == "3 tasks: 3 complete"


def test_the_command_learns_and_goes_on(tmp_path: Path) -> None:
    options = 'garment = "towel"\nsize = "0.24x0.5"\nspacing = 0.04\ntrials = 2\nbaselines = false'
    text = f"[all]\n{options}\n[grid]\nseed = [0, 1]\n"
    file = written(tmp_path, "sweep.toml", text)
    for _ in range(2):
        done = tatamu("sweep", str(file), "--out", str(tmp_path / "out"))
        assert done.returncode == 0 and "2 tasks: 2 complete" in done.stdout, done.stderr
    names = {path.name for path in (tmp_path / "out").iterdir() if not path.name.startswith(".")}
    assert {"sweep.json", "sweep.parquet", "sweep.html"} < names and len(names) == 5


@pytest.mark.parametrize("name", ["../outside", "javascript:alert(1)", "/etc", "", "a" * 101, ".hidden"])
def test_a_foreign_sweep_names_no_folder_outside(tmp_path: Path, name: str) -> None:
    (tmp_path / "sweep.json").write_text(json.dumps({"tasks": [{"name": name, "options": {}}]}))
    with pytest.raises(InputError, match=r"sweep\.json: tasks\.0\.name"):
        SweepFolder(tmp_path).read()
