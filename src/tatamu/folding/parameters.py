"""The parameters of a manipulation: their search space, and curves with which a search starts.

They are x = (x1, z1, x2, z2, g1, g2) of Eq. (9): the control points P1 and P2 of the hands' Bezier curves, and the
indices of the grasps.
"""

from __future__ import annotations

from functools import partial
from typing import Literal

from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import trajectory_lengths
from tatamu.search.space import Bounds, Parameters, Space

Grasps = Literal["integer", "continuous"]
"""`integer`: grasps are whole numbers from 0 to M-1; `continuous`: the paper's real numbers from 0 to M, rounded down
when they are used."""

ARCHED = 0.2
"""Height of P1 above the grasp and of P2 above the release in the arched curve, in spans."""
HIGH = 0.5
"""The same in the high curve, which lifts layers of earlier folds off the table before it turns them over."""


def search_space(fold: Fold, grasps: Grasps = "integer") -> Space:
    """Return the search space of a fold, in which l_x of Eq. (10) is the known part of the objective.

    P1 and P2 lie horizontally between grasp and release, at most 0.75 spans above the grasp. They are not below it,
    nor below the release if there are fingers, which must pass over the cloth there.
    """
    ahead = Bounds(0.0, fold.span)
    up = Bounds(_lowest(fold), 0.75 * fold.span)
    count = fold.candidates
    grasp = Bounds(0, count - 1, whole=True) if grasps == "integer" else Bounds(0.0, float(count))
    bounds = {"x1": ahead, "z1": up, "x2": ahead, "z2": up, "g1": grasp, "g2": grasp}
    return Space(bounds, known_part=partial(trajectory_lengths, fold))


def initial_curves(fold: Fold, *, robust: bool) -> list[Parameters]:
    """Return the curves with which a search starts. The first is the one that most likely succeeds."""
    if robust:
        return [arched_inwards(fold), arched_inwards(fold, 0.5 * ARCHED)]
    return [arched_curve(fold), arched_inwards(fold), *low_curves(fold)]


def arched_inwards(fold: Fold, spans: float = ARCHED) -> Parameters:
    """Return an arched curve with grasps half-way inwards, where hands with position errors still find cloth."""
    return arched_curve(fold, (fold.candidates - 1) // 2, spans)


def later_curves(fold: Fold) -> list[Parameters]:
    """Return the initial curves for a later fold of a plan: an arched curve, then high curves.

    Loose flaps of earlier folds come undone on low curves, and if hands grasp only the corners.
    """
    inwards = (0, (fold.candidates - 1) // 2, fold.candidates - 1)
    return [arched_curve(fold), *(arched_curve(fold, grasp, HIGH) for grasp in dict.fromkeys(inwards))]


def arched_curve(fold: Fold, grasp: int = 0, spans: float = ARCHED) -> Parameters:
    """Return a curve `spans` high that starts straight up and ends straight down, so that hands push no cloth."""
    height = max(spans * fold.span, _lowest(fold))
    return {"x1": 0.0, "z1": height, "x2": fold.span, "z2": height, "g1": grasp, "g2": grasp}


def low_curves(fold: Fold) -> list[Parameters]:
    """Return low curves with grasps at the corners: the shortest paths to a good fold if no cloth is pushed."""
    lowest = _lowest(fold)
    return [
        {"x1": 0.0, "z1": max(height * fold.span, lowest), "x2": ahead * fold.span, "z2": lowest, "g1": 0, "g2": 0}
        for height, ahead in ((0.2, 0.33), (0.1, 0.33), (0.06, 1.0))  # of P1 above the grasp and P2 from it, in spans
    ]


def _lowest(fold: Fold) -> float:
    """Return the minimum height of P1 and P2 above the grasp P0 [m]."""
    return max(0.0, *(float(hand[:, 1].max()) for hand in fold.releases)) if fold.fingers.stated else 0.0


def transfer(parameters: Parameters, before: Fold, fold: Fold, grasps: Grasps) -> Parameters:
    """Return the parameters for `fold` that correspond to others for `before`: the same in spans and in candidates."""
    old = search_space(before, grasps).bounds
    new = search_space(fold, grasps).bounds
    larger = fold.span / before.span
    moved = {name: larger * parameters[name] for name in ("x1", "z1", "x2", "z2")}
    held = {name: new[name].high * parameters[name] / max(old[name].high, 1) for name in ("g1", "g2")}
    return {name: new[name].nearest(value) for name, value in {**moved, **held}.items()}
