"""Learning a job: each step of its plan in turn, every step from the state that the one before it left.

A plan of one step fills its folder as `learn` does. A longer one has a folder per step, each as `learn` fills it, and
beside them what belongs to the whole.
"""

from __future__ import annotations

import shutil
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import Executor
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.disturbances import Disturbances
from tatamu.errors import InputError
from tatamu.folding.advice import UncarriedWarning, advice
from tatamu.folding.coarser import with_coarser
from tatamu.folding.fold import Fold, ideal_folds
from tatamu.folding.task import Job, Task, digest
from tatamu.garments.garmentfile import files_of
from tatamu.learning.database import SharedDatabase
from tatamu.learning.expectation import Expectation
from tatamu.learning.learn import check_parallel, check_search, learn, locked, pending_trials
from tatamu.learning.place import StudyPlace, existing_place
from tatamu.learning.reachable import check_reach
from tatamu.learning.runner import Progress
from tatamu.learning.schedule import Schedule, Trials
from tatamu.learning.space import Grasps, carried_over, first_curves, later_curves
from tatamu.learning.study import held_identity
from tatamu.learning.whole import write_whole
from tatamu.material import is_preset
from tatamu.results import ResultFolder, Sources, keep_inputs
from tatamu.results.result import Parameters

Reporting = Callable[[Task, int], AbstractContextManager[Callable[[Progress], None]]]
"""Makes, of a task and its number of trials, the function that is called with the progress."""


@contextmanager
def _silent(task: Task, trials: int) -> Iterator[Callable[[Progress], None]]:
    yield lambda _: None


def learn_job(
    job: Job,
    folder: Path,
    *,
    trials: Trials = 50,
    seed: int = 0,
    sampler: str = "gp",
    grasps: Grasps = "integer",
    baselines: bool = True,
    parallel: int | None = None,
    coarse: bool | None = None,
    expectation: Expectation | None = None,
    executor: Executor | None = None,
    database: SharedDatabase | None = None,
    reporting: Reporting = _silent,
) -> Path:
    """Learn every step of a job, or go on where it stopped.

    What no hand carries in one of its folds is said by an `UncarriedWarning` before the first trial.

    A later step begins its search with what the steps before it found, each carried over to its own fold.

    Args:
        job: The garment and the plan that folds it.
        folder: Where it goes; made if it is not there.
        trials: How many trials each step shall have in the end, or "auto" (`learn`).
        seed: Of the search of every step.
        sampler: Name of the sampler.
        grasps: Search grasps as whole numbers, or as real numbers that are floored, as in the paper.
        baselines: Also score the fixed trajectories.
        parallel: How many trials are pending at a time (`learn`).
        coarse: Search on a coarser mesh first, where the job has one (`with_coarser`). None: as the study began, or
            else yes.
        expectation: What is not known, so that the objective is an expectation over it; None: it is C of Eq. (10).
        executor: Where trials run; None: threads on every processor.
        database: Holds the studies; None: the file `study.db` of each folder.
        reporting: Draws the progress of a step.

    Returns:
        The report.

    Raises:
        InputError: An argument is out of range, or the folder cannot be used.
        TatamuError: Every trial of a step failed.
        KeyboardInterrupt: The user ended it; what is finished is then written with its reports.
    """
    check_search(trials, seed, sampler)
    check_parallel(parallel, job.simulator)
    count = len(job.plan.steps)
    results = ResultFolder(folder)
    options: dict[str, Any] = {
        "seed": seed,
        "sampler": sampler,
        "grasps": grasps,
        "baselines": baselines,
        "parallel": parallel,
        "expectation": expectation,
        "executor": executor,
        "database": database,
    }
    _refuse_other(results, count)
    if not results.begun:
        check_reach(job)
    for line in advice(job.garment, job.plan, job.hands):
        warnings.warn(line, UncarriedWarning, stacklevel=2)
    opened = _keeping(job, folder, reporting)
    if count == 1:
        place = existing_place(results, database)
        task = _with_meshes(job, coarse, place).task(0)
        return _learn(task, folder, trials, opened, {**options, "first": _first(task, place, sampler)})
    with locked(results):
        options["parallel"] = pending_trials(parallel, job.simulator, results.step(0), database)
        job = _with_meshes(job, coarse, existing_place(results.step(0), database))
        ideals = [fold.target for fold in ideal_folds(job.garment, job.plan, job.hands)]
        state: np.ndarray | None = None
        found: list[tuple[Fold, Parameters]] = []
        for number in range(count):
            task = job.task(number, state)
            own = results.step(number)
            _forget_if_outdated(task, own, database)
            if number == 0:
                first = _first(task, existing_place(own, database), sampler)
            else:
                carried = [carried_over(parameters, fold, task.fold, grasps) for fold, parameters in found]
                first = [*later_curves(task.fold), *carried]
            try:
                _learn(task, own.path, trials, opened, {**options, "first": first})
            except KeyboardInterrupt:
                written = number + own.complete
                if written:
                    write_whole(job, results, ideals[:written])
                raise
            found.append((task.fold, own.result.best_trial.parameters))
            state = own.rollout.positions[-1]
        return write_whole(job, results, ideals)


