"""The file `result.json`: the task, the search and its trials. See docs/reference/result-folder.md."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.crossings import crossings_over_time
from tatamu.folding.fingers import Fingers
from tatamu.folding.parameters import Grasps
from tatamu.folding.score import Score
from tatamu.folding.shift import HandShift
from tatamu.folding.task import Task, TaskOptions, digest
from tatamu.material import Material
from tatamu.records import OpenRecord
from tatamu.robustness import SuccessRate
from tatamu.rollout import Rollout
from tatamu.scene import Index
from tatamu.search import Parameters
from tatamu.study.trial import Baseline, Trial


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
    """Their number in the mesh."""
    simulator: str


class TaskDescription(OpenRecord):
    """The task of a study: two tasks are the same if their descriptions are."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"hands", "robot", "step", "start", "fingers", "shift"})

    garment: str
    size: list[float] | None = None
    """Width and length [m]."""
    fold: str
    material: Material
    spacing: float | None = None
    """Distance between vertices [m]."""
    vertices: int | None = None
    """Their number in the mesh."""
    simulator: str
    fold_line: list[list[float]] | None = None
    """Two points [m], shape (2, 2)."""
    translation: Annotated[list[float], Field(min_length=3, max_length=3)] | None = None
    """Displacement from grasp to release [m]."""
    candidates: int | None = None
    """Number M of grasp candidates."""
    hands: int = 2
    """Number of folding hands."""
    fingers: Fingers | None = None
    """The fingers of the hands; None for fingers without thickness."""
    robot: str | None = None
    """Name of the robot within whose reach the fold was learned; None for any manipulation."""
    step: tuple[int, int] | None = None
    """Number of the step from 1, and how many steps the plan has; None if it has one."""
    start: str | None = None
    """Digest of the state that a step of a plan started from; None if it is the only step."""
    shift: list[HandShift] | None = None
    """Correction of each hand's manipulation, left before right; None without one."""
    digest: str | None = None
    """Digest of the mesh, the grasps, the ratio of areas and the robot's file."""


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


def describe_task(task: Task) -> TaskDescription:
    """Return the task as `result.json` has it."""
    fold = task.fold
    several = task.step[1] > 1
    return TaskDescription(
        **dict(describe_plan(task)),
        fold_line=fold.line.tolist(),
        translation=fold.translation(int(fold.left[0])).tolist(),
        candidates=fold.candidates,
        hands=fold.hands,
        fingers=fold.fingers if fold.fingers != Fingers() else None,
        robot=task.reach.robot if task.reach else None,
        step=task.step if several else None,
        start=digest(fold.start) if several else None,
        shift=list(task.shift) or None,
        digest=_digest(task),
    )


def _digest(task: Task) -> str:
    """Return a digest of the rest of a task: mesh to the micrometre, grasps, ratio of areas, robot's file."""
    fold = task.fold
    ratio = fold.area_ratio or 0.0
    robot = task.reach.description if task.reach else b""
    return digest(fold.start.round(6) + 0.0, fold.garment.faces, fold.left, fold.right, np.array([ratio, *robot]))


class SharedStudyRecord(OpenRecord):
    """The file `study.json`: the place of a folder's study in a shared database."""

    version: Literal[1]
    storage: str
    """`postgresql://USER@HOST/DB`, never with a password."""
    name: str
    """Name of the study there."""


class StudyRecord(OpenRecord):
    """The task of a study and the settings of its search; a study is resumed only if they are unchanged."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"parallel", "first", "coarse", "disturbances", "worlds", "quantile"})

    task: TaskDescription
    sampler: str
    """Name of the search."""
    grasps: Grasps = "integer"
    seed: int
    parallel: int = 1
    """Number of trials pending at a time."""
    first: list[Parameters] = Field(default_factory=list)
    """Parameters of the first trials, if the search does not propose them itself. If `coarse` is given, the last of
    these parameters are those of the first trial on the fine mesh."""
    coarse: float | None = None
    """Spacing of the coarser mesh that the search starts on [m]; None if all trials are on the task's own."""
    disturbances: dict[str, Any] | None = None
    """The disturbances; None if the objective is C of Eq. (10)."""
    worlds: int | None = None
    """Number of disturbed worlds; None without disturbances."""
    quantile: float | None = None
    """The quantile of the objective that is minimised; None for its mean."""


class Crossings(OpenRecord):
    """Numbers of edges that pass through triangles."""

    final: int
    """Number at the end."""
    most: int
    """Number in the worst frame."""

    @classmethod
    def of(cls, rollout: Rollout) -> Self:
        """Count the crossings of a rollout."""
        counts = crossings_over_time(rollout.positions, rollout.faces)
        return cls(final=int(counts[-1]), most=int(counts.max()))


class ResultRecord(StudyRecord):
    """The file `result.json`: a study and its trials."""

    UNSAID: ClassVar[frozenset[str]] = StudyRecord.UNSAID | {"until_gain", "bounds", "judged"}

    version: Literal[1] = 1
    tatamu: str = ""
    """The version that wrote it."""
    until_gain: float | None = None
    """Expected gain below which the search ended, as a fraction of the best objective; None for a fixed number of
    trials."""
    bounds: dict[str, list[float]] = Field(default_factory=dict)
    """Lowest and highest value of each parameter of the search; empty in files of older versions."""
    judged: SuccessRate | None = None
    """Success of the best fold in worlds in which it was not learned; None without disturbances."""
    asked: TaskOptions | None = None
    """Names and files of the task as given by the user; None if it was made from objects."""
    wall_seconds: float | None = None
    """Sum of the trials' seconds [s]."""
    best: Index | None
    """Number of the complete trial of lowest objective on the fine mesh; None if all failed."""
    crossings: Crossings | None = None
    """Crossings of the best trial; None if all failed."""
    trials: Annotated[list[Trial], Field(min_length=1)]
    baselines: list[Baseline] = Field(default_factory=list)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.best is not None and len(self._complete()) != 1:
            raise ValueError(f"best must be the number of one complete trial, given {self.best}")
        return self

    def _complete(self) -> list[Trial]:
        return [trial for trial in self.trials if trial.number == self.best and trial.state == "complete"]

    def is_coarse(self, trial: Trial) -> bool:
        """Return whether a trial ran on the coarser mesh."""
        return self.coarse is not None and trial.spacing == self.coarse

    @property
    def lowest_objective(self) -> Trial | None:
        """The complete trial of lowest C on the fine mesh, the paper's best; None if all failed there."""
        here = [trial for trial in self.trials if trial.state == "complete" and not self.is_coarse(trial)]
        return min(here, key=lambda trial: (trial.objective or 0.0, trial.number), default=None)

    @property
    def best_trial(self) -> Trial:
        """The complete trial of lowest objective.

        Raises:
            ValueError: If all trials failed.
        """
        if self.best is None:
            raise ValueError("all trials failed: there is no best one")
        return self._complete()[0]

    @property
    def best_is_given(self) -> bool:
        """Whether the best trial is one of the first parameters, which the search was given."""
        return any(self.best_trial.parameters == each for each in self.first)

    @property
    def best_given(self) -> Trial | None:
        """The best given first trial on the fine mesh; None if none is complete there."""
        given = [trial for trial in self.trials if trial.state == "complete" and trial.parameters in self.first]
        here = [trial for trial in given if not self.is_coarse(trial)]
        return min(here, key=lambda trial: (trial.minimised, trial.number), default=None)

    @property
    def best_score(self) -> Score:
        """The measures of the best trial.

        Raises:
            ValueError: If all trials failed.
        """
        score = self.best_trial.score
        assert score is not None, "the best trial is complete"
        return score
