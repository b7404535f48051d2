"""The models of `result.json`: the task, the search and its trials. See docs/reference/result-folder.md."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.folding.fingers import Fingers
from tatamu.folding.task import Asked, Task, digest
from tatamu.material import Material
from tatamu.records import OpenRecord
from tatamu.results.margins import JointMargin
from tatamu.scene import Index, Points

Parameters = dict[str, int | float]
"""x = (x1, z1, x2, z2, g1, g2), Eq. (9), by name; whole numbers for grasps that were searched as such."""


class Scores(OpenRecord):
    """The measures of one fold; None where the trial failed. Lengths in metres."""

    objective: float | None = None
    """C = l_x + alpha D, Eq. (10)."""
    trajectory_length: float | None = None
    """l_x: length of a hand's path [m]."""
    shape_distance: float | None = None
    """D = sum of w_i e_i, Eq. (11) [m]."""
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


class _TrialHead(OpenRecord):
    """The first fields of a trial: those of a base class that stands later come first in the file."""

    number: Index
    state: Literal["complete", "failed"]
    error: str | None = None
    """Why the trial failed."""
    parameters: Parameters


class Trial(Scores, _TrialHead):
    """One trial of the study."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"spacing", "ended", "expected_gain", "worlds", "expected_objective"})

    spacing: float | None = None
    """Of the mesh that it ran on [m]; None: the task's. On a coarser mesh D is multiplied by the vertices' ratio."""
    ended: Literal["arrival"] | None = None
    """When it ended: on arrival of the hands, where its objective, which is that then, was no less than the best. None:
    at the end of its scene."""
    expected_gain: float | None = None
    """Improvement that was expected of it, as a part of the best objective; None: the sampler did not say."""
    worlds: int | None = None
    """In how many worlds it was simulated, the undisturbed one among them; None: nothing was taken to be off."""
    expected_objective: float | None = None
    """l_x + alpha E[D] over them, or a quantile; in worlds in which the fold does not hold alpha D counts twice. An
    estimate where the trial could not win."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.state == "complete" and (self.objective is None or self.mean_vertex_distance is None):
            raise ValueError("objective and mean_vertex_distance must be numbers where state is complete")
        return self


class _BaselineHead(OpenRecord):
    """The first fields of a baseline."""

    name: str
    title: str = ""
    objective: float | None = None
    state: Literal["complete", "failed"] = "complete"
    error: str | None = None


class Baseline(Scores, _BaselineHead):
    """A fixed trajectory, folded and measured as the trials were."""

    path: Points
    """Of the left hand, relative to its grasp [m], shape (k, 3)."""

    @property
    def label(self) -> str:
        """The name that people read."""
        return self.title or self.name


class TaskDescription(OpenRecord):
    """The task of a study: two tasks are the same when their descriptions are."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"hands", "robot", "step", "start", "fingers"})

    garment: str
    size: list[float] | None = None
    """Width and length [m]."""
    fold: str
    material: Material
    spacing: float | None = None
    """Distance between vertices [m]."""
    vertices: int | None = None
    """How many the mesh has."""
    simulator: str
    fold_line: list[list[float]] | None = None
    """Two points [m], shape (2, 2)."""
    translation: Annotated[list[float], Field(min_length=3, max_length=3)] | None = None
    """From grasp to release [m]."""
    candidates: int | None = None
    """M: how many grasps there are to choose from."""
    hands: int = 2
    """How many hands fold."""
    fingers: Fingers | None = None
    """Of the hands; None: without thickness."""
    robot: str | None = None
    """The robot within whose reach the fold was learned."""
    step: tuple[int, int] | None = None
    """Number of the fold among the steps of its plan, and how many steps there are; None: the only one."""
    start: str | None = None
    """Digest of the state that a step of a plan began from; None: flat."""
    digest: str | None = None
    """Of the mesh, the grasps, the ratio of areas and the robot's file."""


