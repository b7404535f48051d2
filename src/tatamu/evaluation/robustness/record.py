"""The success rate of a fold under random disturbances, and the file `margins.json`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from tatamu.base.files import read_json, validated
from tatamu.base.records import OpenRecord
from tatamu.evaluation.robustness.meshes import MeshVerdict, fit_distances, moving_distance, whole_distance
from tatamu.folding.fold import Fold
from tatamu.folding.score import Limits, vertex_distances


class AloneMargin(OpenRecord):
    """The range of one disturbance within which a fold succeeds, if all other disturbances are absent."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"mean"})

    name: str
    unit: str
    """Unit of the values: m, rad or s; 1 if the values are relative changes."""
    low: float | None
    """Lowest value, below the mean, at which the fold still succeeded.

    None if the fold succeeded at all tried values below the mean."""
    high: float | None
    """Highest value, above the mean, at which the fold still succeeded.

    None if the fold succeeded at all tried values above the mean."""
    deviation: float
    """Standard deviation of the disturbance.

    For a relative change, it is the standard deviation of the logarithm of the factor.
    """
    tried: tuple[float, float]
    """Lowest and highest value that were tried."""
    mean: float = 0.0
    """Mean of the disturbance. For a relative change, it is the mean of the logarithm of the factor."""


class Spread(OpenRecord):
    """Statistics of mean vertex distances over all draws of the disturbances [m].

    A mean vertex distance is the mean distance of the cloth's vertices from their targets.

    A simulation that failed counts as twice the distance of untouched cloth.
    """

    median: float
    q90: float
    worst: float

    @classmethod
    def of(cls, distances: Sequence[float]) -> Spread:
        """Return the statistics of distances [m]. The argument has one distance for each draw of the disturbances."""
        median, q90 = np.quantile(distances, [0.5, 0.9])
        return cls(median=float(median), q90=float(q90), worst=float(max(distances)))


class SuccessRate(OpenRecord):
    """The fraction of simulations with random disturbances in which a fold succeeded."""

    draws: int
    held: int
    share: float
    interval: tuple[float, float]
    """Confidence interval of the fraction at the level of 95 % (Clopper and Pearson 1934)."""
    mean_vertex_distance: Spread

    @classmethod
    def of(cls, fold: Fold, judged: Sequence[MeshVerdict], limits: Limits) -> SuccessRate:
        """Return how often a fold succeeded under random disturbances, and how far from its target it ended.

        Args:
            fold: The fold on the fine mesh.
            judged: Verdicts of the fold, one for each draw of the disturbances.
            limits: Limits of a successful fold.
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
        """The success rate as text: "held in 196 of 200 disturbed simulations (98 %, 95 % interval 95 to 99 %)"."""
        low, high = self.interval
        return (
            f"held in {self.held} of {self.draws} disturbed simulations "
            f"({100 * self.share:.0f} %, 95 % interval {100 * low:.0f} to {100 * high:.0f} %)"
        )

    @property
    def tone(self) -> str:
        """The grade of the success rate: "near-perfect", "fair" or "failed".

        It sets the colour of the rate on the page.
        """
        return "near-perfect" if self.interval[0] >= SURE else "fair" if self.share >= LIKELY else "failed"


def interval_of(held: int, draws: int) -> tuple[float, float]:
    """Return the confidence interval of a fraction at the level of 95 % (Clopper and Pearson 1934)."""
    from scipy.stats import binomtest  # this import takes half a second

    found = binomtest(held, draws).proportion_ci(CONFIDENCE, method="exact")
    return float(found.low), float(found.high)


def failures_of(judged: Sequence[MeshVerdict]) -> dict[str, int]:
    """Return the number of simulations without a score, by the reason of the failure. The most frequent is first."""
    return dict(Counter(one.verdict.error.split(":")[0] for one in judged if one.verdict.error).most_common())


def distances_of(fold: Fold, judged: Sequence[MeshVerdict], limits: Limits, *, moving: bool = False) -> list[float]:
    """Return, for each draw, the mean distance of the fine mesh's vertices from their targets [m].

    If only the coarse mesh was simulated, the distance is predicted from the coarse mesh.

    A simulation that failed counts as twice the distance of untouched cloth.

    Args:
        fold: The fold on the fine mesh.
        judged: Verdicts of the fold, one for each draw of the disturbances.
        limits: Limits of a successful fold.
        moving: Whether to return the distances of the moving part instead of the whole cloth.
    """
    distance_of = moving_distance if moving else whole_distance
    predict = fit_distances(judged, limits, distance_of)
    untouched = vertex_distances(fold.target, fold.start)
    failed = 2.0 * float((untouched[~fold.still()] if moving else untouched).mean())
    found = [(one, distance_of(one.verdict)) for one in judged]
    return [failed if d is None else d if one.fine else predict(d) for one, d in found]


CONFIDENCE = 0.95
"""Confidence level of the interval of a success rate."""
SURE, LIKELY = 0.9, 0.8
"""Limits of the grades of a success rate.

The grade is "near-perfect" if the lower end of the confidence interval is at least the first limit. Otherwise it is
"fair" if the success rate is at least the second limit, and "failed" if the success rate is lower."""


class MeshUsed(OpenRecord):
    """The meshes on which the draws of the disturbances were simulated, and how much their results differ."""

    spacing: float
    """Spacing of the mesh on which all draws of the disturbances were simulated [m]."""
    vertices: int
    coarser: bool
    """Whether the mesh of all draws is coarser than the fine mesh.

    If it is coarser, all uncertain verdicts come from the fine mesh.
    """
    own_spacing: float | None = None
    """Spacing of the fine mesh [m]; None in files of earlier versions."""
    own_simulations: int | None = None
    """Number of simulations on the fine mesh; None in files of earlier versions."""
    checked: int = 0
    """Number of draws of the disturbances that were simulated on both meshes."""
    same: int = 0
    """Number of draws with the same verdict, success or failure, on both meshes, among the `checked` draws."""
    apart: float = 0.0
    """Largest difference of the mean vertex distance between both meshes [m], among the `checked` draws."""


class MarginsResult(OpenRecord):
    """The margins of one learned fold: the disturbances that it tolerates."""

    version: Literal[1] = 1
    tatamu: str = ""
    """Version of tatamu that wrote the file."""
    simulator: str
    seed: int
    limits: Limits
    undisturbed: float | None
    """Mean distance of the vertices from their targets without disturbances [m]; None if the simulation failed."""
    alone: list[AloneMargin]
    joint: SuccessRate
    moving_vertex_distance: Spread | None = None
    """Mean vertex distances of the moving part over all draws; None in files of earlier versions."""
    failures: dict[str, int] = Field(default_factory=dict)
    """Number of draws without a score, by the reason of the failure."""
    mesh: MeshUsed
    simulations: Annotated[int, Field(ge=0)]
    """Number of simulations on all meshes."""
    disturbances: dict[str, Any]
    """The disturbances that were used."""

    @property
    def reasons(self) -> str:
        """Reasons why some draws have no score, as text; empty if all draws have a score."""
        return ", ".join(f"{reason} in {count}" for reason, count in self.failures.items())

    @classmethod
    def load(cls, path: Path) -> MarginsResult:
        """Read `margins.json`.

        Raises:
            InputError: If the file cannot be read, or a field is wrong. The message names the file and the field.
        """
        return validated(cls, read_json(path), path)
