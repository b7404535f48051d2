"""The file `result.json` of a plan with several steps. See docs/reference/result-folder.md."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from tatamu.records import OpenRecord
from tatamu.scene import Index
from tatamu.study.record import Crossings, PlanDescription
from tatamu.study.trial import Scored


class FromFlat(OpenRecord):
    """Deviation of a state from the ideal: the flat garment after ideal folds in all steps so far."""

    mean_vertex_distance: float
    """Mean distance between the vertices of the state and of the ideal [m]."""
    mask_iou: float
    """Overlap of the state and the ideal, seen from above: intersection over union [-]."""
    area_error: float
    """Deviation of the area that the state covers from the area of the ideal [%]."""

    @property
    def moving_vertex_distance(self) -> None:
        """Return None, because all folds of a plan together leave little cloth where it was."""
        return None


class StepRecord(Scored):
    """One step of a plan: the error of its own fold, and the deviation from the ideal of all folds so far."""

    folder: str
    """Name of the step's folder within the plan's folder."""
    title: str
    """Title of the step's fold, in a few words."""
    hands: int
    """Number of folding hands."""
    trials: int
    """Number of trials of the step."""
    best: Index
    """Number of the complete trial with the lowest objective."""
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
