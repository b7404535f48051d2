"""The parameters of a manipulation: their search space, and curves with which a search starts.

The parameters are x = (x1, z1, x2, z2, g1, g2) of Eq. (9). The first four are the control points P1 and P2 of the
hands' Bezier curves. The last two are the numbers of the grasps.
"""

from __future__ import annotations

from functools import partial
from typing import Literal

from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import trajectory_lengths
from tatamu.search.space import Bounds, Parameters, Space

Grasps = Literal["integer", "continuous"]
"""Kind of the two parameters that choose the grasps.

`integer` means whole numbers from 0 to M-1, if a hand can grasp M vertices. `continuous` means the paper's real numbers
from 0 to M, which are rounded down when they are used.
"""

HIGHEST = 0.75
"""Largest height of the inner control points P1 and P2 above the grasp, as a fraction of the span.

The span is the horizontal distance from grasp to release.
"""
LOW = ((0.2, 0.33), (0.1, 0.33), (0.06, 1.0))
"""Low curves: for each, the height of P1 above the grasp and the horizontal distance of P2 from the grasp.

Both are fractions of the span, the horizontal distance from grasp to release.
"""
ARCHED = 0.2
"""Height of P1 above the grasp and of P2 above the release in the arched curve.

It is a fraction of the span, the horizontal distance from grasp to release.
"""
HIGH = 0.5
"""Height of the control points in the high curve, as a fraction of the span.

The span is the horizontal distance from grasp to release.

On the high curve, hands lift layers of earlier folds off the table before they turn these layers over.
"""


def search_space(fold: Fold, grasps: Grasps = "integer") -> Space:
    """Return the search space of a fold: the bounds of its parameters.

    The known part of the objective is the trajectory length l_x of Eq. (10).

    The control points P1 and P2 lie horizontally between grasp and release. Their heights are between the height of the
    grasp and `HIGHEST` times the span. With fingers, the lower bound is the height of the release, because fingers must
    pass over the cloth there.
    """
    ahead = Bounds(0.0, fold.span)
    up = Bounds(_lowest(fold), HIGHEST * fold.span)
    count = fold.candidates
    grasp = Bounds(0, count - 1, whole=True) if grasps == "integer" else Bounds(0.0, float(count))
    bounds = {"x1": ahead, "z1": up, "x2": ahead, "z2": up, "g1": grasp, "g2": grasp}
    return Space(bounds, known_part=partial(trajectory_lengths, fold))


def initial_curves(fold: Fold, *, robust: bool) -> list[Parameters]:
    """Return the curves with which a search starts. The first is the one that most likely succeeds.

    Under disturbances, that is the arched curve with grasps half-way inwards, which keeps hands away from corners.
    """
    arched = [arched_curve(fold), arched_inwards(fold)]
    return [*(arched[::-1] if robust else arched), *low_curves(fold)]


def arched_inwards(fold: Fold) -> Parameters:
    """Return the arched curve with grasps half-way inwards from the corners.

    There, hands with position errors still find cloth.
    """
    return arched_curve(fold, (fold.candidates - 1) // 2)


def later_curves(fold: Fold) -> list[Parameters]:
    """Return curves with which the search for a later fold of a plan starts: an arched curve, then high curves.

    On low curves, loose flaps of earlier folds come undone. They also come undone if hands grasp only the corners.
    """
    inwards = (0, (fold.candidates - 1) // 2, fold.candidates - 1)
    return [arched_curve(fold), *(arched_curve(fold, grasp, HIGH) for grasp in dict.fromkeys(inwards))]


def arched_curve(fold: Fold, grasp: int = 0, spans: float = ARCHED) -> Parameters:
    """Return an arched curve: it starts straight up and ends straight down.

    Hands on low curves push the cloth below them. Hands that come down from above do not push it
    (docs/notes/own-garments.md).

    Args:
        fold: The fold.
        grasp: Number of the grasp of both hands, counted from the corners inwards.
        spans: Height of P1 above the grasp and of P2 above the release, as a fraction of the span.
    """
    height = max(spans * fold.span, _lowest(fold))
    return {"x1": 0.0, "z1": height, "x2": fold.span, "z2": height, "g1": grasp, "g2": grasp}


def low_curves(fold: Fold) -> list[Parameters]:
    """Return low curves with grasps at the corners. Hands rise a little and pass low over the cloth that lies still.

    If no cloth is pushed, the shortest paths to a good fold are low curves. How low they may be depends on the cloth.
    The lowest of the curves crushes the cloth on coarse meshes.
    """
    lowest = _lowest(fold)
    return [
        {"x1": 0.0, "z1": max(height * fold.span, lowest), "x2": ahead * fold.span, "z2": lowest, "g1": 0, "g2": 0}
        for height, ahead in LOW
    ]


def _lowest(fold: Fold) -> float:
    """Return the least allowed height of the control points P1 and P2 above the grasp P0 [m]."""
    return max(0.0, *(float(hand[:, 1].max()) for hand in fold.releases)) if fold.fingers.stated else 0.0


def transfer(parameters: Parameters, before: Fold, fold: Fold, grasps: Grasps) -> Parameters:
    """Return the parameters for the fold `fold` that correspond to `parameters` of another fold, `before`.

    P1 and P2 keep their positions as fractions of the span. Grasps keep their relative positions in the row of
    candidates, from the corner inwards.
    """
    old = search_space(before, grasps).bounds
    new = search_space(fold, grasps).bounds
    larger = fold.span / before.span
    moved = {name: larger * parameters[name] for name in ("x1", "z1", "x2", "z2")}
    held = {name: new[name].high * parameters[name] / max(old[name].high, 1) for name in ("g1", "g2")}
    return {name: new[name].nearest(value) for name, value in {**moved, **held}.items()}
