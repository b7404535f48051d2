"""Quality of a fold: the paper's objective, the field's measures, and marks that a person or a camera can measure.

    C   = l_x + alpha D                               Eq. (10)
    D   = sum_i w_i e_i                               Eq. (11)
    e_i = |q_i - y_i|                                 Eq. (12)
    w_i = max(e_i - (mu_e + 1.28 sigma_e), 0) + 1     Eq. (13)

q_i are the vertices of the target shape S_t and y_i those of the outcome S_x [m]. C is the objective, l_x the length of
the hands' paths [m], D the shape distance [m], and w_i the weight of vertex i. mu_e and sigma_e are the mean and the
standard deviation of the distances e_i [m].

The marks are six deviations. The corners of the moved hem are the first grasp candidates of both hands. The lower hem
is the part of the cloth that does not move and is nearest to the targets of these corners.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from tatamu.base.records import OpenRecord
from tatamu.folding.fold import Fold
from tatamu.simulation.mesh.zbuffer import mask

ALPHA = 0.01
"""Factor alpha of Eq. (10). The value is the paper's."""
TAIL = 1.28
"""Factor of the standard deviation in Eq. (13). The cloth is bent unnecessarily at vertices farther from their targets.
"""
PIXEL = 0.001
"""Width of a pixel in the view from above [m]."""
MARKS = ("left_along", "left_across", "right_along", "right_across", "slip_along", "slip_across")
"""Deviations of both corners of the moved hem, and of the lower hem (slip), from their targets [m]: along the direction
in which the fold moves cloth, and across it, positive to the left."""


class Measured(Protocol):
    """The measures that decide whether a fold succeeds; None if its simulation failed."""

    @property
    def mean_vertex_distance(self) -> float | None: ...

    @property
    def moving_vertex_distance(self) -> float | None: ...

    @property
    def mask_iou(self) -> float | None: ...


def judged_distance(measured: Measured) -> float | None:
    """Return the vertex distance that decides whether a fold succeeds [m].

    It is the larger of the means over all vertices and over those that move. When a cloth is folded in half, half of it
    never moves, so the mean over all vertices would hide half of the error.
    """
    whole, moving = measured.mean_vertex_distance, measured.moving_vertex_distance
    return whole if whole is None or moving is None else max(whole, moving)


class Limits(OpenRecord):
    """The limits within which a fold succeeds."""

    mean_vertex_distance: float = 0.0125
    """Maximum of `judged_distance` [m]. BiFold 2025 uses 12.5 mm over all points."""
    mask_iou: float = 0.80
    """Minimum overlap of the cloth and its target, seen from above [-] (FoldBack 2026)."""

    def hold(self, measured: Measured) -> bool:
        """Return whether a fold succeeds; False if its simulation failed."""
        distance = judged_distance(measured)
        if distance is None or measured.mask_iou is None:
            return False
        near = distance <= self.mean_vertex_distance
        return near and measured.mask_iou >= self.mask_iou

    def slack(self, measured: Measured) -> float:
        """Return how far a fold is from failure, as a fraction of the limits, at least -1.

        The result is 1 without any error, 0 at the limits, and -1 for twice the limits or a failed simulation.
        """
        distance = judged_distance(measured)
        if distance is None or measured.mask_iou is None:
            return -1.0
        near = 1.0 - distance / self.mean_vertex_distance
        room = max(1.0 - self.mask_iou, 1e-9)
        return max(-1.0, min(near, (measured.mask_iou - self.mask_iou) / room))


class Score(OpenRecord):
    """All measures of one fold. Their sources are in docs/guide/learning.md."""

    objective: float
    """Objective C, Eq. (10)."""
    trajectory_length: float
    """Trajectory length l_x: mean length of the hands' paths [m]."""
    shape_distance: float
    """Shape distance D, Eq. (11) [m]."""
    mean_vertex_distance: float
    """Mean distance e_i of the vertices from their targets [m]. Below 0.002 a fold is near perfect, around 0.005 it is
    good, and above 0.02 it has failed (De Gusseme and wyffels 2022)."""
    moving_vertex_distance: float | None = None
    """The same for the vertices that should move [m]; None in files of earlier versions."""
    mask_iou: float
    """Intersection over union of the folded cloth and its target, seen from above [-]."""
    area_error: float
    """E_f = 100/r abs(A_f/A_i - r) [%], with the areas A_i before and A_f after the fold, seen from above. r is 0.5 for
    a fold in half (Garcia-Camacho et al. 2020), otherwise the ratio of the target's area to A_i."""
    slip: float
    """Mean horizontal displacement of the part that should not move [m]."""
    residual_bend: float
    """Maximum amount by which a distance e_i exceeds mu_e + 1.28 sigma_e [m] (the paper's Fig. 2)."""

    @property
    def succeeds(self) -> bool:
        """Whether the fold is within the default `Limits`."""
        return Limits().hold(self)


MEASURES = tuple(Score.model_fields)


def vertex_distances(target: np.ndarray, outcome: np.ndarray) -> np.ndarray:
    """Return the distance e_i of each vertex from its target [m], Eq. (12), shape (n,)."""
    return np.linalg.norm(target - outcome, axis=1)


def weights(e: np.ndarray) -> np.ndarray:
    """Return the weights w_i of Eq. (13), shape (n,), from the distances e_i [m]."""
    return np.asarray(np.maximum(e - (e.mean() + TAIL * e.std()), 0.0) + 1.0)


def shape_distance(e: np.ndarray) -> float:
    """Return the shape distance D of Eq. (11) from the distances e_i [m]."""
    return float((weights(e) * e).sum())


def score(fold: Fold, trajectory_length: float, outcome: np.ndarray) -> Score:
    """Return the score of a trial from the final positions of the cloth [m], shape (n, 3)."""
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
    """Return the area of two masks' intersection divided by that of their union [-]."""
    return float((one & other).sum() / max((one | other).sum(), 1))


def top_views(faces: np.ndarray, *shapes: np.ndarray) -> list[np.ndarray]:
    """Return masks of shapes seen from above: which pixels of a common raster have their centres in each."""
    low = np.min([shape[:, :2].min(0) for shape in shapes], axis=0) - PIXEL
    high = np.max([shape[:, :2].max(0) for shape in shapes], axis=0) + PIXEL
    size = np.minimum(np.ceil((high - low) / PIXEL).astype(int), 8000)
    return [mask((shape[:, :2] - low) / PIXEL, faces, (size[0], size[1])) for shape in shapes]


def marks(fold: Fold, final: np.ndarray) -> dict[str, float]:
    """Return the deviations `MARKS` of a cloth that ends at `final` [m], shape (n, 3), by their names."""
    corners = [int(fold.left[0]), int(fold.right[0])]
    moved = [(final - fold.target)[corner, :2] for corner in corners]
    hem = lower_hem(fold, corners)
    shifts = [*moved, (final - fold.start)[hem, :2].mean(axis=0)]
    axes = (fold.normal, fold.crease.along)
    return dict(zip(MARKS, (float(shift @ axis) for shift in shifts for axis in axes), strict=True))


def lower_hem(fold: Fold, corners: list[int]) -> list[int]:
    """Return the vertex of unmoved cloth that is nearest to each corner's target."""
    still = np.flatnonzero(fold.still())
    if not len(still):
        across, _ = fold.crease.split(fold.start)
        still = np.flatnonzero(across > 0)
    return [
        int(still[np.linalg.norm(fold.start[still, :2] - fold.target[corner, :2], axis=1).argmin()])
        for corner in corners
    ]
