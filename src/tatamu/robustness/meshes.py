"""Decides which verdicts of a coarse mesh are final, and estimates distances on the fine mesh from it.

A world is one random draw of the disturbances; the nominal world has no disturbances. All worlds are simulated on the
coarse mesh. The nominal world and some others are simulated on the fine mesh too: these are the pairs. The slack of a
fold (`Limits.slack`) differs between the two meshes of a pair. If differences as large as those of the pairs could turn
success into failure in another world, or failure into success, the fine mesh could change its verdict. That world is
then simulated on the fine mesh too, and becomes a pair. This is repeated until the coarse verdicts of all other worlds
are final.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256

import numpy as np

from tatamu.disturbances import NOMINAL, disturbed_scene
from tatamu.evaluation import Evaluator
from tatamu.folding.score import Limits
from tatamu.robustness.verdict import Verdict
from tatamu.simulators.source import source_digest

PAIRS = 12
"""Largest number of draws that are always simulated on both meshes, spread evenly from the best to the worst."""
DRAWS_PER_PAIR = 8
"""One draw in this many is simulated on both meshes, if this gives fewer draws than `PAIRS`."""
VERSION = 2
"""Version of the contents of a verdict; verdicts of other versions are not reused."""
FEWEST = 3
"""Least number of pairs, also for the fit of a line."""


DistanceOf = Callable[[Verdict], float | None]
"""Function that returns a mean distance of a verdict [m], or None if the simulation failed."""


def whole_distance(verdict: Verdict) -> float | None:
    """Return the mean distance of all vertices [m]."""
    return verdict.mean_vertex_distance


def moving_distance(verdict: Verdict) -> float | None:
    """Return the mean distance of the part that moves [m]."""
    return verdict.moving_vertex_distance


@dataclass(frozen=True)
class FoldOnMesh:
    """A manipulation, by its parameters, and the evaluator of its mesh."""

    evaluator: Evaluator
    parameters: Mapping[str, int | float]

    @property
    def key(self) -> str:
        """A name of the simulations, which changes with the scene and with the version of the simulator."""
        task = self.evaluator.task
        scene = disturbed_scene(task.fold, task.manipulation(self.parameters), NOMINAL)
        known = f"{VERSION} {task.simulator} {source_digest()} {scene.model_dump_json()}"
        return sha256(known.encode()).hexdigest()[:16]


@dataclass(frozen=True)
class MeshVerdict:
    """The verdict of a world, from the finest mesh that it was simulated on."""

    verdict: Verdict
    coarse: Verdict | None = None
    """The verdict on the coarse mesh; None if it was not simulated there."""
    fine: bool = True
    """Whether `verdict` is from the fine mesh."""

    @property
    def pair(self) -> tuple[Verdict, Verdict] | None:
        """Verdicts on the fine and the coarse mesh; None if the world was simulated on one of them only."""
        return (self.verdict, self.coarse) if self.fine and self.coarse is not None else None


@dataclass(frozen=True)
class SlackRange:
    """The range of differences in slack, that on the fine mesh minus that on the coarse one; see `Limits.slack`."""

    limits: Limits
    low: float = 0.0
    high: float = 0.0

    @staticmethod
    def unbounded(limits: Limits) -> SlackRange:
        """Return the unbounded range: no verdict of the coarse mesh is final."""
        return SlackRange(limits, -np.inf, np.inf)

    def including(self, judged: Iterable[MeshVerdict]) -> SlackRange:
        """Return this range extended by the differences of the pairs among `judged`."""
        pairs = [one.pair for one in judged if one.pair is not None]
        differences = [self.limits.slack(fine) - self.limits.slack(coarse) for fine, coarse in pairs]
        return SlackRange(self.limits, min([self.low, *differences]), max([self.high, *differences]))

    def is_conclusive(self, coarse: Verdict) -> bool:
        """Return whether the verdict of the coarse mesh is final. False if the simulation failed."""
        if coarse.error is not None:
            return False
        slack = self.limits.slack(coarse)
        return (slack + self.low >= 0.0) == (slack + self.high >= 0.0)


def select_pairs(verdicts: Sequence[Verdict], limits: Limits) -> list[int]:
    """Return the numbers of the draws that are simulated on both meshes: evenly from the worst to the best."""
    ranked = sorted(range(len(verdicts)), key=lambda number: (limits.slack(verdicts[number]), number))
    count = min(PAIRS, max(FEWEST, len(ranked) // DRAWS_PER_PAIR), len(ranked))
    places = np.linspace(0, len(ranked) - 1, count).round().astype(int)
    return sorted(ranked[place] for place in places)


def fit_distances(
    judged: Sequence[MeshVerdict], limits: Limits, distance_of: DistanceOf = whole_distance
) -> Callable[[float], float]:
    """Fit mean distances on the fine mesh [m] to those on the coarse one: a line through the pairs.

    Distances beyond twice the limit count as twice the limit.
    """
    known = [(distance_of(one.pair[1]), distance_of(one.pair[0])) for one in judged if one.pair is not None]
    pairs = np.array([pair for pair in known if None not in pair], dtype=float).reshape(-1, 2)
    pairs = np.minimum(pairs, 2.0 * limits.mean_vertex_distance)
    if len(pairs) < FEWEST or not np.ptp(pairs[:, 0]) > 0.0:
        return lambda distance: distance
    slope, intercept = np.polyfit(pairs[:, 0], pairs[:, 1], 1)
    return lambda distance: max(0.0, float(intercept + slope * distance))
