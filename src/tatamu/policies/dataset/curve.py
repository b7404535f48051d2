"""The curve along which the hands move in a randomly drawn fold.

This curve is near the default curve, an arch, or near the curve of a learned fold.
"""

from __future__ import annotations

from tatamu.folding.parameters import arched_curve
from tatamu.folding.task import Task
from tatamu.policies.dataset.sources import DrawnFold
from tatamu.search import Parameters


def parameters_of(drawn: DrawnFold, task: Task, spread: float) -> Parameters:
    """Return the parameters of the hands' curve, Eq. (9), in a randomly drawn fold.

    Args:
        drawn: The random numbers of the fold.
        task: The task of the fold.
        spread: Largest distance from the middle curve in each parameter, as a fraction of the search space. The middle
            curve is the default curve or the curve of a learned fold.
    """
    middle = drawn.middle or arched_curve(task.fold)
    bounds = task.space.bounds
    return {
        name: bounds[name].nearest(middle[name] + spread * each * (bounds[name].high - bounds[name].low))
        for name, each in zip(bounds, drawn.unit, strict=True)
    }
