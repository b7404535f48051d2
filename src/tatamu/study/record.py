"""The file `result.json`: the task, the search and the trials. See docs/reference/result-folder.md."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.base.records import OpenRecord
from tatamu.evaluation.success import Success
from tatamu.folding.aim import Aim
from tatamu.folding.fingers import Fingers
from tatamu.folding.manipulation import HandShift
from tatamu.folding.parameters import Grasps
from tatamu.folding.score import Score
from tatamu.folding.task import Task, TaskOptions, digest
from tatamu.search import Parameters
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.crossings import crossings_over_time
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Index
from tatamu.study.options import TaskRequest
from tatamu.study.trial import Baseline, Scored, Trial


class PlanDescription(OpenRecord):
    """The garment and the plan that folds it."""

    garment: str
    size: list[float] | None = None
    """Width and length of the garment [m]."""
    fold: str
    material: Material
    spacing: float | None = None
    """Distance between neighbouring vertices of the mesh [m]."""
    vertices: int | None = None
    simulator: str


class TaskDescription(PlanDescription):
    """The task of a study. Two tasks are equal if their descriptions are equal."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"hands", "robot", "step", "start", "fingers", "shift"})

    fold_line: list[list[float]] | None = None
    """Two points [m], shape (2, 2)."""
    translation: Annotated[list[float], Field(min_length=3, max_length=3)] | None = None
    """Displacement of the hands from grasp to release [m]."""
    candidates: int | None = None
    """Number M of vertices that each hand may grasp."""
    hands: int = 2
    fingers: Fingers | None = None
    """None for hands without fingers."""
    robot: str | None = None
    """None if any manipulation is allowed."""
    step: tuple[int, int] | None = None
    """Number of the step, from 1, and number of steps; None if the plan has only one."""
    start: str | None = None
    """Digest of the state from which a step starts; None if the plan has only one."""
    shift: list[HandShift] | None = None
    """Correction of each hand's path, left before right."""
    digest: str | None = None
    """Digest of what has no field of its own: see `_digest`."""


def describe_plan(task: Task) -> PlanDescription:
    """Return the garment and the plan of a task."""
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
    """Return what makes two tasks equal."""
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
    """Return a digest of the mesh to the micrometre, the grasp candidates, the areas' ratio and the robot's file."""
    fold = task.fold
    others = np.array([fold.area_ratio or 0.0, *(task.reach.description if task.reach else b"")])
    return digest(fold.start.round(6) + 0.0, fold.garment.faces, fold.left, fold.right, others)


class SharedStudyRecord(OpenRecord):
    """The file `study.json`: where a shared database has the study of a folder."""

    version: Literal[1]
    storage: str
    """`postgresql://USER@HOST/DB`, never with a password."""
    name: str