def describe_task(task: Task) -> TaskDescription:
    """The task as `result.json` holds it."""
    fold = task.fold
    garment = fold.garment
    several = task.step[1] > 1
    return TaskDescription(
        garment=garment.name,
        size=list(garment.size),
        fold=task.fold_name,
        material=garment.material,
        spacing=garment.spacing,
        vertices=len(garment.vertices),
        simulator=task.simulator,
        fold_line=fold.line.tolist(),
        translation=fold.translation(int(fold.left[0])).tolist(),
        candidates=fold.candidates,
        hands=fold.hands,
        fingers=fold.fingers if fold.fingers != Fingers() else None,
        robot=task.reach.robot if task.reach else None,
        step=task.step if several else None,
        start=digest(fold.start) if several else None,
        digest=_digest(task),
    )


def _digest(task: Task) -> str:
    """Of what else makes a task: the mesh to the micrometre, grasps, the ratio of areas, the robot's file."""
    fold = task.fold
    ratio = fold.area_ratio or 0.0
    robot = task.reach.description if task.reach else b""
    return digest(fold.start.round(6) + 0.0, fold.garment.faces, fold.left, fold.right, np.array([ratio, *robot]))


class SharedStudyRecord(OpenRecord):
    """The file `study.json`: where the study of a folder is that is in a shared database."""

    version: Literal[1]
    storage: str
    """`postgresql://USER@HOST/DB`, never with a password."""
    name: str
    """Of the study there."""


class Crossings(OpenRecord):
    """How many edges pass through triangles."""

    final: int
    """At the end."""
    most: int
    """In the worst frame."""


class Result(OpenRecord):
    """The study: its task, its search, its trials."""

    UNSAID: ClassVar[frozenset[str]] = frozenset(
        {"parallel", "first", "coarse", "until_gain", "bounds", "disturbances", "worlds", "quantile", "judged"}
    )

    version: Literal[1]
    tatamu: str = ""
    """The version that wrote it."""
    task: TaskDescription
    sampler: str
    grasps: str = "integer"
    seed: int
    parallel: int = 1
    """How many trials were pending at a time."""
    first: list[Parameters] = Field(default_factory=list)
    """Parameters of the first trials, where they are not the sampler's."""
    coarse: float | None = None
    """Spacing of the coarser mesh that the search began on [m]; None: all trials are on the task's own."""
    until_gain: float | None = None
    """The search ended by itself when less than this part of the best objective was expected; None: it did not."""
    bounds: dict[str, list[float]] = Field(default_factory=dict)
    """Least and greatest value that the search could choose, by parameter; empty where a version did not write it."""
    disturbances: dict[str, Any] | None = None
    """All that was taken not to be known; None: the objective is C of Eq. (10), where nothing is off."""
    worlds: int | None = None
    """Disturbed worlds of a trial that may have won."""
    quantile: float | None = None
    """The quantile of the objective that was minimised; None: its mean."""
    judged: JointMargin | None = None
    """How sure the best fold is, in worlds in which it was not learned; None: nobody asked."""
    asked: Asked | None = None
    """None in folders of versions that did not write it."""
    wall_seconds: float | None = None
    """Sum of the trials' seconds [s]."""
    best: Index | None
    """Number of the complete trial of least objective on the task's own mesh, of least expected objective where
    something is taken to be off; None: all failed."""
    crossings: Crossings | None = None
    """Of the best trial; None: all failed."""
    trials: Annotated[list[Trial], Field(min_length=1)]
    baselines: list[Baseline] = Field(default_factory=list)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.best is not None and len(self._complete()) != 1:
            raise ValueError(f"best must be the number of one complete trial, given {self.best}")
        return self

    def _complete(self) -> list[Trial]:
        return [trial for trial in self.trials if trial.number == self.best and trial.state == "complete"]

    @property
    def least_objective(self) -> Trial | None:
        """The complete trial of least C on the task's own mesh, the paper's best; None: all failed there."""
        complete = [trial for trial in self.trials if trial.state == "complete"]
        here = [trial for trial in complete if self.coarse is None or trial.spacing != self.coarse]
        return min(here, key=lambda trial: (trial.objective or 0.0, trial.number), default=None)

    @property
    def best_trial(self) -> Trial:
        """The complete trial of least objective.

        Raises:
            ValueError: All trials failed.
        """
        if self.best is None:
            raise ValueError("all trials failed: there is no best one")
        return self._complete()[0]
