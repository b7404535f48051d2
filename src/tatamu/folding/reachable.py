"""Whether a robot can carry out a task at all: it is asked for a few typical folds."""

from __future__ import annotations

from collections.abc import Iterator

from tatamu.base.errors import InputError
from tatamu.folding.fold import Fold, ideal_folds
from tatamu.folding.task import Reach, Task

HEIGHTS = (0.2, 0.5)
"""Heights of the typical folds, in spans."""


def check_reach(task: Task) -> None:
    """Raise InputError if the robot can carry out no typical fold in a step of the plan."""
    if task.reach is None:
        return
    folds = ideal_folds(task.garment, task.plan, task.hands)
    for number in range(task.number, len(folds)):
        _check_step(task.at(number, folds[number - 1].target if number else None), task.reach)


def _check_step(task: Task, reach: Reach) -> None:
    number, count = task.step
    name = f"step {number}, {task.title}," if count > 1 else f"the fold {task.title or task.plan.name}"
    if task.fold.press is not None:
        raise InputError(f"press: {reach.robot} cannot press {name}; leave press out of the fold plan")
    refusals = []
    for parameters in _typical_folds(task.fold):
        refusal = reach.refusal(task.manipulation(parameters))
        if refusal is None:
            return
        refusals.append(refusal)
    raise InputError(
        f"robot: {name} is out of reach of {reach.robot} in {len(refusals)} of {len(refusals)} typical folds; the "
        f"first: {refusals[0]}"
    )


def _typical_folds(fold: Fold) -> Iterator[dict[str, float]]:
    last = fold.candidates - 1
    for grasp in dict.fromkeys((0, last // 2, last)):
        for height in HEIGHTS:
            up = height * fold.span
            yield {"x1": 0.1 * fold.span, "z1": up, "x2": 0.8 * fold.span, "z2": up, "g1": grasp, "g2": grasp}
