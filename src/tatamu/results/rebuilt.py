"""A learned fold with its task, built again from its description: the fold can then be scored."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tatamu.errors import InputError
from tatamu.folding.coarser import on_coarser_cells
from tatamu.folding.score import Score, score
from tatamu.folding.task import Asked, Job, Task, make_job
from tatamu.results.folder import ResultFolder
from tatamu.results.inputs import kept_input
from tatamu.results.learned import LearnedFold, read_fold
from tatamu.results.result import TaskDescription

SAME = 1e-6
"""A target built again may be this far from the one in the folder [m]: another version may differ in bits."""


@dataclass(frozen=True)
class RebuiltFold:
    """A learned fold and its task."""

    fold: LearnedFold
    task: Task

    @property
    def name(self) -> str:
        """Garment and fold: "towel, half"."""
        return f"{self.fold.result.task.garment}, {self.fold.result.task.fold}"

    @property
    def simulator(self) -> str:
        """Name of the simulator in which it was learned."""
        return self.fold.result.task.simulator

    @property
    def score(self) -> Score:
        """How good the fold was where it was learned."""
        return self.scored(self.fold.final)

    def scored(self, outcome: np.ndarray) -> Score:
        """How good another outcome of the same manipulation is, positions of shape (n, 3) [m]."""
        length = self.fold.result.best_trial.trajectory_length
        assert length is not None, "the best trial is complete"
        return score(self.task.fold, length, outcome)

    def with_coarser_mesh(self) -> Task:
        """The task with the same fold on a coarser mesh, where there is one."""
        job = _job(self.fold)
        return _task(self.fold, replace(job, coarser=on_coarser_cells(job)))


def rebuild(path: Path) -> RebuiltFold:
    """Read the folder of a learned fold and build its task again.

    Raises:
        InputError: The folder holds no learned fold, or a plan of several steps, or one whose task cannot be built
            again.
    """
    folder = ResultFolder(path)
    if folder.holds_plan:
        raise InputError(f"{path}: holds a plan of several steps; name one of them, such as {folder.step(0).path}")
    fold = read_fold(path)
    task = _task(fold, _job(fold))
    target = task.fold.target
    if target.shape != fold.target.shape or not np.abs(target - fold.target).max() < SAME:
        raise InputError(f"{path}: its task makes another target today than when it was learned; learn it again")
    return RebuiltFold(fold, task)


def _job(fold: LearnedFold) -> Job:
    """The job of a fold; files that were not kept are looked for where they were."""
    description = fold.result.task
    asked = fold.result.asked
    named: Asked | TaskDescription = asked or description
    hands = asked.hands if asked else 1 if description.hands == 1 else None
    return make_job(
        str(kept_input(fold.folder, "garment") or named.garment),
        size=(named.size[0], named.size[1]) if named.size else None,
        fold=str(kept_input(fold.folder, "fold") or named.fold),
        material=description.material,
        spacing=named.spacing,
        scale=asked.scale if asked else None,
        simulator=description.simulator,
        hands=hands,
        fingers=description.fingers,
    )


def _task(fold: LearnedFold, job: Job) -> Task:
    """The task of a fold, of cloth that lies as it lay."""
    number, _ = fold.result.task.step or (1, 1)
    return job.task(number - 1, fold.start if number > 1 else None)
