"""The search space: x = (x1, z1, x2, z2, g1, g2), Eq. (9)."""

from __future__ import annotations

from typing import Literal

from optuna.distributions import FloatDistribution, IntDistribution

from tatamu.folding.fold import Fold
from tatamu.results.result import Parameters

Grasps = Literal["integer", "continuous"]
Bounds = FloatDistribution | IntDistribution

HIGHEST = 0.75
"""P1 and P2 lie at most this part of the span over the grasp."""
LOW = ((0.2, 0.33), (0.1, 0.33), (0.06, 1.0))
"""Of low curves: height of P1 over the grasp and how far P2 is ahead of it, in parts of the span."""
ARCHED = 0.2
"""Of the arched curve: height of P1 over the grasp and of P2 over the release, in parts of the span."""
HIGH = 0.5
"""Likewise of the high one: what was folded before is lifted off the table before it is turned over."""


def search_space(fold: Fold, grasps: Grasps) -> dict[str, Bounds]:
    """Bounds of the search.

    P1 and P2 lie between grasp and release, from the height of the grasp, or from that of the release where hands have
    fingers, which must clear what is there, up to `HIGHEST` spans. Grasps are whole
    numbers 0 .. M-1, or the paper's real numbers 0 .. M that are floored when used.
    """
    ahead = FloatDistribution(0.0, fold.span)
    up = FloatDistribution(_lowest(fold), HIGHEST * fold.span)
    count = fold.candidates
    grasp = IntDistribution(0, count - 1) if grasps == "integer" else FloatDistribution(0.0, float(count))
    return {"x1": ahead, "z1": up, "x2": ahead, "z2": up, "g1": grasp, "g2": grasp}


def first_curves(fold: Fold) -> list[Parameters]:
    """Parameters to begin a search with: an arched curve at the corners and one further inwards, then low ones."""
    return [arched_curve(fold), arched_curve(fold, (fold.candidates - 1) // 2), *low_curves(fold)]


def later_curves(fold: Fold) -> list[Parameters]:
    """Parameters to begin the search of a plan's later step with: an arched curve, and high ones.

    Flaps that were folded before and lie loose come undone on low curves, and where hands hold only the corners.
    """
    inwards = (0, (fold.candidates - 1) // 2, fold.candidates - 1)
    return [arched_curve(fold), *(arched_curve(fold, grasp, HIGH) for grasp in dict.fromkeys(inwards))]


def arched_curve(fold: Fold, grasp: int = 0, spans: float = ARCHED) -> Parameters:
    """Parameters of a curve that goes straight up first and straight down at last.

    Hands that come down from above do not push what lies there, as those on low curves do
    (docs/notes/own-garments.md).

    Args:
        fold: The fold.
        grasp: Number of the grasps, from the corners inwards.
        spans: Height of P1 over the grasp and of P2 over the release, in parts of the span.
    """
    height = max(spans * fold.span, _lowest(fold))
    return {"x1": 0.0, "z1": height, "x2": fold.span, "z2": height, "g1": grasp, "g2": grasp}


def low_curves(fold: Fold) -> list[Parameters]:
    """Parameters of curves from the corners, up a little and low over what lies still, at several heights.

    The shortest paths to a good fold are of this kind where nothing is pushed; how low, depends on the cloth, and
    coarse meshes are crushed by the last.
    """
    lowest = _lowest(fold)
    return [
        {"x1": 0.0, "z1": max(height * fold.span, lowest), "x2": ahead * fold.span, "z2": lowest, "g1": 0, "g2": 0}
        for height, ahead in LOW
    ]


def _lowest(fold: Fold) -> float:
    """The least height of P1 and P2 over P0 [m]."""
    return max(0.0, *(float(hand[:, 1].max()) for hand in fold.releases)) if fold.lift else 0.0


def carried_over(parameters: Parameters, before: Fold, fold: Fold, grasps: Grasps) -> Parameters:
    """Parameters of another fold that mean the same for this one.

    P1 and P2 keep their place in parts of the span, grasps theirs among the candidates from the corner inwards.
    """
    old = search_space(before, grasps)
    new = search_space(fold, grasps)
    larger = fold.span / before.span
    moved = {name: larger * parameters[name] for name in ("x1", "z1", "x2", "z2")}
    held = {name: new[name].high * parameters[name] / max(old[name].high, 1) for name in ("g1", "g2")}
    return {name: _within(new[name], value) for name, value in {**moved, **held}.items()}


def _within(bounds: Bounds, value: float) -> float:
    """The nearest value that the search may propose."""
    inside = min(max(value, bounds.low), bounds.high)
    return round(inside) if isinstance(bounds, IntDistribution) else float(inside)
