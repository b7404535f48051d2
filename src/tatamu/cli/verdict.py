"""Makes the last lines that a command prints about a learned fold: the conclusion, notes and advice."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tatamu.evaluation.outcome import HELP
from tatamu.report.conclusion import Conclusion, of_fold, of_plan
from tatamu.study.folder import ResultFolder
from tatamu.study.plan import PlanResult
from tatamu.study.result import Result


def conclusion_of(result: Result | PlanResult) -> Conclusion:
    """Return the conclusion (success or failure, and why) for a learned fold, or for a plan of several folds."""
    if isinstance(result, Result):
        return of_fold(result.record)
    return of_plan(result.record, [step.record for step in result.steps])


def verdict_lines(verdict: Conclusion) -> Iterator[str]:
    """Yield the lines of text with which the console shows a conclusion."""
    for name, step in verdict.steps:
        yield f"{name}: {step.text}"
    yield f"{'in all: ' if verdict.steps else ''}{verdict.text}"
    for note in verdict.notes:
        yield f"note: {note}"
    for number, line in enumerate(verdict.advice, start=1):
        yield f"to do {number}: {line}"


def success_lines(result: Result | PlanResult) -> Iterator[str]:
    """Yield a line of text for each fold with its success rate in disturbed simulations, if this rate is known."""
    for step in [result] if isinstance(result, Result) else result.steps:
        if step.success is not None:
            name = "" if isinstance(result, Result) or step.folder is None else f"{step.folder.name}: "
            yield f"{name}{step.success.headline}; `tatamu margins {result.folder}` simulates more"
            for cause, count in step.success.causes.items():
                yield f"{name}{count} of {step.success.simulations} {cause}: {HELP[cause]}"


def kept(path: Path) -> str:
    """Return a line that tells what an interrupted command left in a folder, and how to resume the command."""
    folder = ResultFolder(path)
    resume = "run the same command again to resume"
    if not folder.has_study:
        return f"interrupted before anything was finished; {resume}"
    report = f"; what is finished is in {folder.report_file}" if folder.report_file.exists() else ""
    return f"interrupted; every finished trial is kept in {path}{report}; {resume}"
