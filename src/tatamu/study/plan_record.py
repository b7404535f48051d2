"""The file `result.json` of a plan of several steps. See docs/reference/result-folder.md."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from tatamu.records import OpenRecord
from tatamu.scene import Index
from tatamu.study.record import Crossings, PlanDescription
from tatamu.study.trial import Scored


class FromFlat(OpenRecord):
    """Deviation of a state from the flat garment folded ideally in all steps so far."""

    mean_vertex_distance: float
    """Mean distance of the vertices [m]."""
    mask_iou: float
    """Overlap of the two top views, intersection over union [-]."""
    area_error: float
    """Deviation of the covered area from that of the ideal [%]."""

    @property
    def moving_vertex_distance(self) -> None:
        """Return None, because the folds of a plan together leave little cloth at its place."""
        return None


class StepRecord(Scored):
    """A step: the error of its own fold, and the deviation of the garment from the ideal of all folds so far."""

    folder: str
    """Name of the step's folder within the plan's folder."""
    title: str
    """The fold in a few words."""
    hands: int
    """Number of folding hands."""
    trials: int
    """Number of trials."""
    best: Index
    """Number of the complete trial of lowest objective."""
    crossings: Crossings
    whole: FromFlat


class PlanRecord(OpenRecord):
    """A plan whose steps are learned."""

    version: Literal[1] = 1
    tatamu: str = ""
    """The version that wrote it."""
    plan: PlanDescription
    sampler: str
    grasps: str
    seed: int
    wall_seconds: float
    """Sum over the steps [s]."""
    steps: Annotated[list[StepRecord], Field(min_length=1)]
    final: FromFlat
    """Measures after the last step."""