class StudyRecord(OpenRecord):
    """The task of a study and the settings of its search. A study is resumed only if they are unchanged."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"parallel", "first", "disturbances", "level", "aim"})

    task: TaskDescription
    sampler: str
    grasps: Grasps = "integer"
    seed: int
    parallel: int = 1
    """How many trials may be pending at a time."""
    first: list[Parameters] = Field(default_factory=list)
    """Initial curves."""
    disturbances: dict[str, Any] | None = None
    """None if there are none, and the objective is C of Eq. (10)."""
    level: float | None = None
    """Size of the disturbances in the scenarios, in their deviations."""
    aim: Aim | None = None


class Crossings(OpenRecord):
    """How many edges of the cloth pass through triangles of the cloth in a rollout."""

    final: int
    """In the last frame."""
    most: int
    """In the frame with the most."""

    @classmethod
    def of(cls, rollout: Rollout) -> Self:
        counts = crossings_over_time(rollout.positions, rollout.faces)
        return cls(final=int(counts[-1]), most=int(counts.max()))


class ResultRecord(StudyRecord):
    """The file `result.json`: a study and its trials."""

    UNSAID: ClassVar[frozenset[str]] = StudyRecord.UNSAID | {"until_gain", "bounds", "success", "request"}
    FORMER: ClassVar[Mapping[str, str]] = {"judged": "success"}

    version: Literal[1] = 1
    tatamu: str = ""
    """Version that wrote the file."""
    request: TaskRequest | None = None
    """The options of `tatamu learn` that give this study; None in files of earlier versions."""
    until_gain: float | None = None
    """Expected gain below which the search ends, as a fraction of the best objective; None for a number of trials."""
    bounds: dict[str, list[float]] = Field(default_factory=dict)
    """Minimum and maximum of each parameter; empty in files of earlier versions."""
    success: Success | None = None
    """How often the best fold succeeds in scenarios that were not used to learn it; None without disturbances."""
    asked: TaskOptions | None = None
    """Names and files of the task as the user gave them; None if the task was made from Python objects."""
    wall_seconds: float | None = None
    """Sum of the wall time of all trials [s]."""
    best: Index | None
    """Index of the complete trial with the lowest value; None if all trials failed."""
    crossings: Crossings | None = None
    """Those of the best trial; None if all trials failed."""
    trials: Annotated[list[Trial], Field(min_length=1)]
    baselines: list[Baseline] = Field(default_factory=list)

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.best is not None and len(self._complete()) != 1:
            raise ValueError(f"best must be the number of a complete trial, given {self.best}")
        return self

    def _complete(self) -> list[Trial]:
        return [trial for trial in self.trials if trial.number == self.best and trial.state == "complete"]

    @property
    def minimum_objective(self) -> Trial | None:
        """The complete trial with the lowest C of Eq. (10), which the paper counts as the best; None if all failed."""
        complete = [trial for trial in self.trials if trial.state == "complete"]
        return min(complete, key=lambda trial: (trial.objective or 0.0, trial.number), default=None)

    @property
    def best_trial(self) -> Trial:
        """The complete trial with the lowest value.

        Raises:
            ValueError: If all trials failed.
        """
        if self.best is None:
            raise ValueError("all trials failed, so there is no best trial")
        return self._complete()[0]

    @property
    def best_is_initial(self) -> bool:
        return any(self.best_trial.parameters == each for each in self.first)

    @property
    def best_initial(self) -> Trial | None:
        """The best of the initial curves; None if none is complete."""
        initial = [trial for trial in self.trials if trial.state == "complete" and trial.parameters in self.first]
        return min(initial, key=lambda trial: (trial.minimised, trial.number), default=None)

    @property
    def best_score(self) -> Score:
        score = self.best_trial.score
        assert score is not None, "the best trial is complete"
        return score


class FromFlat(OpenRecord):
    """Deviation of a folded garment from its ideal shape, which perfect folds in all steps so far would give."""

    mean_vertex_distance: float
    """Mean distance of the vertices from their ideal positions [m]."""
    mask_iou: float
    """Intersection over union with the ideal, seen from above [-]."""
    area_error: float
    """Difference of the covered area from the ideal's, relative to the latter [%]."""

    @property
    def moving_vertex_distance(self) -> None:
        """Return None: only a single fold has a moving part, while the folds of a plan move nearly all cloth."""
        return None


class StepRecord(Scored):
    """One step of a plan: the measures of its own fold, and the deviation of the garment after all folds so far."""

    folder: Annotated[str, Field(pattern=r"^step-[1-9][0-9]{0,3}$")]
    title: str
    hands: int
    trials: int
    """How many trials were made."""
    best: Index
    """Number of the best trial."""
    crossings: Crossings
    whole: FromFlat


class PlanRecord(OpenRecord):
    """A plan whose steps are learned."""

    version: Literal[1] = 1
    tatamu: str = ""
    """Version that wrote the file."""
    plan: PlanDescription
    sampler: str
    grasps: str
    seed: int
    wall_seconds: float
    """Sum of the wall time of all steps [s]."""
    steps: Annotated[list[StepRecord], Field(min_length=1)]
    final: FromFlat
    """Deviation from the ideal after the last step."""
