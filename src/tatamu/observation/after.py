"""Learning after observed folds.

The study uses the posterior as its disturbances, corrects the mean of the posterior, and starts from the last fold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tatamu.disturbances import Disturbances, hand_errors, mean_world, read_disturbances
from tatamu.errors import InputError
from tatamu.folding.parameters import Grasps, transfer
from tatamu.folding.shift import HandShift
from tatamu.folding.task import Task
from tatamu.observation.correction import added, shift_against
from tatamu.observation.folder import ObservedFolder
from tatamu.observation.observe import disturbances_of, evidence_of
from tatamu.observation.posterior import posterior
from tatamu.search import Parameters
from tatamu.study import Result

TRIALS = 20
"""Default number of trials: the search starts from a fold that is nearly right."""


@dataclass(frozen=True)
class Known:
    """The inputs of a study from observed folds."""

    disturbances: Disturbances
    """Disturbances of the posterior."""
    shift: tuple[HandShift, ...]
    """The correction of every manipulation of the study."""
    first: list[Parameters]
    """The observed folds, as parameters of the study's task."""


def known_of(runs: Sequence[Result], task: Task, grasps: Grasps = "integer") -> Known:
    """Return the inputs of a study from observed folds of one set-up.

    Args:
        runs: Learned folds that were observed; the search starts from the last.
        task: The task of the study.
        grasps: Search of the study's grasps.

    Raises:
        InputError: If a fold was not observed, the folds are not of one set-up, or the task has several steps.
    """
    if len(task.plan.steps) > 1:
        raise InputError(f"after: is for a single fold, and {task.plan.name} has {len(task.plan.steps)}")
    found = _posterior(runs)
    errors = hand_errors(task.fold, task.manipulation(task.space.middle()), mean_world(found))
    first = [transfer(run.best.parameters, run.task.fold, task.fold, grasps) for run in runs]
    return Known(found, added(task.shift, shift_against(errors)), first)


def _posterior(runs: Sequence[Result]) -> Disturbances:
    """Return the posterior of one fold from its file, or of several from all their observations."""
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
