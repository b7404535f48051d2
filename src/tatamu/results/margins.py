"""The models of `margins/margins.json`: how much a learned fold stands before it fails."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field

from tatamu.records import OpenRecord


class HoldLimits(OpenRecord):
    """The measures that the fold had to keep in order to hold."""

    mean_vertex_distance: float
    """At most [m]."""
    mask_iou: float
    """At least."""


class AloneMargin(OpenRecord):
    """How far one disturbance may go while everything else is as it should be."""

    name: str
    unit: str
    """m, rad or s; 1 for a relative change."""
    low: float | None
    """Farthest below zero at which the fold still held; None: nothing failed as far as it was tried."""
    high: float | None
    """Farthest above zero."""
    deviation: float
    """Its standard deviation, in the same unit; of a relative change that of the logarithm."""
    tried: tuple[float, float]
    """How far it was tried at most."""


class Spread(OpenRecord):
    """Mean vertex distances of all draws [m]; a simulation that failed counts as twice that of untouched cloth."""

    median: float
    q90: float
    worst: float


class JointMargin(OpenRecord):
    """Everything off at once."""

    draws: int
    held: int
    share: float
    interval: tuple[float, float]
    """Of Clopper and Pearson, at 95 %."""
    mean_vertex_distance: Spread

    @property
    def headline(self) -> str:
        """How sure the fold is: "holds in 98 % of 200 (95 to 99)"."""
        low, high = self.interval
        return f"holds in {100 * self.share:.0f} % of {self.draws} ({100 * low:.0f} to {100 * high:.0f})"

    @property
    def tone(self) -> str:
        """How good that is, as a grade of the page."""
        return "near-perfect" if self.interval[0] >= SURE else "fair" if self.share >= LIKELY else "failed"


SURE, LIKELY = 0.95, 0.8
"""A fold is sure if the interval of its share lies above the first, likely if the share is above the second."""


class MeshUsed(OpenRecord):
    """The meshes that were simulated."""

    spacing: float
    """Of the mesh on which all was simulated [m]."""
    vertices: int
    coarser: bool
    """Than the one that the fold was learned on; then all verdicts that hang on the mesh are from the latter."""
    own_spacing: float | None = None
    """Of the fold's own mesh [m]; None: written before it was said."""
    own_simulations: int | None = None
    """How many simulations ran on the fold's own mesh; None: written before it was said."""
    checked: int = 0
    """How many worlds were simulated on both meshes."""
    same: int = 0
    """In how many of these both agree whether the fold holds."""
    apart: float = 0.0
    """Largest difference of the mean vertex distance in these [m]."""


class MarginsResult(OpenRecord):
    """The margins of one learned fold."""

    version: Literal[1] = 1
    tatamu: str = ""
    """The version that wrote it."""
    simulator: str
    seed: int
    limits: HoldLimits
    undisturbed: float | None
    """Mean vertex distance where nothing is off [m]; None: the simulation failed."""
    alone: list[AloneMargin]
    joint: JointMargin
    mesh: MeshUsed
    simulations: Annotated[int, Field(ge=0)]
    """How many there were."""
    disturbances: dict[str, Any]
    """As used."""

    @property
    def headline(self) -> str:
        """How sure the fold is: "holds in 98 % of 200 (95 to 99)"."""
        return self.joint.headline
