"""A task: one fold in one simulator; parameters in, score out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from tatamu.errors import InputError, SimulationError
from tatamu.folding.fingers import Fingers
from tatamu.folding.fold import Fold, fold_of, ideal_folds
from tatamu.folding.interpolation import interpolated
from tatamu.folding.manipulation import Manipulation, bezier_manipulation, scene_of
from tatamu.folding.plan import Plan
from tatamu.folding.plans import make_plan
from tatamu.folding.score import ALPHA, Score, score, shape_distance, vertex_distances
from tatamu.garments import Garment, make_garment
from tatamu.material import Material, load_material
from tatamu.records import OpenRecord
from tatamu.rollout import Rollout
from tatamu.scene import Scene
from tatamu.simulators import named, simulate

TABLE_MARGIN = 0.5
"""The table reaches this far beyond where the cloth lay [m]; a trial whose cloth ends farther out has left it."""
STEPS_ON_COARSER_MESH = 2
"""Steps of a plan that a search may begin on a coarser mesh. Of many layers, from the third on, that says little about
the finer one, and takes most of its time; their trials end early instead (docs/notes/learning.md)."""


@dataclass(frozen=True)
class Outcome:
    """The result of simulating and scoring a manipulation."""

    score: Score | None
    """None when the trial failed."""
    objective: float
    """C, or a finite penalty when the trial failed."""
    error: str | None
    """Why it failed."""
    rollout: Rollout | None
    """The motion; None when the simulator gave up."""

    @property
    def failed(self) -> bool:
        """Whether this trial counts as failed."""
        return self.score is None


def _none(manipulation: Manipulation) -> None:
    """No refusal; a lambda could not be pickled."""


def _nothing() -> None:
    """Nothing to forget."""


@dataclass(frozen=True)
class Reach:
    """The manipulations that a robot can do."""

    robot: str
    """Its name."""
    description: bytes = field(default=b"", kw_only=True)
    """The file that describes it; empty for a robot that comes with tatamu."""
    files: tuple[Path, ...] = field(default=(), kw_only=True)
    """That file and those that it names."""
    quality: Callable[[Manipulation], float]
    """How well the robot does a manipulation on Bezier curves: negative where it cannot."""
    refusal: Callable[[Manipulation], str | None] = _none
    """Why the robot cannot do a manipulation, None where it can; asking changes no later answer of `quality`."""
    forget: Callable[[], None] = _nothing
    """Forget what `quality` learned from what it was asked: a search begins afresh."""


class Asked(OpenRecord):
    """The garment and the fold as the user named them, and the options that the user gave."""

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
    material: str | None = None
    """Name or file of the cloth's material; None: the garment's own."""
    robot: str | None = None
    """Name or file of the robot within whose reach it is folded; None: no robot is asked."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"scale", "material", "robot"})

    @property
    def size_pair(self) -> tuple[float, float] | None:
        """Width and length [m]; None: the garment's own."""
        return None if self.size is None else (self.size[0], self.size[1])


@dataclass(frozen=True)
class Task:
    """One fold of one garment, in one simulator."""

    fold: Fold
    fold_name: str
    simulator: str
    step: tuple[int, int] = (1, 1)
    """Number of the fold among the steps of its plan, and how many steps there are."""
    title: str = ""
    """The fold in a few words."""
    reach: Reach | None = None
    """Manipulations beyond it are `refused`, and need no simulation."""
    asked: Asked | None = None
    """The names and options that the task was made from; None: made by hand."""
    coarser: Task | None = None
    """The same fold on a coarser mesh, where a search may begin; None: there is none."""
    ends_early: bool = False
    """Whether a trial may end when its hands have arrived, where it can no longer win; a search on one mesh asks."""

    @property
    def bare(self) -> Task:
        """The task without what a simulation has no use for: what its robot can do, its coarser mesh."""
        return replace(self, reach=None, coarser=None)

    def manipulation(self, parameters: dict[str, float]) -> Manipulation:
        """The manipulation of x = (x1, z1, x2, z2, g1, g2), Eq. (9); continuous grasps are floored."""
        g1, g2 = (min(int(parameters[name]), self.fold.candidates - 1) for name in ("g1", "g2"))
        grasps = (int(self.fold.left[g1]), int(self.fold.right[g2]))[: self.fold.hands]
        return bezier_manipulation(self.fold, grasps, *(parameters[name] for name in ("x1", "z1", "x2", "z2")))

    def evaluate(self, manipulation: Manipulation) -> Outcome:
        """Simulate and score; what goes wrong in the simulation is an outcome, not an exception."""
        length = manipulation.trajectory_length
        return self.outcome(scene_of(self.fold, manipulation), length)

    def evaluate_on_arrival(self, manipulation: Manipulation) -> Outcome:
        """Simulate until the hands have arrived, before they open, and score the cloth as it then lies."""
        scene = scene_of(self.fold, manipulation)
        until = scene.model_copy(update={"duration": manipulation.timing.arrives})
        return self.outcome(until, manipulation.trajectory_length)

    def outcome(self, scene: Scene, trajectory_length: float) -> Outcome:
        """Simulate and score a scene of this fold; what goes wrong in the simulation is no exception.

        Args:
            scene: The scene.
            trajectory_length: l_x of the manipulation that it is of [m].
        """
        try:
            rollout = simulate(scene, self.simulator)
        except SimulationError as error:
            return Outcome(None, self.penalty(trajectory_length), str(error), None)
        final = rollout.positions[-1]
        if self._left_table(final):
            return Outcome(None, self.penalty(trajectory_length), "the cloth left the table", rollout)
        reached = score(self.fold, trajectory_length, final)
        return Outcome(reached, reached.objective, None, rollout)

    def refused(self, manipulation: Manipulation) -> Outcome | None:
        """The outcome of what the robot cannot do; None where it can, and for polylines, which only compare."""
        if self.reach is None or manipulation.control_points is None:
            return None
        short = -self.reach.quality(manipulation)
        if short <= 0.0:
            return None
        penalty = self.penalty(manipulation.trajectory_length) + short
        return Outcome(None, penalty, f"out of reach of {self.reach.robot}", None)

    def penalty(self, trajectory_length: float) -> float:
        """Objective of a failed trial: twice as far from the target as a cloth that nobody touched."""
        untouched = shape_distance(vertex_distances(self.fold.target, self.fold.start))
        return trajectory_length + 2.0 * ALPHA * untouched

    def _left_table(self, positions: np.ndarray) -> bool:
        flat = self.fold.start[:, :2]
        low = flat.min(0) - TABLE_MARGIN
        high = flat.max(0) + TABLE_MARGIN
        return bool((positions[:, :2] < low).any() or (positions[:, :2] > high).any())


