"""How a fold ends in one disturbed world, and in what share of worlds it succeeds."""

from __future__ import annotations

from dataclasses import dataclass

from pydantic import FiniteFloat

from tatamu.evaluation import Evaluation


@dataclass(frozen=True)
class Verdict:
    """How a fold ended in one world."""

    mean_vertex_distance: FiniteFloat | None
    """[m]; None if the simulation failed."""
    mask_iou: FiniteFloat | None
    """[-]; None if the simulation failed."""
    error: str | None = None
    """Why it failed."""
    moving_vertex_distance: FiniteFloat | None = None
    """Mean over the part that moves [m]; None if the simulation failed."""

    @classmethod
    def of(cls, evaluation: Evaluation) -> Verdict:
        """Return the verdict on an evaluation."""
        score = evaluation.score
        if score is None:
            return cls(None, None, evaluation.error)
        return cls(score.mean_vertex_distance, score.mask_iou, None, score.moving_vertex_distance)
