"""Quality of a fold: the paper's objective and the field's measures, all computed in this module.

    C   = l_x + alpha D                               Eq. (10)
    D   = sum_i w_i e_i                               Eq. (11)
    e_i = |q_i - y_i|                                 Eq. (12)
    w_i = max(e_i - (mu_e + 1.28 sigma_e), 0) + 1     Eq. (13)

q_i are the vertices of the target shape S_t, y_i those of the outcome S_x, in metres.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tatamu.folding.fold import Fold
from tatamu.records import OpenRecord
from tatamu.zbuffer import mask

ALPHA = 0.01
"""alpha of Eq. (10), as in the paper."""
TAIL = 1.28
"""Errors beyond mu + 1.28 sigma count as unnecessary bending (Eq. (13))."""
PIXEL = 0.001
"""Resolution of the top view [m]."""


class Measured(Protocol):
    """The measures of a fold that decide its success; None if its simulation failed."""

    @property
    def mean_vertex_distance(self) -> float | None:
        """Mean of e_i [m]."""
        ...

    @property
    def moving_vertex_distance(self) -> float | None:
        """Mean of e_i over the part that moves [m]; None if it was not measured."""
        ...

    @property
    def mask_iou(self) -> float | None:
        """Overlap of the views from above [-]."""
        ...


def judged_distance(measured: Measured) -> float | None:
    """Return the distance by which a fold is judged [m]: the larger mean, of the whole or of the part that moves.

    Half of a cloth that is folded in half never moves, so the mean over all vertices hides half of an error.
    """
    whole, moving = measured.mean_vertex_distance, measured.moving_vertex_distance
    return whole if whole is None or moving is None else max(whole, moving)


class Limits(OpenRecord):
    """The limits of a successful fold."""

    mean_vertex_distance: float = 0.0125
    """Largest mean of e_i [m], over the whole and over the part that moves (12.5 mm over all points in BiFold 2025)."""
    mask_iou: float = 0.80
    """Smallest overlap of the views from above [-] (FoldBack 2026)."""

    def hold(self, measured: Measured) -> bool:
        """Return whether a fold succeeds; False if its simulation failed."""
        distance = judged_distance(measured)
        if distance is None or measured.mask_iou is None:
            return False
        near = distance <= self.mean_vertex_distance
        return near and measured.mask_iou >= self.mask_iou

    def slack(self, measured: Measured) -> float:
        """Return the distance to failure, as a fraction of the limits.

        It is 1 without any error, 0 at the limits, and negative if the fold fails: -1 if the errors are twice the
        limits or more, or if the simulation failed.
        """
        distance = judged_distance(measured)
        if distance is None or measured.mask_iou is None:
            return -1.0
        near = 1.0 - distance / self.mean_vertex_distance
        room = max(1.0 - self.mask_iou, 1e-9)
        return max(-1.0, min(near, (measured.mask_iou - self.mask_iou) / room))


class Score(OpenRecord):
    """All measures of one fold; docs/guide/learning.md names their sources."""

    objective: float
    """C = l_x + alpha D, Eq. (10)."""
    trajectory_length: float
    """l_x: length of a hand's path [m]."""
    shape_distance: float
    """D = sum of w_i e_i, Eq. (11) [m]."""
    mean_vertex_distance: float
    """Mean of e_i [m]: below 0.002 near perfect, 0.005 good, above 0.02 failed (De Gusseme and wyffels 2022)."""
    moving_vertex_distance: float | None = None
    """Mean of e_i over the part that moves [m]; None in files of earlier versions."""
    mask_iou: float
    """Intersection over union of the outcome's and the target's view from above [-]."""
    area_error: float
    """E_f = 100/r abs(A_f/A_i - r) [%]; r = 0.5 for a fold in half (Garcia-Camacho et al. 2020), otherwise the
    target's."""
    slip: float
    """Mean horizontal displacement of the part that should lie still [m]."""
    residual_bend: float
    """Largest e_i beyond mu + 1.28 sigma [m] (the paper's Fig. 2)."""

    @property
    def succeeds(self) -> bool:
        """Whether the fold keeps the field's limits."""
        return Limits().hold(self)


MEASURES = tuple(Score.model_fields)
"""Names of all measures."""


def vertex_distances(target: np.ndarray, outcome: np.ndarray) -> np.ndarray:
    """Return e_i of Eq. (12) [m], shape (n,)."""
    return np.linalg.norm(target - outcome, axis=1)


def weights(e: np.ndarray) -> np.ndarray:
    """Return w_i of Eq. (13) from e_i [m], shape (n,)."""
    return np.asarray(np.maximum(e - (e.mean() + TAIL * e.std()), 0.0) + 1.0)


def shape_distance(e: np.ndarray) -> float:
    """Return D of Eq. (11) from e_i [m]."""
    return float((weights(e) * e).sum())


def residuals(e: np.ndarray) -> np.ndarray:
    """Return the vector whose squares sum to alpha D of Eq. (10), from e_i [m], shape (n,)."""
    return np.asarray(np.sqrt(ALPHA * weights(e) * e))


def score(fold: Fold, trajectory_length: float, outcome: np.ndarray) -> Score:
    """Score the final positions of a trial, shape (n, 3)."""
    e = vertex_distances(fold.target, outcome)
    distance = shape_distance(e)
    reached, wanted, before = top_views(fold.garment.faces, outcome, fold.target, fold.start)
    ratio = fold.area_ratio or wanted.sum() / before.sum()
    still = fold.still()
    return Score(
        objective=trajectory_length + ALPHA * distance,
        trajectory_length=trajectory_length,
        shape_distance=distance,
        mean_vertex_distance=float(e.mean()),
        moving_vertex_distance=float(e[~still].mean()) if not still.all() else None,
        mask_iou=intersection_over_union(reached, wanted),
        area_error=float(100.0 / ratio * abs(reached.sum() / before.sum() - ratio)),
        slip=float(np.linalg.norm((outcome - fold.start)[still, :2], axis=1).mean()) if still.any() else 0.0,
        residual_bend=float(max(e.max() - (e.mean() + TAIL * e.std()), 0.0)),
    )


def intersection_over_union(one: np.ndarray, other: np.ndarray) -> float:
    """Return the overlap of two masks of the same shape [-]."""
    return float((one & other).sum() / max((one | other).sum(), 1))


def top_views(faces: np.ndarray, *shapes: np.ndarray) -> list[np.ndarray]:
    """Return masks of shapes seen from above, on one raster of `PIXEL`; a pixel counts if its centre is covered."""
    low = np.min([shape[:, :2].min(0) for shape in shapes], axis=0) - PIXEL
    high = np.max([shape[:, :2].max(0) for shape in shapes], axis=0) + PIXEL
    size = np.minimum(np.ceil((high - low) / PIXEL).astype(int), 8000)
    return [mask((shape[:, :2] - low) / PIXEL, faces, (size[0], size[1])) for shape in shapes]
