"""Fixed paths of the hands, with which a learned fold is compared. The hands grasp the garment's corners."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tatamu.base.curves import SAMPLES
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import Manipulation, bezier_manipulation, polyline_manipulation


def li_2015(fold: Fold) -> Manipulation:
    """Return a manipulation along the curve in the published code of Li et al. 2015 (Yinxiaoli/iros2015_folding)."""
    x1, z1, x2, z2 = np.array([0.53996, 0.20555, 0.78185, 0.45923]) * fold.span
    return bezier_manipulation(fold, _corners(fold), x1, z1, x2, z2)


def triangle(fold: Fold) -> Manipulation:
    """Return a manipulation along straight lines to a point half a span above the fold line, then to the release."""

    def path(span: float, translation: np.ndarray) -> np.ndarray:
        return np.stack([np.zeros(3), 0.5 * translation + [0.0, 0.0, 0.5 * span], translation])

    return _each(fold, path)


def circle(fold: Fold) -> Manipulation:
    """Return a manipulation whose hands follow half circles about the fold line, as on a stiff board."""
    angle = np.linspace(0.0, np.pi, SAMPLES + 1)

    def path(span: float, translation: np.ndarray) -> np.ndarray:
        forward = 0.5 * (1.0 - np.cos(angle))[:, None] * translation
        return forward + np.sin(angle)[:, None] * [0.0, 0.0, 0.5 * span]

    return _each(fold, path)


BASELINES: dict[str, tuple[str, Callable[[Fold], Manipulation]]] = {
    "li-2015": ("Curve shipped with Li et al. 2015", li_2015),
    "triangle": ("Straight lines over half the span", triangle),
    "circle": ("Circular arc about the fold line", circle),
}


def _corners(fold: Fold) -> tuple[int, ...]:
    return tuple(int(hand[0]) for hand in (fold.left, fold.right)[: fold.hands])


def _each(fold: Fold, path: Callable[[float, np.ndarray], np.ndarray]) -> Manipulation:
    """Return a manipulation in which each hand follows `path`, called with its span and its translation [m]."""
    grasps = _corners(fold)
    return polyline_manipulation(fold, grasps, [path(fold.span_of(v), fold.translation(v)) for v in grasps])
