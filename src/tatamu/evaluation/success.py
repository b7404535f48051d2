"""How often a fold succeeds under disturbances, and the file `margins.json`. See docs/reference/result-folder.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer
from scipy.special import betaincinv

from tatamu.base.records import OpenRecord
from tatamu.evaluation.outcome import Outcome
from tatamu.folding.fold import Fold
from tatamu.folding.score import Limits, vertex_distances


class Spread(OpenRecord):
    """Median, 90 % quantile and maximum of distances [m]."""

    median: float
    q90: float
    worst: float

    @classmethod
    def of(cls, distances: Sequence[float]) -> Spread:
        """Return the spread of at least one distance."""
        median, q90 = np.quantile(distances, [0.5, 0.9])
        return cls(median=float(median), q90=float(q90), worst=float(max(distances)))


class Success(OpenRecord):
    """In how many simulated scenarios a fold succeeds. All scenarios count."""

    FORMER: ClassVar[Mapping[str, str]] = {"draws": "simulations", "held": "succeeded", "share": "rate"}

    simulations: int
    succeeded: int
    rate: float
    interval: tuple[float, float]
    """Bounds of the rate's 95 % confidence interval (Clopper and Pearson 1934)."""
    causes: dict[str, int] = Field(default_factory=dict)
    """How many scenarios failed by each cause, most frequent first."""
    mean_vertex_distance: Spread

    @model_serializer(mode="wrap")
    def _with_former(self, standard: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Write the names of version 0.2 beside, for one version."""
        return {**standard(self), "draws": self.simulations, "held": self.succeeded, "share": self.rate}

    @classmethod
    def of(cls, fold: Fold, outcomes: Sequence[Outcome], limits: Limits) -> Self:
        """Count the outcomes of a fold."""
        causes = Counter(cause for each in outcomes if (cause := each.cause(limits)) is not None)
        succeeded = len(outcomes) - causes.total()
        return cls(
            simulations=len(outcomes),
            succeeded=succeeded,
            rate=succeeded / len(outcomes),
            interval=interval_of(succeeded, len(outcomes)),
            causes=dict(causes.most_common()),
            mean_vertex_distance=Spread.of(distances_of(fold, outcomes)),
        )

    @property
    def headline(self) -> str:
        """One sentence for readers."""
        low, high = self.interval
        return (
            f"succeeds in {self.succeeded} of {self.simulations} simulations "
            f"({100 * self.rate:.0f} %, 95 % interval {100 * low:.0f} to {100 * high:.0f} %)"
        )

    @property
    def tone(self) -> str:
        """Name of the colour in which pages show the rate."""
        return "near-perfect" if self.interval[0] >= 0.9 else "fair" if self.rate >= 0.8 else "failed"

    def __str__(self) -> str:
        return self.headline


def interval_of(succeeded: int, simulations: int) -> tuple[float, float]:
    """Return the 95 % confidence interval of a success rate (Clopper and Pearson 1934)."""
    failed = simulations - succeeded
    low = betaincinv(succeeded, failed + 1, 0.025) if succeeded else 0.0
    high = betaincinv(succeeded + 1, failed, 0.975) if failed else 1.0
    return float(low), float(high)


def distances_of(fold: Fold, outcomes: Sequence[Outcome], *, moving: bool = False) -> list[float]:
    """Return the mean distance in each outcome [m]; twice that of untouched cloth for a simulation that failed."""
    untouched = vertex_distances(fold.target, fold.start)
    failed = 2.0 * float((untouched[~fold.still()] if moving else untouched).mean())
    found = [each.moving_vertex_distance if moving else each.mean_vertex_distance for each in outcomes]
    return [failed if distance is None else distance for distance in found]


class AloneMargin(OpenRecord):
    """The range of one disturbance in which a fold succeeds, while all others are at their means."""

    UNSAID: ClassVar[frozenset[str]] = frozenset({"mean"})

    name: str
    unit: str
    low: float | None
    """Lowest value at which the fold succeeds; None if it succeeds as far as was tried."""
    high: float | None
    deviation: float
    tried: tuple[float, float]
    mean: float = 0.0


class MarginsRecord(OpenRecord):
    """The file `margins.json`: how large errors may be, and how often the fold succeeds with all of them at once."""

    FORMER: ClassVar[Mapping[str, str]] = {"joint": "together"}

    version: Literal[1] = 1
    tatamu: str = ""
    simulator: str
    seed: int
    limits: Limits
    undisturbed: float | None
    """Mean distance without disturbances [m]; None if that simulation failed."""
    alone: list[AloneMargin]
    together: Success
    moving_vertex_distance: Spread | None = None
    simulations: Annotated[int, Field(ge=0)]
    """How many simulations were made."""
    spacing: float | None = None
    """Distance between neighbouring vertices of the mesh [m]."""
    disturbances: dict[str, Any]

    @model_serializer(mode="wrap")
    def _with_former(self, standard: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Write the names of version 0.2 beside, for one version."""
        plain = OpenRecord._plain(self, standard)
        return {**plain, "joint": plain["together"]}
