"""A task: one fold in one simulator; parameters in, score out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any

import numpy as np

from tatamu.errors import SimulationError
from tatamu.folding.fold import Fold, fold_of, ideal_folds
from tatamu.folding.manipulation import Manipulation, bezier_manipulation, described, scene_of
from tatamu.folding.plan import Plan
from tatamu.folding.plans import make_plan
from tatamu.folding.score import ALPHA, Score, score, shape_distance, vertex_distances
from tatamu.garments import Garment, make_garment
from tatamu.material import Material
from tatamu.rollout import Rollout
from tatamu.simulators import named, simulate

TABLE_MARGIN = 0.5
"""The table reaches this far beyond where the cloth lay [m]; a trial whose cloth ends farther out has left it."""


@dataclass(frozen=True)
class Outcome:
    """What came of a manipulation."""

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


@dataclass(frozen=True)
class Reach:
    """What a robot can reach."""

    robot: str
    """Its name."""
    description: bytes = field(default=b"", kw_only=True)
    """The file that describes it; empty for one that tatamu knows."""
    quality: Callable[[dict[str, Any]], float]
    """From what manipulation.json would hold to how well the robot does it: negative where it cannot."""
    refusal: Callable[[dict[str, Any]], str | None] = lambda _: None
    """From the same to why the robot cannot do it, None where it can; asking changes no later answer of `quality`."""


@dataclass(frozen=True)
class Task:
    """Fold this garment in this way, in this simulator."""

    fold: Fold
    fold_name: str
    simulator: str
    step: tuple[int, int] = (1, 1)
    """Which step of how many the fold is."""
    title: str = ""
    """In a few words what is folded."""
    reach: Reach | None = None
    """Manipulations beyond it fail without being simulated."""
    asked: dict[str, Any] = field(default_factory=dict)
    """What the job was made from: garment and fold as they were named; size, spacing and hands where given."""

    def describe(self) -> dict[str, Any]:
        """The task as `result.json` holds it; two tasks are the same when these are."""
        garment, fold = self.fold.garment, self.fold
        corner = int(fold.left[0])
        return {
            "garment": garment.name,
            "size": list(garment.size),
            "fold": self.fold_name,
            "material": garment.material.model_dump(),
            "spacing": garment.spacing,
            "vertices": len(garment.vertices),
            "simulator": self.simulator,
            "fold_line": fold.line.tolist(),
            "translation": fold.translation(corner).tolist(),
            "candidates": fold.candidates,
            **({"hands": 1} if fold.hands == 1 else {}),
            **({"robot": self.reach.robot} if self.reach else {}),
            **({"step": list(self.step), "start": digest(fold.start)} if self.step[1] > 1 else {}),
            "digest": self._digest(),
        }

    def _digest(self) -> str:
        """Of what else makes a task: the mesh to the micrometre, grasps, the ratio of areas, the robot's file."""
        fold, ratio = self.fold, self.fold.area_ratio or 0.0
        robot = self.reach.description if self.reach else b""
        return digest(fold.start.round(6) + 0.0, fold.garment.faces, fold.left, fold.right, np.array([ratio, *robot]))

    def manipulation(self, parameters: dict[str, float]) -> Manipulation:
        """The manipulation of x = (x1, z1, x2, z2, g1, g2), Eq. (9); continuous grasps are floored."""
        g1, g2 = (min(int(parameters[name]), self.fold.candidates - 1) for name in ("g1", "g2"))
        grasps = (int(self.fold.left[g1]), int(self.fold.right[g2]))[: self.fold.hands]
        return bezier_manipulation(self.fold, grasps, *(parameters[name] for name in ("x1", "z1", "x2", "z2")))

    def evaluate(self, manipulation: Manipulation) -> Outcome:
        """Simulate and score; what goes wrong in the simulation is an outcome, not an exception."""
        way = manipulation.trajectory_length
        short = self.out_of_reach(manipulation)
        if short > 0.0 and self.reach:
            return Outcome(None, self.penalty(way) + short, f"out of reach of {self.reach.robot}", None)
        try:
            rollout = simulate(scene_of(self.fold, manipulation), self.simulator)
        except SimulationError as error:
            return Outcome(None, self.penalty(way), str(error), None)
        outcome = rollout.positions[-1]
        if self._left_table(outcome):
            return Outcome(None, self.penalty(way), "the cloth left the table", rollout)
        reached = score(self.fold, way, outcome)
        return Outcome(reached, reached.objective, None, rollout)

    def out_of_reach(self, manipulation: Manipulation) -> float:
        """By how much the robot fails to do it; 0 where it can, and for polylines, which are there to compare with."""
        if self.reach is None or manipulation.control_points is None:
            return 0.0
        return max(0.0, -self.reach.quality(described(self.fold, manipulation)))

    def penalty(self, trajectory_length: float) -> float:
        """Objective of a failed trial: twice as far from the target as a cloth that nobody touched."""
        untouched = shape_distance(vertex_distances(self.fold.target, self.fold.start))
        return trajectory_length + 2.0 * ALPHA * untouched

    def _left_table(self, positions: np.ndarray) -> bool:
        flat = self.fold.start[:, :2]
        low, high = flat.min(0) - TABLE_MARGIN, flat.max(0) + TABLE_MARGIN
        return bool((positions[:, :2] < low).any() or (positions[:, :2] > high).any())


@dataclass(frozen=True)
class Job:
    """Fold this garment by this plan, in this simulator."""

    garment: Garment
    plan: Plan
    simulator: str
    hands: int | None = None
    """How many hands fold; None: as the plan says."""
    reach: Reach | None = None
    """What the robot that shall do it can reach; None: no robot is asked."""
    asked: dict[str, Any] = field(default_factory=dict)
    """What it was made from: garment and fold as they were named; size, spacing and hands where given."""

    def task(self, number: int, state: np.ndarray | None = None) -> Task:
        """The task of a step, the first being 0, of the cloth as it lies [m], shape (n, 3); None: flat."""
        step = self.plan.steps[number]
        fold = fold_of(self.garment, self.plan, step, state, self.hands)
        steps = number + 1, len(self.plan.steps)
        return Task(fold, self.plan.name, self.simulator, steps, step.title, self.reach, self.asked)


def make_job(
    garment: str,
    *,
    size: tuple[float, float] | None = None,
    fold: str = "half",
    material: Material | None = None,
    spacing: float | None = None,
    scale: float | None = None,
    simulator: str = "native",
    hands: int | None = None,
    reach: Reach | None = None,
) -> Job:
    """The job of folding a named garment by a named plan.

    Raises:
        InputError: One of the names is unknown, or the garment cannot be made or folded so.
    """
    named(simulator)
    made = make_garment(garment, size, material, spacing, scale)
    asked = {"garment": garment, "fold": fold, "size": size and list(size), "spacing": spacing, "hands": hands}
    asked |= {} if scale is None else {"scale": scale}
    job = Job(made, make_plan(fold, made), simulator, hands, reach, asked)
    ideal_folds(made, job.plan, hands)  # refuse now what a later step could not fold
    return job


def make_task(garment: str, **options: Any) -> Task:
    """The first task of a job; arguments and errors as `make_job` has them."""
    return make_job(garment, **options).task(0)


def digest(*arrays: np.ndarray) -> str:
    """A short name of arrays of numbers that differs when a bit of them does."""
    return sha256(b"".join(np.ascontiguousarray(array, dtype="<f8").tobytes() for array in arrays)).hexdigest()[:16]
