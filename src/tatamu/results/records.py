"""What the report reads of `result.json` and `manipulation.json`; see docs/result-folder.md."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from tatamu.material import Material
from tatamu.scene import Index, Points


class Record(BaseModel):
    """Base of what is read: frozen, finite; fields that the report does not show are passed over."""

    model_config = ConfigDict(frozen=True, extra="ignore", allow_inf_nan=False, arbitrary_types_allowed=True)


class Scores(Record):
    """The measures of one fold; None where the trial failed. Lengths in metres."""

    objective: float | None = None
    """C = l_x + alpha D, Eq. 10."""
    trajectory_length: float | None = None
    """l_x: length of a hand's path [m]."""
    shape_distance: float | None = None
    """D = sum of w_i e_i, Eq. 11 [m]."""
    mean_vertex_distance: float | None = None
    """Mean of e_i [m]."""
    mask_iou: float | None = None
    """Overlap of the two top views, intersection over union [-]."""
    area_error: float | None = None
    """E_f [%]."""
    slip: float | None = None
    """How far the part that should lie still moved [m]."""
    residual_bend: float | None = None
    """Largest e_i beyond mu + 1.28 sigma [m]."""
    seconds: float | None = None
    """Wall time [s]."""


class Trial(Scores):
    """One trial of the study."""

    number: Index
    state: Literal["complete", "failed"]
    error: str | None = None
    parameters: dict[str, float]

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.state == "complete" and (self.objective is None or self.mean_vertex_distance is None):
            raise ValueError("objective and mean_vertex_distance must be numbers where state is complete")
        return self


class Baseline(Scores):
    """A fixed trajectory, folded and measured as the trials were."""

    name: str
    title: str = ""
    path: Points
    """Of the left hand, relative to its grasp [m], shape (k, 3)."""

    @property
    def label(self) -> str:
        """What the page calls it."""
        return self.title or self.name


class Task(Record):
    """What was to be folded, and how."""

    garment: str
    size: list[float] | None = None
    """Width and length [m]."""
    fold: str
    material: Material
    spacing: float | None = None
    """Distance between vertices [m]."""
    simulator: str
    fold_line: list[list[float]] | None = None
    """Two points [m], shape (2, 2)."""
    translation: Annotated[list[float], Field(min_length=3, max_length=3)] | None = None
    """From grasp to release [m]."""
    candidates: int | None = None
    """M: how many grasps there are to choose from."""
    hands: int = 2
    """How many hands fold."""
    step: tuple[int, int] | None = None
    """Which step of how many of a plan this is; None: the only one."""
    robot: str | None = None
    """Within whose reach it was learned."""


class Asked(Record):
    """What the user named and gave."""

    garment: str
    fold: str
    size: list[float] | None = None
    """Width and length [m]; None: the garment's own."""
    spacing: float | None = None
    """Distance between vertices [m]; None: the garment's own."""
    scale: float | None = None
    """Metres per unit of the garment's file; None: as the file says."""
    hands: int | None = None
    """How many hands fold; None: as the plan says."""


class Result(Record):
    """The study: its task, its search, its trials."""

    version: Literal[1]
    tatamu: str = ""
    task: Task
    asked: Asked | None = None
    """None in folders of versions that did not write it."""
    sampler: str
    grasps: str = "integer"
    seed: int
    parallel: int = 1
    """How many trials ran at a time."""
    wall_seconds: float | None = None
    best: Index
    trials: Annotated[list[Trial], Field(min_length=1)]
    baselines: list[Baseline] = Field(default_factory=list)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if len(self._complete()) != 1:
            raise ValueError(f"best must be the number of one complete trial, given {self.best}")
        return self

    def _complete(self) -> list[Trial]:
        return [trial for trial in self.trials if trial.number == self.best and trial.state == "complete"]

    @property
    def best_trial(self) -> Trial:
        """The complete trial of least objective."""
        return self._complete()[0]


class Grasp(Record):
    """Where a hand takes the cloth."""

    vertex: Index
    position: Annotated[list[float], Field(min_length=3, max_length=3)]
    """[m], shape (3,)."""
    patch: list[Index] = Field(default_factory=list)
    """The held vertices."""


class Arm(Record):
    """One hand's part of the manipulation."""

    name: str
    grasp: Grasp
    control_points: Points
    """P0 to P3 [m], shape (4, 3)."""


class ViaPoints(Record):
    """The path in steps of `every_frames`, as a robot is given it."""

    every_frames: int
    times: list[float]
    left: Points
    right: Points | None = None
    """None where one hand folds."""


class Manipulation(Record):
    """Grasps, control points, timing."""

    version: Literal[1]
    frame_rate: float = 60.0
    arms: Annotated[list[Arm], Field(min_length=1)]
    timing: dict[str, float] = Field(default_factory=dict)
    """closes, starts, arrives, opens, ends [s]; top_speed [m/s]."""
    via_points: ViaPoints | None = None
