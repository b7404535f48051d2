"""Two meshes of one fold: which verdicts of the coarse one may be trusted, and what its distances are on the other.

Draws are simulated on the coarse mesh. Some of them, and the undisturbed fold, are simulated on the fold's own mesh
too; by how much both differ there says which other verdicts hang on the mesh. Those are simulated on it as well, and
count as pairs in turn, until nothing changes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256

import numpy as np

from tatamu.disturbances.verdict import Limits, Verdict
from tatamu.folding.coarser import on_coarser_mesh
from tatamu.folding.manipulation import Manipulation, scene_of
from tatamu.folding.task import Task
from tatamu.simulators.source import source_digest

PAIRS = 12
"""At most so many draws are simulated on both meshes whatever their verdict: evenly from the best to the worst."""
DRAWS_OF_PAIR = 8
"""One draw in so many is, where that is fewer."""
FEWEST = 3
"""Pairs that a line is laid through."""


@dataclass(frozen=True)
class FoldOnMesh:
    """A manipulation of a fold on some mesh."""

    task: Task
    manipulation: Manipulation

    @property
    def key(self) -> str:
        """A name that differs where a simulation would, by another version of the simulator too."""
        scene = scene_of(self.task.fold, self.manipulation)
        known = f"{self.task.simulator} {source_digest()} {scene.model_dump_json()}"
        return sha256(known.encode()).hexdigest()[:16]


def fold_on_coarser_mesh(task: Task, manipulation: Manipulation, parameters: Mapping[str, float]) -> FoldOnMesh | None:
    """The manipulation of the same parameters on the coarser mesh of a task; None where it has none."""
    if task.coarser is None:
        return None
    return FoldOnMesh(task.coarser.bare, on_coarser_mesh(task, manipulation, parameters))


@dataclass(frozen=True)
class Judged:
    """A world's verdict, from the finest mesh that it was simulated on."""

    verdict: Verdict
    coarse: Verdict | None = None
    """On the coarse mesh; None: it was not simulated there."""
    own: bool = True
    """Whether the verdict is from the fold's own mesh."""


@dataclass(frozen=True)
class Apart:
    """How far verdicts of both meshes are apart."""

    limits: Limits
    low: float = 0.0
    """Least slack on the own mesh less that on the coarse one; see `Verdict.slack`."""
    high: float = 0.0
    """Greatest."""

    @staticmethod
    def everything(limits: Limits) -> Apart:
        """So far that the coarse mesh decides nothing."""
        return Apart(limits, -np.inf, np.inf)

    def widened(self, pairs: Iterable[Judged]) -> Apart:
        """As far as that, and as these are."""
        differences = [
            pair.verdict.slack(self.limits) - pair.coarse.slack(self.limits) for pair in pairs if pair.coarse
        ]
        return Apart(self.limits, min([self.low, *differences]), max([self.high, *differences]))

    def decides(self, coarse: Verdict) -> bool:
        """Whether a fold that ends so on the coarse mesh can only end alike on the own one; not where it failed."""
        if coarse.error is not None:
            return False
        slack = coarse.slack(self.limits)
        return (slack + self.low >= 0.0) == (slack + self.high >= 0.0)


def sampled(verdicts: Sequence[Verdict], limits: Limits) -> list[int]:
    """Numbers of draws that are simulated on both meshes."""
    ranked = sorted(range(len(verdicts)), key=lambda number: (verdicts[number].slack(limits), number))
    places = np.linspace(0, len(ranked) - 1, _pairs(len(ranked))).round().astype(int)
    return sorted(ranked[place] for place in places)


def _pairs(draws: int) -> int:
    """How many of some draws are simulated on both meshes."""
    return min(PAIRS, max(FEWEST, draws // DRAWS_OF_PAIR), draws)


def on_own_mesh(draws: Sequence[Judged], limits: Limits) -> Callable[[float], float]:
    """Mean distances on the own mesh [m] of those on the coarse one: a line through the draws that are known on both.

    Beyond twice the limit it does not matter how far: such draws count as ending there.
    """
    known = [
        (draw.coarse.mean_vertex_distance, draw.verdict.mean_vertex_distance)
        for draw in draws
        if draw.own and draw.coarse is not None
    ]
    pairs = np.array([pair for pair in known if None not in pair], dtype=float).reshape(-1, 2)
    pairs = np.minimum(pairs, 2.0 * limits.mean_vertex_distance)
    if len(pairs) < FEWEST or not np.ptp(pairs[:, 0]) > 0.0:
        return lambda distance: distance
    slope, intercept = np.polyfit(pairs[:, 0], pairs[:, 1], 1)
    return lambda distance: max(0.0, float(intercept + slope * distance))
