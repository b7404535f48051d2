"""Learning a job: each step of its plan in turn, every step from the state that the one before it left.

A plan of one step fills its folder as `learn` does. A longer one has a folder per step, each as `learn` fills it, and
beside them what belongs to the whole.
"""

from __future__ import annotations

import os
import shutil
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.errors import InputError
from tatamu.files import read_json
from tatamu.folding.advice import UncarriedWarning, advice
from tatamu.folding.fold import Fold, ideal_folds
from tatamu.folding.task import Job, Task, digest
from tatamu.learning.learn import Progress, begun, check_parallel, check_search, learn, locked, step_name
from tatamu.learning.reachable import check_reach
from tatamu.learning.space import Grasps, carried_over
from tatamu.learning.study import held_identity
from tatamu.learning.whole import write_whole
from tatamu.rollout import Rollout

Reporting = Callable[[Task, int], AbstractContextManager[Callable[[Progress], None]]]
"""From a task and its number of trials to what is told of its progress."""


@contextmanager
def _silent(task: Task, trials: int) -> Iterator[Callable[[Progress], None]]:
    yield lambda _: None


def learn_job(
    job: Job,
    folder: Path,
    *,
    trials: int = 50,
    seed: int = 0,
    sampler: str = "gp",
    grasps: Grasps = "integer",
    baselines: bool = True,
    parallel: int = 1,
    reporting: Reporting = _silent,
) -> Path:
    """Learn every step of a job, or go on where it stopped.

    What no hand carries in one of its folds is said by an `UncarriedWarning` before the first trial.

    A later step begins its search with what the steps before it found, each carried over to its own fold.

    Args:
        job: What to fold by which plan.
        folder: Where it goes; made if it is not there.
        trials: How many trials each step shall have in the end.
        seed: Of the search of every step.
        sampler: Name of the sampler.
        grasps: Search grasps as whole numbers, or as real numbers that are floored (the paper's way).
        baselines: Also score the fixed trajectories.
        parallel: How many trials run at a time (`learn`).
        reporting: What draws the progress of a step.

    Returns:
        The report.

    Raises:
        InputError: An argument is out of range, or the folder cannot be used.
        TatamuError: Every trial of a step failed.
    """
    check_search(trials, seed, sampler)
    check_parallel(parallel, job.simulator, job.reach is not None)
    count = len(job.plan.steps)
    options: dict[str, Any] = {
        "seed": seed,
        "sampler": sampler,
        "grasps": grasps,
        "baselines": baselines,
        "parallel": parallel,
    }
    _refuse_other(folder, count)
    if not begun(folder):
        check_reach(job)
    for line in advice(job.garment, job.plan, job.hands):
        warnings.warn(line, UncarriedWarning, stacklevel=2)
    if count == 1:
        return _learn(job.task(0), folder, trials, reporting, options)
    with locked(folder):
        state: np.ndarray | None = None
        found: list[tuple[Fold, dict[str, float]]] = []
        for number in range(count):
            task, own = job.task(number, state), folder / step_name(number)
            _forget_if_outdated(task, own)
            first = [carried_over(parameters, fold, task.fold, grasps) for fold, parameters in found]
            _learn(task, own, trials, reporting, {**options, "first": first})
            found.append((task.fold, _best(own)))
            state = Rollout.load(own / "rollout.npz").positions[-1]
        folders = [folder / step_name(number) for number in range(count)]
        ideals = [fold.target for fold in ideal_folds(job.garment, job.plan, job.hands)]
        return write_whole(job, folder, folders, ideals)


def _learn(task: Task, folder: Path, trials: int, reporting: Reporting, options: dict[str, Any]) -> Path:
    with reporting(task, trials) as progress:
        return learn(task, folder, trials=trials, progress=progress, **options)


def _best(folder: Path) -> dict[str, float]:
    """Parameters of the best trial of a learned step."""
    result = read_json(folder / "result.json")
    return dict(result["trials"][result["best"]]["parameters"])


def _refuse_other(folder: Path, count: int) -> None:
    """One-step studies and plans live in different folders."""
    if count == 1 and os.path.exists(folder / step_name(0)):
        raise InputError(f"{folder}: holds a plan of several steps; give another folder")
    if count > 1 and os.path.exists(folder / "study.db"):
        raise InputError(f"{folder}: holds the study of a single fold; give another folder")


def _forget_if_outdated(task: Task, folder: Path) -> None:
    """Remove the study of a step that began from a state that the step before it no longer leaves.

    It happens when a plan goes on with more trials: a better first fold makes the second another task.
    """
    held = held_identity(folder / "study.db")
    if held is not None and task.step[0] > 1 and held.get("task", {}).get("start") != digest(task.fold.start):
        shutil.rmtree(folder)
