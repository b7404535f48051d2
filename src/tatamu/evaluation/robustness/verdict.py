"""The verdict on a fold: its result under one random draw of the disturbances."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import FiniteFloat

from tatamu.evaluation import Evaluation
from tatamu.folding.fold import Fold
from tatamu.folding.marks import marks


@dataclass(frozen=True)
class Verdict:
    """The result of a fold in one world, which is one random draw of all disturbances."""

    mean_vertex_distance: FiniteFloat | None
    """Mean of the vertex distances e_i, Eq. (12) [m]; None if the simulation failed."""
    mask_iou: FiniteFloat | None
    """Overlap of the outcome and the target, seen from above [-]; None if the simulation failed."""
    error: str | None = None
    """Reason why the simulation failed; None if it did not fail."""
    moving_vertex_distance: FiniteFloat | None = None
    """Mean of the vertex distances e_i in the part that moves [m]; None if the simulation failed."""
    marks: dict[str, FiniteFloat] | None = None
    """Marks of the fold, which are lengths that a user could measure after it [m], by the names of
    `folding.marks.MARKS`.

    None if there is no rollout, and in verdicts of earlier versions."""

    @classmethod
    def of(cls, evaluation: Evaluation, fold: Fold | None = None) -> Verdict:
        """Return the verdict on an evaluation. It contains the marks of the fold if `fold` is given."""
        score = evaluation.score
        if score is None:
            return cls(None, None, evaluation.error)
        return cls(
            score.mean_vertex_distance,
            score.mask_iou,
            moving_vertex_distance=score.moving_vertex_distance,
            marks=_marks(evaluation, fold),
        )


def _marks(evaluation: Evaluation, fold: Fold | None) -> dict[str, float] | None:
    if fold is None or evaluation.rollout is None:
        return None
    return marks(fold, evaluation.rollout.positions[-1])
