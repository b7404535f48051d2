"""Names of version 0.2, for one version. Each gives what took its place, with a warning."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from tatamu.evaluation.disturbances import Disturbances
from tatamu.evaluation.evaluator import Evaluator
from tatamu.evaluation.nominal import Nominal
from tatamu.evaluation.scenarios import Scenarios
from tatamu.folding.task import Reach
from tatamu.search import Parameters, Search, Space


def _warn(former: str, present: str) -> None:
    warnings.warn(f"{former} is deprecated: {present}", FutureWarning, stacklevel=3)


def Disturbed(inner: Nominal, disturbances: Disturbances, *_: Any, **__: Any) -> Scenarios:
    """Return `Scenarios(inner, disturbances)`. Quantile, number of draws and seed have no effect."""
    _warn("Disturbed", "use Scenarios, which needs no quantile and no seed")
    return Scenarios(inner, disturbances)


def CoarseFirst(inner: Evaluator, *_: Any, **__: Any) -> Evaluator:
    """Return `inner`."""
    _warn("CoarseFirst", "use the inner evaluator directly, because there is only one mesh now")
    return inner


def WithinReach(inner: Evaluator, reach: Reach) -> Evaluator:
    """Return `inner` for the task with the reach."""
    _warn("WithinReach", "pass reach to make_task instead")
    return inner.on(replace(inner.task, reach=reach))


def TwoFidelitySearch(
    make: Callable[[Space, int, Sequence[Parameters]], Search],
    space: Space,
    seed: int = 0,
    first: Sequence[Parameters] = (),
) -> Search:
    """Return the search of one mesh."""
    _warn("TwoFidelitySearch", "use GPSearch; all trials are simulated on one mesh")
    return make(space, seed, first)
