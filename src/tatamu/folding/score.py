"""How good a fold is: the paper's objective and the measures of the field, computed here and nowhere else.

    C   = l_x + alpha D                               Eq. (10)
    D   = sum_i w_i e_i                               Eq. (11)
    e_i = |q_i - y_i|                                 Eq. (12)
    w_i = max(e_i - (mu_e + 1.28 sigma_e), 0) + 1     Eq. (13)

q_i are the vertices of the wanted shape S_t, y_i those of the outcome S_x, in metres.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from tatamu.folding.fold import Fold
from tatamu.zbuffer import mask

ALPHA = 0.01
"""alpha of Eq. (10), as in the paper."""
TAIL = 1.28
"""Errors beyond mu + 1.28 sigma count as unnecessary bending (Eq. (13))."""
PIXEL = 0.001
"""Resolution of the top view [m]."""


@dataclass(frozen=True)
class Score:
    """All measures of one fold; docs/guide/learning.md names their sources."""

    objective: float
    """C of Eq. (10)."""
    trajectory_length: float
    """l_x [m]."""
    shape_distance: float
    """D of Eq. (11)."""
    mean_vertex_distance: float
    """Mean of e_i [m]: below 0.002 near perfect, 0.005 good, above 0.02 failed (De Gusseme and wyffels 2022)."""
    mask_iou: float
    """Intersection over union of the outcome's and the target's view from above; success at 0.80 (FoldBack 2026)."""
    area_error: float
    """E_f = 100/r |A_f/A_i - r| [%]; r = 0.5 for a fold in half (Garcia-Camacho et al. 2020), else the target's."""
    slip: float
    """Mean horizontal displacement of the part that should lie still [m]."""
    residual_bend: float
    """Largest e_i beyond mu + 1.28 sigma [m] (the paper's Fig. 2)."""

    def as_dict(self) -> dict[str, float]:
        """Plain numbers by name."""
        return asdict(self)


def vertex_distances(target: np.ndarray, outcome: np.ndarray) -> np.ndarray:
    """e_i of Eq. (12) [m], shape (n,)."""
    return np.linalg.norm(target - outcome, axis=1)


def weights(e: np.ndarray) -> np.ndarray:
    """w_i of Eq. (13) from e_i [m], shape (n,)."""
    return np.asarray(np.maximum(e - (e.mean() + TAIL * e.std()), 0.0) + 1.0)


def shape_distance(e: np.ndarray) -> float:
    """D of Eq. (11) from e_i [m]."""
    return float((weights(e) * e).sum())


def residuals(trajectory_length: float, e: np.ndarray) -> np.ndarray:
    """The vector whose squares sum to C of Eq. (10), from l_x and e_i [m], shape (1 + n,)."""
    return np.sqrt(np.concatenate([[trajectory_length], ALPHA * weights(e) * e]))


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
        mask_iou=intersection_over_union(reached, wanted),
        area_error=float(100.0 / ratio * abs(reached.sum() / before.sum() - ratio)),
        slip=float(np.linalg.norm((outcome - fold.start)[still, :2], axis=1).mean()) if still.any() else 0.0,
        residual_bend=float(max(e.max() - (e.mean() + TAIL * e.std()), 0.0)),
    )


def intersection_over_union(one: np.ndarray, other: np.ndarray) -> float:
    """Overlap of two masks of one shape."""
    return float((one & other).sum() / max((one | other).sum(), 1))


def top_views(faces: np.ndarray, *shapes: np.ndarray) -> list[np.ndarray]:
    """Masks of shapes seen from above, on one raster of `PIXEL`; pixels count by their centre."""
    low = np.min([shape[:, :2].min(0) for shape in shapes], axis=0) - PIXEL
    high = np.max([shape[:, :2].max(0) for shape in shapes], axis=0) + PIXEL
    size = np.minimum(np.ceil((high - low) / PIXEL).astype(int), 8000)
    return [mask((shape[:, :2] - low) / PIXEL, faces, (size[0], size[1])) for shape in shapes]
