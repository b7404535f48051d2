"""Learning: ask, simulate, score, tell, until the trials are done; then write the folder."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import Any

from filelock import FileLock, Timeout

from tatamu.errors import InputError
from tatamu.files import unwritable
from tatamu.folding.manipulation import trajectory_lengths
from tatamu.folding.task import Task
from tatamu.learning.database import SharedDatabase
from tatamu.learning.expectation import Expectation
from tatamu.learning.place import existing_place, held_place
from tatamu.learning.runner import Progress, Runner
from tatamu.learning.samplers import check_sampler
from tatamu.learning.schedule import FINE_SHARE, FINE_SHARE_UNSURE, GAIN, Schedule, Trials
from tatamu.learning.space import Grasps, search_space
from tatamu.learning.study import Identity, OptunaStudy, held_identity
from tatamu.results import ResultFolder, describe_task
from tatamu.results.folder import LEARNED
from tatamu.results.result import Parameters
from tatamu.simulators import SIMULATORS, capabilities
from tatamu.simulators.many import executor_of

PENDING = 4
"""Trials at a time unless somebody asks for another number, where the simulator runs several: the same number on any
machine, as the study depends on it."""
MOST_PARALLEL = 16
"""Trials at a time at most: more would know too little of one another."""


def learn(
    task: Task,
    folder: Path,
    *,
    trials: Trials = 50,
    seed: int = 0,
    sampler: str = "gp",
    grasps: Grasps = "integer",
    baselines: bool = True,
    parallel: int | None = None,
    first: Sequence[Parameters] = (),
    expectation: Expectation | None = None,
    executor: Executor | None = None,
    database: SharedDatabase | None = None,
    progress: Callable[[Progress], None] = lambda _: None,
) -> Path:
    """Learn a task, or go on where it stopped; the folder then holds everything.

    Args:
        task: The fold, the garment and the simulator.
        folder: Where the study lives; made if it is not there.
        trials: How many trials the study shall have in the end. "auto": until less than 0.1 % of the best objective is
            expected to be gained by three proposals in a row, at most 100; the sampler must be "gp".
        seed: Of the search.
        sampler: Name of the sampler.
        grasps: Search grasps as whole numbers, or as real numbers that are floored, as in the paper.
        baselines: Also score the fixed trajectories.
        parallel: How many trials are pending at a time. Each is proposed knowing all before it but the last `parallel`
            - 1, whether these have ended or not, so that the study depends on this number, but not on how many
            processors there are. None: as the study began with, or else `PENDING` where the simulator can.
        first: Parameters to begin the search with, as many as there are trials for.
        expectation: What is not known of hands, cloth and table, so that the objective is an expectation over it; None:
            it is C of Eq. (10), where nothing is off.
        executor: Where trials run; None: threads on every processor.
        database: Holds the study; None: the file `study.db` of the folder.
        progress: Called when the study is opened, after every trial, and when another stage begins.

    Returns:
        The report.

    Raises:
        InputError: An argument is out of range, or the folder cannot be used.
        UnavailableError: Workers, the database or the disk fail; what was finished is kept.
        TatamuError: Every trial failed.
        KeyboardInterrupt: The user ended it; what is finished is then written with a report, as far as there is any.
    """
    check_search(trials, seed, sampler)
    check_parallel(parallel, task.simulator)
    results = ResultFolder(folder)
    with locked(results):
        identity = Identity(
            task=describe_task(task),
            sampler=sampler,
            grasps=grasps,
            seed=seed,
            parallel=pending_trials(parallel, task.simulator, results, database),
            first=[dict(parameters) for parameters in first],
            coarse=task.coarser.fold.garment.spacing if task.coarser else None,
            disturbances=expectation.disturbances.describe() if expectation else None,
            worlds=expectation.worlds if expectation else None,
            quantile=expectation.quantile if expectation else None,
        )
        with held_place(results, database, identity.model_dump()) as place:
            lengths = partial(trajectory_lengths, task.fold)
            study = OptunaStudy(place, identity, search_space(task.fold, grasps), lengths)
            return _gone_on(task, study, results, trials, baselines, expectation, executor, progress)


def fine_share(task: Task, expectation: Expectation | None) -> float:
    """The part of a study's trials that runs on the task's own mesh after a coarser one.

    More where coarser meshes are less sure: of later steps, and of how folds of two layers hold in disturbed worlds.
    """
    holds_unsurely = expectation is not None and task.fold.garment.layers > 1
    return FINE_SHARE_UNSURE if task.step[0] > 1 or holds_unsurely else FINE_SHARE


def _gone_on(
    task: Task,
    study: OptunaStudy,
    results: ResultFolder,
    trials: Trials,
    baselines: bool,
    expectation: Expectation | None,
    executor: Executor | None,
    progress: Callable[[Progress], None],
) -> Path:
    """Run the trials that a study lacks, and write its folder; arguments and errors are those of `learn`."""
    done = len(study.trials)
    meshes = 1 if study.identity.coarse is None else 2
    schedule = Schedule(trials, meshes, fine_share(task, expectation))
    most = schedule.most
    if done > most:
        raise InputError(f"trials: {results.path} has {done} trials already, given {trials}; give {done} or more")
    with executor_of(executor, study.identity.parallel) as workers:
        runner = Runner(task, study, workers, expectation)
        if runner.is_over(schedule) and results.complete and not (baselines and study.baselines is None):
            return results.report_file
        results.report_file.unlink(missing_ok=True)  # written last: it says that the other files are this study's
        until_gain = GAIN if trials == "auto" else None
        try:
            progress(runner.progress(most))
            for stage in runner.run(schedule, baselines):
                progress(runner.progress(most, stage))
            progress(runner.progress(most, "report"))
            return runner.write(results, until_gain)
        except KeyboardInterrupt:
            if runner.succeeded:
                progress(runner.progress(most, "report"))
                runner.write(results, until_gain)
            raise


def check_search(trials: Trials, seed: int, sampler: str) -> None:
    """Refuse a search that cannot be."""
    if trials == "auto":
        if sampler != "gp":
            raise InputError(f"trials: auto is for the sampler gp, which says what it expects, given {sampler}")
    elif not 1 <= trials <= 10_000:
        raise InputError(f"trials: must be from 1 to 10000, given {trials}")
    if not 0 <= seed < 2**32:
        raise InputError(f"seed: must be from 0 to {2**32 - 1}, given {seed}")
    check_sampler(sampler)


def check_parallel(parallel: int | None, simulator: str) -> None:
    """Refuse to run more trials at a time than a simulator can."""
    if parallel is None:
        return
    if not 1 <= parallel <= MOST_PARALLEL:
        raise InputError(f"parallel: must be from 1 to {MOST_PARALLEL}, given {parallel}")
    if parallel > 1 and not capabilities(simulator).parallel:
        able = ", ".join(name for name in SIMULATORS if capabilities(name).parallel)
        raise InputError(f"parallel: only {able} runs several trials at a time, given {parallel} with {simulator}")


def pending_trials(
    parallel: int | None, simulator: str, folder: ResultFolder, database: SharedDatabase | None = None
) -> int:
    """How many trials are pending at a time: the number given, that of the study in the folder, or the usual one."""
    if parallel is not None:
        return parallel
    held = held_identity(existing_place(folder, database))
    if held is not None:
        return held.parallel
    return pending_at_first(simulator)


def pending_at_first(simulator: str) -> int:
    """How many trials are pending in a study that begins, unless somebody asks for another number."""
    return PENDING if capabilities(simulator).parallel else 1


def locked(folder: ResultFolder) -> Any:
    """A lock on the folder that ends with the process, however it ends.

    Raises:
        InputError: The folder cannot be written, another run has it, or it holds such files of somebody else.
    """
    path = folder.path
    foreign = [name for name in LEARNED if os.path.exists(path / name)]
    if foreign and not folder.begun:
        raise InputError(f"{path}: holds a {foreign[0]} but no study, and it would be lost; give another folder")
    try:
        path.mkdir(parents=True, exist_ok=True)
        lock = FileLock(path / ".lock")
        return lock.acquire(timeout=0)
    except Timeout:
        raise InputError(f"{path}: another run is learning here") from None
    except OSError as error:
        raise unwritable(path, error) from None
