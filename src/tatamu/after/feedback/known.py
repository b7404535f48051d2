"""Learning after observed folds.

A set-up is one robot with one garment on one table. Its errors are disturbances of the fold, such as errors of the
hands' positions. The posterior is the distribution of these errors after folds were observed. The study uses it as its
disturbances, and corrects its mean. The search starts from the last observed fold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tatamu.after.feedback.correction import added, shift_against
from tatamu.after.feedback.folder import ObservedFolder
from tatamu.after.feedback.observe import disturbances_of, evidence_of
from tatamu.after.feedback.posterior import posterior
from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import Disturbances, hand_errors, mean_world, read_disturbances
from tatamu.folding.parameters import Grasps, transfer
from tatamu.folding.shift import HandShift
from tatamu.folding.task import Task
from tatamu.search import Parameters
from tatamu.study.result import Result

TRIALS = 20
"""Default number of trials. Few trials suffice, because the search starts from a fold that is nearly right."""


@dataclass(frozen=True)
class Known:
    """The inputs of a study that follow from observed folds."""

    disturbances: Disturbances
    """Disturbances of the set-up after the observed folds (the posterior)."""
    shift: tuple[HandShift, ...]
    """The shift of each hand that corrects every manipulation of the study."""
    first: list[Parameters]
    """The observed folds, as parameters of the study's task."""


def known_of(runs: Sequence[Result], task: Task, grasps: Grasps = "integer") -> Known:
    """Return the inputs of a study from observed folds of one set-up, which is one robot, garment and table.

    Args:
        runs: Learned folds that were observed. The search starts from the last of them.
        task: The task of the study.
        grasps: The way in which the study searches the grasps.

    Raises:
        InputError: If a fold was not observed, the folds do not belong to one set-up, or the task has several steps.
    """
    if len(task.plan.steps) > 1:
        raise InputError(f"after: is for a single fold, and {task.plan.name} has {len(task.plan.steps)}")
    found = _posterior(runs)
    errors = hand_errors(task.fold, task.manipulation(task.space.middle()), mean_world(found))
    first = [transfer(run.best.parameters, run.task.fold, task.fold, grasps) for run in runs]
    return Known(found, added(task.shift, shift_against(errors)), first)


def _posterior(runs: Sequence[Result]) -> Disturbances:
    """Return the disturbances after observed folds (the posterior).

    The posterior of one fold is read from its file. The posterior of several folds is computed from all their
    observations.
    """
    folders = [_folder(run) for run in runs]
    if len(runs) == 1:
        return read_disturbances(folders[0].posterior_file)
    source = disturbances_of(Result.load(folders[0].path))
    folds = []
    for folder in folders:
        base = Result.load(folder.path)
        if disturbances_of(base) != source:
            raise InputError(
                f"after: must be folds of one set-up, learned in the same disturbances, given {base.folder}"
            )
        folds += evidence_of(base, folder).folds
    return posterior(source, folds).disturbances


def _folder(run: Result) -> ObservedFolder:
    if run.folder is None:
        raise InputError("after: must be a fold with a folder; save it, and observe it there")
    folder = ObservedFolder.of(run.folder)
    if not folder.posterior_file.exists():
        raise InputError(f"{run.folder}: has no posterior.toml; run `tatamu observe {Path(run.folder)}` first")
    return folder
