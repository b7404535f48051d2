"""Decides which verdicts of a coarse mesh are final, and estimates distances on the fine mesh from the coarse mesh.

A world is one random draw of all disturbances. The nominal world has no disturbances. All worlds are simulated on the
coarse mesh. The nominal world and a sample of the other worlds are also simulated on the fine mesh. A verdict is the
result of the fold in one world. If a world was simulated on both meshes, its two verdicts are a pair. The slack of a
fold (`Limits.slack`) is its distance from failure, and differs between the two meshes of a pair.

In another world, a difference as large as in the pairs could turn success into failure, or failure into success. That
world is then simulated on the fine mesh too, and becomes a pair. This is repeated until the coarse verdicts of all
other worlds are final.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256

import numpy as np

from tatamu.evaluation import Evaluator
from tatamu.evaluation.disturbances import NOMINAL, disturbed_scene
from tatamu.evaluation.robustness.verdict import Verdict
from tatamu.folding.score import Limits
from tatamu.simulation.source import source_digest

PAIRS = 12
"""Largest number of draws that are always simulated on both meshes, the coarse and the fine mesh.

These draws are spread evenly over all draws, sorted from worst to best.
"""
DRAWS_PER_PAIR = 8
"""One of this many draws is simulated on both meshes, the coarse and the fine mesh, but at most `PAIRS` draws."""
VERSION = 2
"""Version of the contents of saved verdicts, the results of folds under random disturbances.

Verdicts of other versions are not used again.
"""
FEWEST = 3
"""Least number of draws that are simulated on both meshes, the coarse and the fine mesh.

`fit_distances` needs at least as many to fit a line.
"""


DistanceOf = Callable[[Verdict], float | None]
"""Function that returns a verdict's mean distance of vertices from their targets [m]; None if the simulation failed."""


def whole_distance(verdict: Verdict) -> float | None:
    """Return a verdict's mean distance of all vertices from their targets [m]."""
    return verdict.mean_vertex_distance


def moving_distance(verdict: Verdict) -> float | None:
    """Return a verdict's mean distance from the targets for the vertices of the part that moves [m]."""
    return verdict.moving_vertex_distance


@dataclass(frozen=True)
class FoldOnMesh:
    """A manipulation, described by its parameters, and the evaluator that simulates it on one mesh."""

    evaluator: Evaluator
    parameters: Mapping[str, int | float]

    @property
    def key(self) -> str:
        """A name for the simulations of this fold. It changes with the scene and with the version of the simulator."""
        task = self.evaluator.task
        scene = disturbed_scene(task.fold, task.manipulation(self.parameters), NOMINAL)
        known = f"{VERSION} {task.simulator} {source_digest()} {scene.model_dump_json()}"
        return sha256(known.encode()).hexdigest()[:16]


@dataclass(frozen=True)
class MeshVerdict:
    """The verdict on a world (one draw of the disturbances), from the finest mesh on which the world was simulated."""

    verdict: Verdict
    coarse: Verdict | None = None
    """Verdict on the coarse mesh; None if the world was not simulated there."""
    fine: bool = True
    """Whether the field `verdict` comes from the fine mesh."""

    @property
    def pair(self) -> tuple[Verdict, Verdict] | None:
        """Verdicts on the fine mesh and on the coarse mesh; None if the world was simulated on only one mesh."""
        return (self.verdict, self.coarse) if self.fine and self.coarse is not None else None


@dataclass(frozen=True)
class SlackRange:
    """The range of differences in slack between two meshes: slack on the fine mesh minus slack on the coarse mesh.

    The slack of a fold is its distance from failure, see `Limits.slack`.
    """

    limits: Limits
    low: float = 0.0
    high: float = 0.0

    @staticmethod
    def unbounded(limits: Limits) -> SlackRange:
        """Return the unbounded range, with which no verdict of the coarse mesh is final."""
        return SlackRange(limits, -np.inf, np.inf)

    def including(self, judged: Iterable[MeshVerdict]) -> SlackRange:
        """Return this range, extended to include the differences of the given pairs of verdicts."""
        pairs = [one.pair for one in judged if one.pair is not None]
        differences = [self.limits.slack(fine) - self.limits.slack(coarse) for fine, coarse in pairs]
        return SlackRange(self.limits, min([self.low, *differences]), max([self.high, *differences]))

    def is_conclusive(self, coarse: Verdict) -> bool:
        """Return whether the verdict of the coarse mesh is final, so that no simulation on the fine mesh is needed.

        The result is False if the simulation failed.
        """
        if coarse.error is not None:
            return False
        slack = self.limits.slack(coarse)
        return (slack + self.low >= 0.0) == (slack + self.high >= 0.0)


def select_pairs(verdicts: Sequence[Verdict], limits: Limits) -> list[int]:
    """Return the numbers of the draws that are simulated on both meshes, the coarse and the fine mesh.

    These draws are spread evenly over all draws, sorted from worst to best.
    """
    ranked = sorted(range(len(verdicts)), key=lambda number: (limits.slack(verdicts[number]), number))
    count = min(PAIRS, max(FEWEST, len(ranked) // DRAWS_PER_PAIR), len(ranked))
    places = np.linspace(0, len(ranked) - 1, count).round().astype(int)
    return sorted(ranked[place] for place in places)


def fit_distances(
    judged: Sequence[MeshVerdict], limits: Limits, distance_of: DistanceOf = whole_distance
) -> Callable[[float], float]:
    """Fit a line that predicts mean distances on the fine mesh [m] from mean distances on the coarse mesh.

    The line is fitted to the draws that were simulated on both meshes. Distances of more than twice the limit of a
    successful fold count as twice this limit. The result is a function of the distance on the coarse mesh.
    """
    known = [(distance_of(one.pair[1]), distance_of(one.pair[0])) for one in judged if one.pair is not None]
    pairs = np.array([pair for pair in known if None not in pair], dtype=float).reshape(-1, 2)
    pairs = np.minimum(pairs, 2.0 * limits.mean_vertex_distance)
    if len(pairs) < FEWEST or not np.ptp(pairs[:, 0]) > 0.0:
        return lambda distance: distance
    slope, intercept = np.polyfit(pairs[:, 0], pairs[:, 1], 1)
    return lambda distance: max(0.0, float(intercept + slope * distance))
