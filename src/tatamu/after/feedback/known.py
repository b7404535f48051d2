"""Learning after measured folds: the study takes the posterior as its disturbances, and corrects its mean."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tatamu.after.feedback.correction import added, shifts_against
from tatamu.after.feedback.folder import FeedbackFolder
from tatamu.after.feedback.observe import feedback_of
from tatamu.after.feedback.posterior import posterior
from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import Disturbances, mean_scenario
from tatamu.folding.manipulation import HandShift
from tatamu.folding.parameters import Grasps, transfer
from tatamu.folding.task import Task
from tatamu.search import Parameters
from tatamu.study.result import Result

TRIALS = 20
"""Default number of trials. Few suffice, because the search starts from a fold that is nearly right."""


@dataclass(frozen=True)
class Known:
    """The inputs of a study that follow from measured folds."""

    disturbances: Disturbances
    """The posterior of the set-up."""
    shift: tuple[HandShift, ...]
    """The shift of each hand in every manipulation of the study."""
    first: list[Parameters]
    """The measured folds, as parameters of the study's task."""


def known_of(runs: Sequence[Result], task: Task, grasps: Grasps = "integer") -> Known:
    """Return the inputs of a study from measured folds of one set-up.

    Args:
        runs: Learned folds that were carried out and measured. The search starts from the last of them.
        task: The task of the study.
        grasps: The way in which the study searches the grasps.

    Raises:
        InputError: If a fold was not measured, the folds do not belong to one set-up, or the task has several steps.
    """
    if len(task.plan.steps) > 1:
        raise InputError(
            f"after: needs a fold plan of a single step, but {task.plan.name} has {len(task.plan.steps)} steps; "
            "leave out `after`"
        )
    folders = [_folder(run) for run in runs]
    measured = [feedback_of(Result.load(folder.path), folder) for folder in folders]
    source = measured[0].disturbances
    for each in measured[1:]:
        if each.disturbances != source:
            raise InputError(
                f"after: all folds must have been learned with the same disturbances, but {each.learned.folder} and "
                f"{measured[0].learned.folder} differ; leave one of these folds out"
            )
    found = posterior(source, [fold for each in measured for fold in each.folds]).disturbances
    shifts = shifts_against(task.fold, task.manipulation(task.space.middle()), mean_scenario(found))
    first = [transfer(run.best.parameters, run.task.fold, task.fold, grasps) for run in runs]
    return Known(found, added(task.shift, shifts), first)


def _folder(run: Result) -> FeedbackFolder:
    if run.folder is None:
        raise InputError("after: must be a fold that was loaded from a folder; save the fold, then load the folder")
    folder = FeedbackFolder.of(run.folder)
    folder.require_measured(run.folder)
    return folder
