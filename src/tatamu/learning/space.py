"""What is searched: x = (x1, z1, x2, z2, g1, g2), Eq. (9)."""

from __future__ import annotations

from typing import Literal

from optuna.distributions import BaseDistribution, FloatDistribution, IntDistribution

from tatamu.folding.fold import Fold

Grasps = Literal["integer", "continuous"]

HIGHEST = 0.75
"""P1 and P2 lie at most this part of the span over the grasp."""


def search_space(fold: Fold, grasps: Grasps) -> dict[str, BaseDistribution]:
    """Bounds of the search.

    P1 and P2 lie between grasp and release, from the height of the grasp up to `HIGHEST` spans. Grasps are whole
    numbers 0 .. M-1, or the paper's real numbers 0 .. M that are floored when used.
    """
    ahead, up = FloatDistribution(0.0, fold.span), FloatDistribution(0.0, HIGHEST * fold.span)
    count = fold.candidates
    grasp = IntDistribution(0, count - 1) if grasps == "integer" else FloatDistribution(0.0, float(count))
    return {"x1": ahead, "z1": up, "x2": ahead, "z2": up, "g1": grasp, "g2": grasp}


def carried_over(parameters: dict[str, float], before: Fold, fold: Fold, grasps: Grasps) -> dict[str, float]:
    """Parameters of another fold that mean the same for this one.

    P1 and P2 keep their place in parts of the span, grasps theirs among the candidates from the corner inwards.
    """
    larger = fold.span / before.span
    most = {"integer": (before.candidates - 1, fold.candidates - 1), "continuous": (before.candidates, fold.candidates)}
    old, new = most[grasps]
    moved = {name: larger * parameters[name] for name in ("x1", "z1", "x2", "z2")}
    held = {name: new * parameters[name] / max(old, 1) for name in ("g1", "g2")}
    return {name: _within(bounds, {**moved, **held}[name]) for name, bounds in search_space(fold, grasps).items()}


def _within(bounds: BaseDistribution, value: float) -> float:
    """The nearest value that the search may propose."""
    assert isinstance(bounds, FloatDistribution | IntDistribution)
    inside = min(max(value, bounds.low), bounds.high)
    return round(inside) if isinstance(bounds, IntDistribution) else float(inside)
