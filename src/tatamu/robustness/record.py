"""The share of disturbed worlds in which a fold succeeds, and the file `margins.json`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from tatamu.files import read_json, validated
from tatamu.folding.fold import Fold
from tatamu.folding.score import Limits, vertex_distances
from tatamu.records import OpenRecord
from tatamu.robustness.meshes import MeshVerdict, fit_distances, moving_distance, whole_distance


class AloneMargin(OpenRecord):
    """The range of one disturbance alone within which a fold succeeds."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"mean"})

    name: str
    unit: str
    """m, rad or s; 1 for a relative change."""
    low: float | None
    """Lowest value, below zero, at which the fold still succeeded; None if it succeeded at all values tried below
    zero."""
    high: float | None
    """Highest value, above zero, at which the fold still succeeded; None if it succeeded at all values tried above
    zero."""
    deviation: float
    """Standard deviation of the disturbance, in the same unit; of the logarithm, if it is a relative change."""
    tried: tuple[float, float]
    """The range that was tried."""
    mean: float = 0.0
    """Mean of the disturbance; of the logarithm, if it is a relative change."""


class Spread(OpenRecord):
    """Mean vertex distances of all draws [m]; a simulation that failed counts as twice that of untouched cloth."""

    median: float
    q90: float
    worst: float

    @classmethod
    def of(cls, distances: Sequence[float]) -> Spread:
        """Return the spread of distances [m]."""
        median, q90 = np.quantile(distances, [0.5, 0.9])
        return cls(median=float(median), q90=float(q90), worst=float(max(distances)))


class SuccessRate(OpenRecord):
    """The share of disturbed worlds in which a fold succeeded."""

    draws: int
    held: int
    share: float
    interval: tuple[float, float]
    """Confidence interval of the share (Clopper and Pearson 1934), at 95 %."""
    mean_vertex_distance: Spread

    @classmethod
    def of(cls, fold: Fold, judged: Sequence[MeshVerdict], limits: Limits) -> SuccessRate:
        """Return the share of worlds in which a fold succeeded, and how far from its target it ended.

        Args:
            fold: The fold on the fine mesh.
            judged: Verdicts on the worlds.
            limits: The limits of success.
        """
        held = sum(limits.hold(one.verdict) for one in judged)
        return cls(
            draws=len(judged),
            held=held,
            share=held / len(judged),
            interval=interval_of(held, len(judged)),
            mean_vertex_distance=Spread.of(distances_of(fold, judged, limits)),
        )

    @property
    def headline(self) -> str:
        """The share as text: "held in 196 of 200 disturbed simulations (98 %, 95 % interval 95 to 99 %)"."""
        low, high = self.interval
        return (
            f"held in {self.held} of {self.draws} disturbed simulations "
            f"({100 * self.share:.0f} %, 95 % interval {100 * low:.0f} to {100 * high:.0f} %)"
        )

    @property
    def tone(self) -> str:
        """The grade of this share on the page."""
        return "near-perfect" if self.interval[0] >= SURE else "fair" if self.share >= LIKELY else "failed"


def interval_of(held: int, draws: int) -> tuple[float, float]:
    """Return the confidence interval of a share at 95 % (Clopper and Pearson 1934)."""
    from scipy.stats import binomtest  # takes half a second

    found = binomtest(held, draws).proportion_ci(CONFIDENCE, method="exact")
    return float(found.low), float(found.high)


def failures_of(judged: Sequence[MeshVerdict]) -> dict[str, int]:
    """Return the number of worlds without a fold to score, by reason, the commonest first."""
    return dict(Counter(one.verdict.error.split(":")[0] for one in judged if one.verdict.error).most_common())


def distances_of(fold: Fold, judged: Sequence[MeshVerdict], limits: Limits, *, moving: bool = False) -> list[float]:
    """Return mean vertex distances on the fine mesh [m], predicted from the coarse one if it was not simulated there.

    A failed simulation counts as twice the distance of untouched cloth.

    Args:
        fold: The fold on the fine mesh.
        judged: Verdicts on worlds.
        limits: The limits of success.
        moving: Return the distances of the moving part instead of the whole.
    """
    distance_of = moving_distance if moving else whole_distance
    predict = fit_distances(judged, limits, distance_of)
    untouched = vertex_distances(fold.target, fold.start)
    failed = 2.0 * float((untouched[~fold.still()] if moving else untouched).mean())
    found = [(one, distance_of(one.verdict)) for one in judged]
    return [failed if d is None else d if one.fine else predict(d) for one, d in found]


CONFIDENCE = 0.95
"""Confidence level of the interval of a share."""
SURE, LIKELY = 0.9, 0.8
"""A fold is graded sure if the interval of its share is above the first, likely if the share is above the second."""


class MeshUsed(OpenRecord):
    """The meshes that were simulated."""

    spacing: float
    """Spacing of the mesh on which all worlds were simulated [m]."""
    vertices: int
    coarser: bool
    """Whether this mesh is coarser than the fine mesh. If so, all uncertain verdicts are from the fine mesh."""
    own_spacing: float | None = None
    """Spacing of the fine mesh [m]; None in files of earlier versions."""
    own_simulations: int | None = None
    """Number of simulations on the fine mesh; None in files of earlier versions."""
    checked: int = 0
    """Number of worlds simulated on both meshes."""
    same: int = 0
    """Number of worlds simulated on both meshes in which both agree whether the fold succeeds."""
    apart: float = 0.0
    """Largest difference of the mean vertex distance between both meshes in the worlds simulated on both [m]."""


class MarginsResult(OpenRecord):
    """The margins of one learned fold."""

    version: Literal[1] = 1
    tatamu: str = ""
    """The version that wrote it."""
    simulator: str
    seed: int
    limits: Limits
    undisturbed: float | None
    """Mean vertex distance without disturbances [m]; None if the simulation failed."""
    alone: list[AloneMargin]
    joint: SuccessRate
    moving_vertex_distance: Spread | None = None
    """Distances of the moving part in all draws; None in files of earlier versions."""
    failures: dict[str, int] = Field(default_factory=dict)
    """Number of draws without a fold to score, by reason."""
    mesh: MeshUsed
    simulations: Annotated[int, Field(ge=0)]
    """Number of simulations."""
    disturbances: dict[str, Any]
    """Disturbances that were used."""

    @property
    def reasons(self) -> str:
        """Return the reasons of missing scores as text; empty if there are none."""
        return ", ".join(f"{reason} in {count}" for reason, count in self.failures.items())

    @classmethod
    def load(cls, path: Path) -> MarginsResult:
        """Read `margins.json`.

        Raises:
            InputError: If the file cannot be read, or a field is wrong; the message names both.
        """
        return validated(cls, read_json(path), path)
