"""The last words of a command on a learned fold: the verdict, what to know, what to do."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tatamu.report.conclusion import Conclusion, of_fold, of_plan
from tatamu.results import ResultFolder


def conclusion(path: Path) -> Conclusion:
    """The verdict on what a folder holds.

    Raises:
        InputError: It holds no learned fold.
    """
    folder = ResultFolder(path)
    if not folder.holds_plan:
        return of_fold(folder.result)
    plan = folder.plan_result
    return of_plan(plan, [ResultFolder(path / step.folder).result for step in plan.steps])


def spoken(said: Conclusion) -> Iterator[str]:
    """The lines of a verdict as the console says them."""
    for name, step in said.steps:
        yield f"{name}: {step.text}"
    yield f"{'in all: ' if said.steps else ''}{said.text}"
    for note in said.notes:
        yield f"note: {note}"
    for number, line in enumerate(said.advice, start=1):
        yield f"to do {number}: {line}"


def how_sure(path: Path) -> Iterator[str]:
    """Lines on the share of worlds in which each learned fold holds, where that is known."""
    folder = ResultFolder(path)
    for step in folder.learned_steps() if folder.holds_plan else [folder]:
        if step.result.judged is not None:
            name = f"{step.path.name}: " if folder.holds_plan else ""
            yield f"{name}{step.result.judged.headline}; `tatamu margins {path}` asks more"


def kept(path: Path) -> str:
    """The line on what an interrupted command leaves in a folder, and on how to go on."""
    folder = ResultFolder(path)
    go_on = "run the same command again to go on"
    if not folder.begun:
        return f"interrupted before anything was finished; {go_on}"
    report = f"; what is finished is in {folder.report_file}" if folder.report_file.exists() else ""
    return f"interrupted; every finished trial is kept in {path}{report}; {go_on}"
