"""The file `result.json`: the task, the search and the trials. See docs/reference/result-folder.md."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from tatamu.base.records import OpenRecord
from tatamu.evaluation.success import Success
from tatamu.folding.aim import Aim
from tatamu.folding.fingers import Fingers
from tatamu.folding.parameters import Grasps
from tatamu.folding.score import Score
from tatamu.folding.shift import HandShift
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
    size: list[float]
    """Width and length of the garment [m]."""
    fold: str
    """Name of the fold plan."""
    material: Material
    spacing: float
    """Distance between neighbouring vertices of the mesh [m]."""
    vertices: int
    """Number of vertices of the mesh."""
    simulator: str


class TaskDescription(OpenRecord):
    """The task of a study. Two tasks are equal if their descriptions are equal."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"hands", "robot", "step", "start", "fingers", "shift"})

    garment: str
    size: list[float] | None = None
    """Width and length of the garment [m]."""
    fold: str
    material: Material
    spacing: float | None = None
    """Distance between neighbouring vertices of the mesh [m]."""
    vertices: int | None = None
    """Number of vertices of the mesh."""
    simulator: str
    fold_line: list[list[float]] | None = None
    """Two points of the fold line [m], shape (2, 2)."""
    translation: Annotated[list[float], Field(min_length=3, max_length=3)] | None = None
    """Displacement of the hands from grasp to release [m]."""
    candidates: int | None = None
    """Number M of vertices that each hand may grasp (grasp candidates)."""
    hands: int = 2
    """Number of hands that fold."""
    fingers: Fingers | None = None
    """The fingers of the hands; None for hands without fingers."""
    robot: str | None = None
    """Name of the robot that must be able to execute the fold; None if any manipulation is allowed."""
    step: tuple[int, int] | None = None
    """Number of the step, from 1, and number of steps in the plan; None if the plan has only one step."""
    start: str | None = None
    """Digest of the state from which a step of a plan starts; None if the plan has only one step."""
    shift: list[HandShift] | None = None
    """Shifts of each hand's grasp, release and height that correct the manipulation, left before right.

    None if the manipulation is not corrected.
    """
    digest: str | None = None
    """Digest of the properties of the task that have no field of their own.

    They are the mesh, the grasp candidates, the ratio of the cloth's areas after and before the fold, and the file of
    the robot.
    """


def describe_plan(task: Task) -> PlanDescription:
    """Return the description of the garment and the plan for `result.json`."""
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
    """Return the description of the task for `result.json`."""
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
    """Return a digest of the properties of a task that have no field of their own in its description.

    They are the mesh to the micrometre, the grasp candidates, the file of the robot, and the ratio of the cloth's areas
    after and before the fold.
    """
    fold = task.fold
    ratio = fold.area_ratio or 0.0
    robot = task.reach.description if task.reach else b""
    return digest(fold.start.round(6) + 0.0, fold.garment.faces, fold.left, fold.right, np.array([ratio, *robot]))


class SharedStudyRecord(OpenRecord):
    """The file `study.json`, which states the database and the name under which the study of a folder is stored."""

    version: Literal[1]
    storage: str
    """Address of the database, `postgresql://USER@HOST/DB`. It never contains a password."""
    name: str
    """Name of the study in the database."""


class StudyRecord(OpenRecord):
    """The task of a study and the settings of its search. A study is resumed only if they are unchanged."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"parallel", "first", "disturbances", "level", "aim"})

    task: TaskDescription
    sampler: str
    """Name of the search, such as "gp"."""
    grasps: Grasps = "integer"
    seed: int
    parallel: int = 1
    """How many trials may be pending at the same time."""
    first: list[Parameters] = Field(default_factory=list)
    """Parameters of the initial curves, which were given to the search."""
    disturbances: dict[str, Any] | None = None
    """The disturbances; None if there are none, and the objective is C of Eq. (10)."""
    level: float | None = None
    """Size of the disturbances in the scenarios, in their deviations; None without disturbances."""
    aim: Aim | None = None
    """Room that the hands leave for errors; None for none."""


class Crossings(OpenRecord):
    """Numbers of crossings in a rollout: edges of the cloth that pass through triangles of the cloth."""

    final: int
    """Number of crossings in the last frame."""
    most: int
    """Number of crossings in the frame with the most crossings."""

    @classmethod
    def of(cls, rollout: Rollout) -> Self:
        """Count the crossings of a rollout."""
        counts = crossings_over_time(rollout.positions, rollout.faces)
        return cls(final=int(counts[-1]), most=int(counts.max()))


class ResultRecord(StudyRecord):
    """The file `result.json`: a study and its trials."""

    UNSAID: ClassVar[frozenset[str]] = StudyRecord.UNSAID | {"until_gain", "bounds", "success", "request"}

    version: Literal[1] = 1
    tatamu: str = ""
    """Version of tatamu that wrote the file."""
    request: TaskRequest | None = None
    """The options of `tatamu learn` that give this study; None in files of earlier versions."""
    until_gain: float | None = None
    """Expected gain below which the search ends, as a fraction of the best objective; None for a number of trials."""
    bounds: dict[str, list[float]] = Field(default_factory=dict)
    """Lowest and highest value of each parameter; empty in files of earlier versions."""
    success: Success | None = None
    """How often the best fold succeeds in scenarios that were not used to learn it; None without disturbances."""
    asked: TaskOptions | None = None
    """Names and files of the task as the user gave them; None if the task was made from Python objects."""
    wall_seconds: float | None = None
    """Sum of the wall time of all trials [s]."""
    best: Index | None
    """Index of the complete trial with the lowest value; None if all trials failed."""
    crossings: Crossings | None = None
    """Crossings of the cloth with itself in the best trial; None if all trials failed."""
    trials: Annotated[list[Trial], Field(min_length=1)]
    baselines: list[Baseline] = Field(default_factory=list)

    @model_validator(mode="before")
    @classmethod
    def _read_former(cls, given: Any) -> Any:
        """Read the name of version 0.2."""
        former = isinstance(given, dict) and "success" not in given and "judged" in given
        return {**given, "success": given["judged"]} if former else given

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.best is not None and len(self._complete()) != 1:
            raise ValueError(f"best must be the number of one complete trial, given {self.best}")
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
            raise ValueError("all trials failed: there is no best one")
        return self._complete()[0]

    @property
    def best_is_initial(self) -> bool:
        """Whether the best trial is one of the initial curves."""
        return any(self.best_trial.parameters == each for each in self.first)

    @property
    def best_initial(self) -> Trial | None:
        """The best of the initial curves; None if none is complete."""
        initial = [trial for trial in self.trials if trial.state == "complete" and trial.parameters in self.first]
        return min(initial, key=lambda trial: (trial.minimised, trial.number), default=None)

    @property
    def best_score(self) -> Score:
        """The measures of the best trial.

        Raises:
            ValueError: If all trials failed.
        """
        score = self.best_trial.score
        assert score is not None, "the best trial is complete"
        return score


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
