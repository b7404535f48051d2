"""The file `result.json` of a plan of several steps. See docs/reference/result-folder.md."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from tatamu.folding.task import Task
from tatamu.material import Material
from tatamu.records import OpenRecord
from tatamu.scene import Index
from tatamu.study.record import Crossings
from tatamu.study.trial import Scored


class PlanDescription(OpenRecord):
    """The garment and the plan that folds it."""

    garment: str
    size: list[float]
    """Width and length [m]."""
    fold: str
    """Name of the plan."""
    material: Material
    spacing: float
    """Distance between vertices [m]."""
    vertices: int
    """How many the mesh has."""
    simulator: str


def describe_plan(task: Task) -> PlanDescription:
    """Return the garment and the plan as `result.json` has them."""
    garment = task.garment
    return PlanDescription(
        garment=garment.name,
        size=list(garment.size),
        fold=task.plan.name,
        material=garment.material,
        spacing=garment.spacing,
        vertices=len(garment.vertices),
        simulator=task.simulator,
    )


class FromFlat(OpenRecord):
    """How far a state is from the ideal of all folds so far, made from the flat garment."""

    mean_vertex_distance: float
    """[m]."""
    mask_iou: float
    """Overlap of the two top views, intersection over union [-]."""
    area_error: float
    """[%]."""


class StepRecord(Scored):
    """A step: how well it did its own fold, and how far the garment is from the ideal of all folds so far."""

    folder: str
    """Its name within the plan's folder."""
    title: str
    """The fold in a few words."""
    hands: int
    """How many hands fold."""
    trials: int
    """How many there were."""
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
    """After the last step."""
