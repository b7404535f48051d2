"""The outcome of a fold in one scenario, kept for margins and feedback, and why it fails."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydantic import FiniteFloat

from tatamu.evaluation.evaluator import Evaluation
from tatamu.folding.fold import Fold
from tatamu.folding.score import Limits, marks

TABLE, BESIDE_CLOTH, BESIDE_TARGET = "a hand meets the table", "a hand misses the cloth", "put down beside the target"
SLIPPED, UNDONE, CRUSHED, UNSIMULATED = "slipped", "came undone", "crushed", "could not be simulated"
HELP = {
    TABLE: "aim higher (--aim), or measure the table's height better",
    BESIDE_CLOTH: "aim deeper (--aim), or locate the cloth's edge better",
    BESIDE_TARGET: "no path helps; use a better camera, or `tatamu observe` and `tatamu correct` after one fold",
    SLIPPED: "a table with more friction, or a slower fold",
    UNDONE: "a press, or a limper cloth",
    CRUSHED: "a higher path: more trials, or a larger --level",
    UNSIMULATED: "see why the simulation failed",
}
"""What helps against each cause of failure."""


@dataclass(frozen=True)
class Outcome:
    """The measures that decide whether a fold succeeds, and those that say why it does not."""

    mean_vertex_distance: FiniteFloat | None
    mask_iou: FiniteFloat | None
    error: str | None = None
    moving_vertex_distance: FiniteFloat | None = None
    marks: dict[str, FiniteFloat] | None = None
    aligned_distance: FiniteFloat | None = None
    """Mean distance of the moved part from its target after the best horizontal shift and turn of the part [m]."""
    slip: FiniteFloat | None = None
    undone: FiniteFloat | None = None
    """Share of the moved part that lies on the wrong side of the fold line."""

    @classmethod
    def of(cls, found: Evaluation, fold: Fold) -> Outcome:
        """Return the outcome of an evaluation that has its rollout, or failed."""
        score = found.score
        if score is None or found.rollout is None:
            return cls(None, None, found.error)
        final = found.rollout.positions[-1]
        moved = ~fold.still()
        return cls(
            score.mean_vertex_distance,
            score.mask_iou,
            moving_vertex_distance=score.moving_vertex_distance,
            marks=marks(fold, final),
            aligned_distance=_aligned_distance(final[moved], fold.target[moved]),
            slip=score.slip,
            undone=float((fold.crease.split(final[moved])[0] < 0.0).mean()),
        )

    def cause(self, limits: Limits) -> str | None:
        """Return why the fold fails, a key of `HELP`; None if it succeeds."""
        if limits.hold(self):
            return None
        if self.error is not None or self.aligned_distance is None:
            error = self.error or ""
            return TABLE if "meets the table" in error else BESIDE_CLOTH if "beside the cloth" in error else UNSIMULATED
        if (self.undone or 0.0) > 0.25:
            return UNDONE
        if self.aligned_distance <= limits.mean_vertex_distance and (self.slip or 0.0) <= limits.mean_vertex_distance:
            return BESIDE_TARGET
        return SLIPPED if (self.slip or 0.0) > limits.mean_vertex_distance else CRUSHED


def _aligned_distance(points: np.ndarray, target: np.ndarray) -> float:
    """Return the mean distance between points, shape (n, 3), and their targets after the best shift and turn [m]."""
    # points of the plane as complex numbers, which a factor turns
    off, goal = ((each - each.mean(axis=0))[:, :2] @ (1.0, 1.0j) for each in (points, target))
    turn = np.vdot(off, goal)
    flat = np.abs(off * turn / max(abs(turn), 1e-30) - goal)
    return float(np.hypot(flat, points[:, 2] - target[:, 2]).mean())