@dataclass(frozen=True)
class Job:
    """One garment folded by one plan, in one simulator."""

    garment: Garment
    plan: Plan
    simulator: str
    hands: int | None = None
    """How many hands fold; None: as the plan says."""
    reach: Reach | None = None
    """The manipulations that the robot of the job can do; None: no robot is asked."""
    asked: Asked | None = None
    """The names and options that the job was made from; None: made by hand."""
    fingers: Fingers = field(default_factory=Fingers)
    """Of the hands."""
    coarser: Job | None = None
    """The same job on a coarser mesh, where a search may begin; None: there is none."""

    def task(self, number: int, state: np.ndarray | None = None) -> Task:
        """The task of a step.

        Args:
            number: Of the step, the first being 0.
            state: The cloth as it lies [m], shape (n, 3); None: flat.
        """
        step = self.plan.steps[number]
        fold = replace(fold_of(self.garment, self.plan, step, state, self.hands), fingers=self.fingers)
        place = (number + 1, len(self.plan.steps))
        coarser = self._coarser_task(number, state)
        ends_early = self.coarser is not None and number >= STEPS_ON_COARSER_MESH
        return Task(
            fold, self.plan.name, self.simulator, place, step.title, self.reach, self.asked, coarser, ends_early
        )

    def _coarser_task(self, number: int, state: np.ndarray | None) -> Task | None:
        """The same step on the coarser mesh; None where there is none, and where that would not help."""
        if self.coarser is None or number >= STEPS_ON_COARSER_MESH:
            return None
        coarse = None if state is None else interpolated(self.garment, state, self.coarser.garment)
        try:
            return self.coarser.task(number, coarse)
        except InputError:
            return None


def make_job(
    garment: str,
    *,
    size: tuple[float, float] | None = None,
    fold: str = "half",
    material: Material | Path | None = None,
    spacing: float | None = None,
    scale: float | None = None,
    simulator: str = "native",
    hands: int | None = None,
    reach: Reach | None = None,
    fingers: Fingers | None = None,
) -> Job:
    """The job of folding a named garment by a named plan.

    Args:
        garment: Name of a garment, or its file.
        size: Width and length [m]; None: the garment's own.
        fold: Name of a fold plan, or its file.
        material: Of the cloth, or its file or preset; None: the garment's own.
        spacing: Distance between vertices [m]; None: the garment's own.
        scale: Metres per unit of the garment's file; None: as the file says.
        simulator: Name of the simulator.
        hands: How many hands fold; None: as the plan says.
        reach: The manipulations that the robot of the job can do; None: no robot is asked.
        fingers: Of the hands; None: without thickness.

    Raises:
        InputError: One of the names is unknown, or the garment cannot be made or folded so.
    """
    named(simulator)
    given = load_material(material) if isinstance(material, Path) else material
    made = make_garment(garment, size, given, spacing, scale)
    sides = list(size) if size else None
    asked = Asked(
        garment=garment,
        fold=fold,
        size=sides,
        spacing=spacing,
        scale=scale,
        hands=hands,
        material=str(material) if isinstance(material, Path) else None,
        robot=str(reach.files[0]) if reach and reach.files else None,
    )
    job = Job(made, make_plan(fold, made), simulator, hands, reach, asked, fingers or Fingers())
    ideal_folds(made, job.plan, hands)  # refuse now what a later step could not fold
    return job


def make_task(garment: str, **options: Any) -> Task:
    """The first task of a job; arguments and errors are those of `make_job`."""
    return make_job(garment, **options).task(0)


def digest(*arrays: np.ndarray) -> str:
    """A short name of arrays of numbers that differs when a bit of them does."""
    return sha256(b"".join(np.ascontiguousarray(array, dtype="<f8").tobytes() for array in arrays)).hexdigest()[:16]
