"""Evaluators rate the fold that parameters produce.

    evaluate = Scenarios(Nominal(task), disturbances)
    evaluate(task.space.middle()).objective

An evaluator of your own wraps another one:

    class Gentle(Wrapper):
        def __call__(self, ask):
            found = self.inner(ask)
            return replace(found, objective=found.objective + 0.1 * found.parameters["z1"])

Evaluators are immutable, can be pickled, and remember nothing: an evaluation depends on the ask alone.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from tatamu.folding.score import Score
from tatamu.folding.task import Task
from tatamu.search import Parameters
from tatamu.simulation.rollout import Rollout


@dataclass(frozen=True)
class Ask:
    """What an evaluator is asked."""

    parameters: Parameters
    """The parameters x1, z1, x2, z2 [m], g1 and g2 of Eq. (9)."""
    scenarios: tuple[int, ...] | None = None
    """Indices of the scenarios to simulate, in this order; None for all."""
    beat: float = np.inf
    """The lowest objective so far. An evaluation that cannot be below it may end early; with infinity, none does."""

    @classmethod
    def of(cls, given: Ask | Mapping[str, int | float]) -> Ask:
        """Return the ask itself, or one for parameters alone."""
        return given if isinstance(given, Ask) else cls(dict(given))


@dataclass(frozen=True)
class Evaluation:
    """How good the fold of an ask is."""

    parameters: Parameters
    trajectory_length: float
    """Trajectory length l_x of Eq. (10) [m]."""
    objective: float
    """The value that a search minimises."""
    nominal: float
    """Objective C of Eq. (10) without disturbances, or a penalty if the simulation failed."""
    score: Score | None
    error: str | None = None
    rollout: Rollout | None = None
    """Motion without disturbances; None if it was dropped to save memory."""
    scenarios: int = 0
    """How many scenarios were simulated."""
    failed_in: tuple[int, ...] = ()
    """Indices of the scenarios that the fold does not pass."""
    seconds: float = 0.0
    """Wall time [s]."""

    @property
    def failed(self) -> bool:
        """Whether the simulation without disturbances failed, so that there is no score."""
        return self.score is None

    def __repr__(self) -> str:
        """Return one line: the objective, the distance, and the scenarios."""
        found = self.error if self.score is None else f"{1e3 * self.score.mean_vertex_distance:.1f} mm from the target"
        tried = f", passes {self.scenarios - len(self.failed_in)} of {self.scenarios} scenarios"
        return f"Evaluation(objective {self.objective:.4f}, {found}{tried if self.scenarios else ''})"


class Evaluator(ABC):
    """Rates the fold that parameters produce."""

    task: Task
    contains_length = False
    """Whether the objective contains l_x of Eq. (10), which a search then need not learn."""
    scenario_count = 0
    """How many scenarios an ask may name."""

    @abstractmethod
    def __call__(self, ask: Ask | Mapping[str, int | float]) -> Evaluation:
        """Evaluate a manipulation. A failed simulation gives an evaluation, too."""

    @abstractmethod
    def on(self, task: Task) -> Self:
        """Return the same evaluator for another task."""

    @property
    def undisturbed(self) -> Evaluator:
        """The same evaluator without scenarios."""
        return self


@dataclass(frozen=True)
class Wrapper(Evaluator):
    """Base of evaluators that change what another evaluator returns."""

    inner: Evaluator

    @property
    def task(self) -> Task:  # type: ignore[override]
        return self.inner.task

    @property
    def scenario_count(self) -> int:  # type: ignore[override]
        return self.inner.scenario_count

    def __call__(self, ask: Ask | Mapping[str, int | float]) -> Evaluation:
        return self.inner(ask)

    def on(self, task: Task) -> Self:
        return replace(self, inner=self.inner.on(task))

    @property
    def undisturbed(self) -> Evaluator:
        return replace(self, inner=self.inner.undisturbed)
