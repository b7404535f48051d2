"""How a fold ends in a world, whether it holds there, and in what share of worlds it does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from scipy.stats import binomtest

from tatamu.disturbances.disturbed import disturbed_scene
from tatamu.disturbances.world import World
from tatamu.errors import SimulationError
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.score import Score
from tatamu.folding.task import Outcome, Task

CONFIDENCE = 0.95
"""Of the interval of a share."""


@dataclass(frozen=True)
class Limits:
    """The measures that a fold must keep in order to hold."""

    mean_vertex_distance: float = 0.0125
    """Greatest mean of e_i [m] (BiFold 2025)."""
    mask_iou: float = 0.80
    """Least overlap of the views from above (FoldBack 2026)."""


@dataclass(frozen=True)
class Verdict:
    """How a fold ended in one world."""

    mean_vertex_distance: float | None
    """[m]; None where the simulation failed."""
    mask_iou: float | None
    """None where the simulation failed."""
    error: str | None = None
    """Why it failed."""

    @classmethod
    def of(cls, score: Score | None, error: str | None = None) -> Verdict:
        """The verdict on a fold of that score; None: its simulation failed."""
        if score is None:
            return cls(None, None, error)
        return cls(score.mean_vertex_distance, score.mask_iou)

    def holds(self, limits: Limits) -> bool:
        """Whether the fold holds; one that could not be simulated does not."""
        if self.mean_vertex_distance is None or self.mask_iou is None:
            return False
        near = self.mean_vertex_distance <= limits.mean_vertex_distance
        return near and self.mask_iou >= limits.mask_iou

    def slack(self, limits: Limits) -> float:
        """How far the fold is from failing, as a part of its limits: from 1, without any error, to -1, twice beyond.

        Negative where it does not hold.
        """
        if self.mean_vertex_distance is None or self.mask_iou is None:
            return -1.0
        near = 1.0 - self.mean_vertex_distance / limits.mean_vertex_distance
        room = max(1.0 - limits.mask_iou, 1e-9)
        return max(-1.0, min(near, (self.mask_iou - limits.mask_iou) / room))

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


def outcome_in(task: Task, manipulation: Manipulation, world: World) -> Outcome:
    """Simulate and score a manipulation in a world; what goes wrong is an outcome, not an exception."""
    length = manipulation.trajectory_length
    try:
        scene = disturbed_scene(task.fold, manipulation, world)
    except SimulationError as error:
        return Outcome(None, task.penalty(length), str(error), None)
    return task.outcome(scene, length)


def judge(task: Task, manipulation: Manipulation, world: World) -> Verdict:
    """How a manipulation ends in a world."""
    outcome = outcome_in(task, manipulation, world)
    return Verdict.of(outcome.score, outcome.error)


@dataclass(frozen=True)
class Share:
    """In how many of some worlds a fold holds."""

    draws: int
    held: int

    @property
    def share(self) -> float:
        """The share that was found [-]."""
        return self.held / self.draws

    @property
    def interval(self) -> tuple[float, float]:
        """The interval of Clopper and Pearson (1934), which holds the true share at least 95 times in 100."""
        found = binomtest(self.held, self.draws).proportion_ci(CONFIDENCE, method="exact")
        return float(found.low), float(found.high)


def share_of(verdicts: Sequence[Verdict], limits: Limits) -> Share:
    """In how many worlds a fold holds."""
    return Share(len(verdicts), sum(verdict.holds(limits) for verdict in verdicts))
