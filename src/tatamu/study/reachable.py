"""Checks before the first trial whether a robot can execute a task.

If every fold is out of reach, a search cannot learn anything.
"""

from __future__ import annotations

from collections.abc import Iterator

from tatamu.base.errors import InputError
from tatamu.folding.fold import Fold, ideal_folds
from tatamu.folding.task import Reach, Task

HEIGHTS = (0.2, 0.5)
"""Heights of the control points P1 and P2 of the tested paths, for a low path and for a high path.

They are fractions of the span, the distance from grasp to release.
"""


def check_reach(task: Task) -> None:
    """Check that the robot can execute every step of a plan.

    Each step starts from the ideal result of the previous step.

    Typical folds are tried, the easiest first. In these folds, the hands grasp the first, the middle or the last vertex
    in the list of grasp candidates, which starts at the corner. The hands move along a low curve or a high curve. The
    task is accepted if one of these folds is within the robot's reach.

    Raises:
        InputError: If none of these folds is within reach, or if the plan asks to press a fold. The message states the
            reason.
    """
    if task.reach is None:
        return
    folds = ideal_folds(task.garment, task.plan, task.hands)
    for number in range(task.number, len(folds)):
        _check_step(task.at(number, folds[number - 1].target if number else None), task.reach)


def _check_step(task: Task, reach: Reach) -> None:
    if task.fold.press is not None:
        raise InputError(f"press: {reach.robot} cannot press {_name(task)}; leave press out of the fold plan")
    refusals = []
    for parameters in _typical(task.fold):
        refusal = reach.refusal(task.manipulation(parameters))
        if refusal is None:
            return
        refusals.append(refusal)
    raise InputError(
        f"robot: {_name(task)} is out of reach of {reach.robot} in all of {len(refusals)} typical folds; of the first, "
        f"{refusals[0]}"
    )


def _typical(fold: Fold) -> Iterator[dict[str, float]]:
    """Yield the parameters of typical folds, which are tried to find out whether the robot reaches them."""
    last = fold.candidates - 1
    for grasp in dict.fromkeys((0, last // 2, last)):
        for height in HEIGHTS:
            up = height * fold.span
            yield {"x1": 0.1 * fold.span, "z1": up, "x2": 0.8 * fold.span, "z2": up, "g1": grasp, "g2": grasp}


def _name(task: Task) -> str:
    number, count = task.step
    return f"step {number}, {task.title}," if count > 1 else f"the fold {task.title or task.plan.name}"
