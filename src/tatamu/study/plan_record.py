"""The file `result.json` of a plan with several steps. See docs/reference/result-folder.md."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from tatamu.base.records import OpenRecord
from tatamu.simulation.scene import Index
from tatamu.study.record import Crossings, PlanDescription
from tatamu.study.trial import Scored


class FromFlat(OpenRecord):
    """Deviation of a folded garment from its ideal shape, which perfect folds in all steps so far would give."""

    mean_vertex_distance: float
    """Mean distance between the vertices of the folded garment and their ideal positions [m]."""
    mask_iou: float
    """Overlap of the folded garment and the ideal, seen from above: intersection over union [-]."""
    area_error: float
    """Difference between the area that the folded garment covers and the area of the ideal, relative to the latter [%].
    """

    @property
    def moving_vertex_distance(self) -> None:
        """Return None, because this measure is only defined for a single fold.

        It refers to the part of the cloth that moves. All folds of a plan together move nearly all of the cloth.
        """
        return None


class StepRecord(Scored):
    """One step of a plan: the measures of its own fold, and the deviation of the garment after all folds so far."""

    folder: Annotated[str, Field(pattern=r"^step-[1-9][0-9]{0,3}$")]
    """Name of the step's folder within the plan's folder."""
    title: str
    """Title of the step's fold, in a few words."""
    hands: int
    """Number of folding hands."""
    trials: int
    """Number of trials of the step."""
    best: Index
    """Number of the best trial: the complete trial with the lowest objective."""
    crossings: Crossings
    whole: FromFlat


class PlanRecord(OpenRecord):
    """A plan whose steps are learned."""

    version: Literal[1] = 1
    tatamu: str = ""
    """Version of tatamu that wrote the file."""
    plan: PlanDescription
    sampler: str
    grasps: str
    seed: int
    wall_seconds: float
    """Sum of the wall time of all steps [s]."""
    steps: Annotated[list[StepRecord], Field(min_length=1)]
    final: FromFlat
    """Deviation from the ideal after the last step."""
