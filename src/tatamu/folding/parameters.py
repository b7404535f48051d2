"""The parameters of a manipulation, x = (x1, z1, x2, z2, g1, g2) of Eq. (9): search space and starting curves."""

from __future__ import annotations

from functools import partial
from typing import Literal

from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import trajectory_lengths
from tatamu.search.space import Bounds, Parameters, Space

Grasps = Literal["integer", "continuous"]
"""Grasps as whole numbers 0 to M-1, or as the paper's real numbers 0 to M, which are floored when used."""

HIGHEST = 0.75
"""Largest height of the inner control points P1 and P2 over the grasp, as a fraction of the span."""
LOW = ((0.2, 0.33), (0.1, 0.33), (0.06, 1.0))
"""Low curves: height of P1 over the grasp, and distance of P2 ahead of the grasp, as fractions of the span."""
ARCHED = 0.2
"""The arched curve: height of P1 over the grasp and of P2 over the release, as a fraction of the span."""
HIGH = 0.5
"""Height of the high curve, as a fraction of the span. On it, hands lift layers of earlier folds off the table before
they turn these layers over."""


def search_space(fold: Fold, grasps: Grasps = "integer") -> Space:
    """Return the search space of a fold, with l_x of Eq. (10) as the known part of the objective.

    P1 and P2 lie between grasp and release, from the height of the grasp up to `HIGHEST` spans. Fingers must clear what
    lies at the release, so with fingers the lower bound is the height of the release.
    """
    ahead = Bounds(0.0, fold.span)
    up = Bounds(_lowest(fold), HIGHEST * fold.span)
    count = fold.candidates
    grasp = Bounds(0, count - 1, whole=True) if grasps == "integer" else Bounds(0.0, float(count))
    bounds = {"x1": ahead, "z1": up, "x2": ahead, "z2": up, "g1": grasp, "g2": grasp}
    return Space(bounds, known_part=partial(trajectory_lengths, fold))


def first_curves(fold: Fold) -> list[Parameters]:
    """Return curves to start a search with: arched at the corners, arched further inwards, then low ones."""
    return [arched_curve(fold), arched_inwards(fold), *low_curves(fold)]


def robust_curves(fold: Fold) -> list[Parameters]:
    """Return curves to start a search in disturbed worlds with.

    The first two are an arched and a low curve, which fail in different disturbed worlds. The last is the arched curve
    again, because the fine mesh starts with the last one, and its fold usually holds. A search on one mesh tries
    this curve once.
    """
    return [arched_inwards(fold), *low_curves(fold), arched_inwards(fold)]


def arched_inwards(fold: Fold) -> Parameters:
    """Return the arched curve from half-way inwards, where hands with errors still find cloth."""
    return arched_curve(fold, (fold.candidates - 1) // 2)


def later_curves(fold: Fold) -> list[Parameters]:
    """Return curves to start the search of a later step with: an arched one, then high ones.

    On low curves, loose flaps of earlier folds come undone. They also come undone if the hands hold only the corners.
    """
    inwards = (0, (fold.candidates - 1) // 2, fold.candidates - 1)
    return [arched_curve(fold), *(arched_curve(fold, grasp, HIGH) for grasp in dict.fromkeys(inwards))]


def arched_curve(fold: Fold, grasp: int = 0, spans: float = ARCHED) -> Parameters:
    """Return a curve that starts straight up and ends straight down.

    Hands that come down from above do not push the cloth below them, but hands on low curves push it
    (docs/notes/own-garments.md).

    Args:
        fold: The fold.
        grasp: Number of both grasps, from the corners inwards.
        spans: Height of P1 over the grasp and of P2 over the release, as a fraction of the span.
    """
    height = max(spans * fold.span, _lowest(fold))
    return {"x1": 0.0, "z1": height, "x2": fold.span, "z2": height, "g1": grasp, "g2": grasp}


def low_curves(fold: Fold) -> list[Parameters]:
    """Return curves from the corners that rise a little and pass low over the part that lies still.

    If no cloth is pushed, the shortest paths to a good fold are of this kind. How low they may be depends on the cloth;
    the lowest curve crushes coarse meshes.
    """
    lowest = _lowest(fold)
    return [
        {"x1": 0.0, "z1": max(height * fold.span, lowest), "x2": ahead * fold.span, "z2": lowest, "g1": 0, "g2": 0}
        for height, ahead in LOW
    ]


def _lowest(fold: Fold) -> float:
    """Return the lowest height of P1 and P2 over P0 [m]."""
    return max(0.0, *(float(hand[:, 1].max()) for hand in fold.releases)) if fold.fingers.stated else 0.0


def transfer(parameters: Parameters, before: Fold, fold: Fold, grasps: Grasps) -> Parameters:
    """Return the parameters for `fold` that correspond to `parameters` of the fold `before`.

    P1 and P2 keep their places as fractions of the span. Grasps keep their places among the candidates, counted from
    the corner inwards.
    """
    old = search_space(before, grasps).bounds
    new = search_space(fold, grasps).bounds
    larger = fold.span / before.span
    moved = {name: larger * parameters[name] for name in ("x1", "z1", "x2", "z2")}
    held = {name: new[name].high * parameters[name] / max(old[name].high, 1) for name in ("g1", "g2")}
    return {name: new[name].nearest(value) for name, value in {**moved, **held}.items()}
