"""The command `tatamu learn`, which learns a fold of a garment and writes a report."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from tatamu.base.errors import InputError
from tatamu.base.files import in_shell
from tatamu.cli.options import SchedulerOption, StorageOption, options_from
from tatamu.cli.program import Interrupted
from tatamu.study.options import TaskRequest

if TYPE_CHECKING:
    from tatamu.report.conclusion import Conclusion
    from tatamu.study.plan import PlanResult
    from tatamu.study.result import Result


def _after(own: Mapping[str, Any], names_garment: bool) -> Mapping[str, Any]:
    """Return values for options of `tatamu learn` that the user did not give.

    The option `--after` names folds that were learned before, and observed on a real robot. The values are the options
    with which the last of these folds was learned, but with fewer trials. If the user gave a garment too, only the
    number of trials is returned. Without `--after`, no value is returned.
    """
    runs = own["after"] or []
    if not runs:
        if names_garment:
            return {}
        raise InputError("GARMENT: must be given, unless --after gives a measured fold")
    from tatamu.after.feedback.known import TRIALS
    from tatamu.report.command import request
    from tatamu.study.result import Result

    if names_garment:
        return {"trials": TRIALS}
    asked = request(Result.load(runs[-1]).record)
    return {**dict(asked), "trials": TRIALS, "disturbances": None}


@options_from(TaskRequest, argument="garment", defaults=_after)
def learn(
    options: TaskRequest,
    out: Path = typer.Option(..., metavar="DIR", help="Folder of the study; an unfinished study is resumed."),
    after: list[Path] | None = typer.Option(
        None,
        metavar="RUN",
        help="Start from this measured fold and from the errors that `tatamu observe` inferred. The default of "
        "--trials is then 20. Repeat the option for more folds of the same set-up.",
    ),
    scheduler: SchedulerOption = None,
    storage: StorageOption = None,
) -> None:
    """Learn to fold a garment: search grasps and hand trajectories in the simulator.

    Examples:
    `tatamu learn towel --out runs/towel`

    `tatamu learn towel --size 0.30x0.50 --trials 20 --seed 1 --out runs/small`

    `tatamu learn towel --trials auto --out runs/quick`

    `tatamu learn towel --disturbances none --out runs/paper`

    `tatamu learn tshirt --fold shop --out runs/shop`

    `tatamu learn trousers --fold leg --hands 1 --out runs/leg`

    `tatamu learn hoodie.svg --fold auto --out runs/hoodie`

    `tatamu learn towel --size 0.30x0.36 --robot hironx --out runs/hand-towel`

    `tatamu learn --after runs/towel --out runs/next`

    `tatamu learn towel --scheduler tcp://10.0.0.5:8786 --storage postgresql://lab@db/folds --out runs/towel`

    If a fold has several steps, the steps are learned one after the other, in DIR/step-1, DIR/step-2 and so on. Each
    step gets the number of trials that `--trials` gives. To resume an interrupted study, run the same command again.
    To extend a study, run the command with more `--trials`.
    """
    from tatamu.cli.progress import LearningDisplay, starting

    with ExitStack() as stack:
        with starting(f"laying out {options.garment}"):
            from tatamu.simulation.simulators import require

            require(options.simulator)
            from tatamu.api import learn as run
            from tatamu.api import task_of
            from tatamu.cluster import executor_at
            from tatamu.folding.advice import UncarriedWarning, advice
            from tatamu.folding.baselines import BASELINES
            from tatamu.study.database import shared_database  # the import takes seconds
            from tatamu.study.loop import max_trials
            from tatamu.study.result import Result

            database = stack.enter_context(shared_database(storage))
            task = task_of(options)
            remarks = advice(task.garment, task.plan, task.hands)
        asked = task.asked
        if options.size is None and asked is not None and asked.size is not None:
            width, length = asked.size
            print(f"size: {width:g} x {length:g} m, as measured in {options.material}; give --size for another size")
        if task.garment.own:
            print(task.garment.statement)
            for note in task.garment.notes:
                print(f"note: {note}")
        for line in remarks:
            print(f"warning: {line}", file=sys.stderr)
        warnings.simplefilter("ignore", UncarriedWarning)  # printed already
        fixed = len(BASELINES) if options.baselines else 0
        try:
            with (
                executor_at(scheduler) as executor,
                LearningDisplay(task, max_trials(options.trials), fixed, prepares=executor is None) as display,
            ):
                result = run(
                    task,
                    options.learning,
                    out=out,
                    after=after or [],
                    executor=executor,
                    database=database,
                    progress=display.show,
                )
        except KeyboardInterrupt:
            raise Interrupted(kept(out)) from None
        if after:
            from tatamu.after.feedback.texts import next_lines

            assert isinstance(result, Result), "measured folds are single folds"
            for line in next_lines(result):
                print(line)
        for line in (*success_lines(result), *verdict_lines(conclusion_of(result))):
            print(line)
        for warning in result.rollout.info.get("warnings") or []:
            print(f"warning: {warning}")
        print(f"report: {out / 'report.html'}")


def conclusion_of(result: Result | PlanResult) -> Conclusion:
    """Return the conclusion (success or failure, and why) for a learned fold, or for a plan of several folds."""
    from tatamu.report.conclusion import of_fold, of_plan
    from tatamu.study.result import Result

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
    from tatamu.evaluation.outcome import HELP
    from tatamu.study.result import Result

    for step in [result] if isinstance(result, Result) else result.steps:
        if step.success is not None:
            name = "" if isinstance(result, Result) or step.folder is None else f"{step.folder.name}: "
            yield f"{name}{step.success.headline}; `tatamu margins {in_shell(result.folder or Path())}` simulates more"
            for cause, count in step.success.causes.items():
                yield f"{name}{count} of {step.success.simulations} fail ({cause}): {HELP[cause]}"


def kept(path: Path) -> str:
    """Return a line that tells what an interrupted command left in a folder, and how to resume the command."""
    from tatamu.study.folder import ResultFolder

    folder = ResultFolder(path)
    resume = "run the same command again to resume"
    if not folder.has_study:
        return f"interrupted before anything was finished; {resume}"
    report = f"; the report so far is {folder.report_file}" if folder.report_file.exists() else ""
    return f"interrupted; every finished trial is kept in {path}{report}; {resume}"