def _learn(task: Task, folder: Path, trials: Trials, reporting: Reporting, options: dict[str, Any]) -> Path:
    expectation: Expectation | None = options["expectation"]
    if expectation is not None:
        options = {**options, "expectation": expectation.of_step(task.step[0])}
    with reporting(task, Schedule(trials, 1).most) as progress:
        return learn(task, folder, trials=trials, progress=progress, **options)


def _keeping(job: Job, folder: Path, reporting: Reporting) -> Reporting:
    """The same reporting, that first keeps the files that the job was made from.

    The first progress is reported once the folder is known to be this job's.
    """
    sources = _sources(job)

    @contextmanager
    def kept(task: Task, trials: int) -> Iterator[Callable[[Progress], None]]:
        with reporting(task, trials) as progress:

            def report(now: Progress) -> None:
                if sources:
                    keep_inputs(folder, sources)
                    sources.clear()
                progress(now)

            yield report

    return kept


def _sources(job: Job) -> dict[str, Sources]:
    """The user's files that a job was made from, and the plan that was found for a garment of the user's."""
    asked = job.asked
    if asked is None:
        return {}
    found = {}
    if job.garment.own:
        found["garment"] = Sources(files_of(Path(asked.garment)))
        found["fold"] = Sources(text=job.plan.to_toml(), name=f"{job.plan.name}.toml")
    if asked.fold.endswith(".toml"):
        found["fold"] = Sources([Path(asked.fold)])
    if asked.material and not is_preset(Path(asked.material)):
        found["material"] = Sources([Path(asked.material)])
    if job.reach and job.reach.files:
        found["robot"] = Sources(job.reach.files)
    return found


def _with_meshes(job: Job, coarse: bool | None, place: StudyPlace | None) -> Job:
    """The job with the meshes that its search is to use."""
    held = held_identity(place) if coarse is None else None
    wanted = coarse if coarse is not None else held is None or held.coarse is not None
    return with_coarser(job) if wanted else job


def _first(task: Task, place: StudyPlace | None, sampler: str) -> list[Parameters]:
    """Parameters that the search of a first step begins with: those that the study began with, or the usual ones."""
    held = held_identity(place)
    if held is not None:
        return held.first
    return first_curves(task.fold) if sampler == "gp" else []


def _refuse_other(folder: ResultFolder, count: int) -> None:
    """Refuse to mix one-step studies and plans in one folder."""
    if count == 1 and folder.holds_plan:
        raise InputError(f"{folder.path}: holds a plan of several steps; give another folder")
    if count > 1 and (folder.study_file.exists() or folder.shared_study_file.exists()):
        raise InputError(f"{folder.path}: holds the study of a single fold; give another folder")


def _forget_if_outdated(task: Task, folder: ResultFolder, database: SharedDatabase | None) -> None:
    """Remove the study of a step that began from a state that the step before it no longer leaves.

    It happens when a plan goes on with more trials: a better first fold makes the second another task.
    """
    held = held_identity(existing_place(folder, database))
    if held is not None and task.step[0] > 1 and held.task.start != digest(task.fold.start):
        shutil.rmtree(folder.path)


def as_begun(folder: Path, database: SharedDatabase | None = None) -> tuple[bool, Expectation | None]:
    """Whether a study was begun in a folder, and what it takes not to be known."""
    results = ResultFolder(folder)
    first = results.step(0) if results.holds_plan else results
    held = held_identity(existing_place(first, database))
    if held is None:
        return False, None
    if held.disturbances is None or held.worlds is None:
        return True, None
    return True, Expectation(Disturbances.model_validate(held.disturbances), held.quantile, held.worlds)
