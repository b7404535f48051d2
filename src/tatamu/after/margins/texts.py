"""Texts that describe disturbances and margins, for the page, and the table and summary on a terminal."""

from __future__ import annotations

import numpy as np
from rich.table import Table

from tatamu.evaluation.outcome import HELP
from tatamu.evaluation.success import AloneMargin, MarginsRecord, Spread

TITLES = {
    "hands.offset.along": "both hands too far along the fold",
    "hands.offset.across": "both hands too far to the left",
    "hands.offset.up": "both hands too high",
    "hands.difference.along": "left hand farther along than the right",
    "hands.difference.across": "hands too far apart",
    "hands.difference.up": "left hand higher than the right",
    "hands.yaw": "pair of hands turned",
    "hands.opening_delay": "left hand opens after the right",
    "hands.speed": "hands too fast",
    "grasp.along.left": "left grasp too far along the edge",
    "grasp.along.right": "right grasp too far along the edge",
    "grasp.into.left": "left grasp too far in",
    "grasp.into.right": "right grasp too far in",
    "cloth.place.along": "cloth too far along the fold",
    "cloth.place.across": "cloth too far to the left",
    "cloth.yaw": "cloth turned",
    "table.height": "table too high",
    "material.areal_density": "cloth heavier",
    "material.stretch_stiffness": "stiffer to stretch",
    "material.poisson_ratio": "greater Poisson ratio",
    "material.compression": "stiffer to compress",
    "material.bending_rigidity": "stiffer to bend",
    "material.thickness": "thicker",
    "material.friction_table": "more friction on the table",
    "material.friction_cloth": "more friction on cloth",
    "material.air_drag": "more air drag",
    "material.air_drag_normal": "more air drag along the normal",
    "material.air_drag_tangential": "more air drag along the surface",
    "material.air_drag_quadratic": "more quadratic air drag along the normal",
    "material.air_drag_quadratic_tangential": "more quadratic air drag along the surface",
    "material.stretch_stiffness_weft": "stiffer to stretch along the weft",
    "material.shear_stiffness": "stiffer to shear",
    "material.bending_rigidity_weft": "stiffer to bend along the weft",
    "material.bending_rigidity_bias": "stiffer to bend along the bias",
    "material.bending_hysteresis": "more hysteresis of bending",
    "material.bending_rigidity_initial": "stiffer to bend at first",
    "material.air_drag_turning": "more air drag after turning around",
    "material.air_added_mass": "more air carried along",
}
"""Texts that say what a positive value of each disturbance means."""
SHOWN = {"m": (1e3, "mm"), "rad": (180.0 / np.pi, "°"), "s": (1e3, "ms"), "1": (100.0, "%")}
"""Units in which readers see values, by the units in files.

Each entry has the factor that converts a value, and the name of the unit for readers.
"""


def amount(value: float, unit: str) -> str:
    """Return the value of a disturbance with its sign and unit, as text."""
    scale, name = SHOWN[unit]
    space = "" if name == "°" else " "
    return f"{scale * value:+.3g}".replace("-", "−") + space + name


def reach(margin: AloneMargin) -> tuple[str, str]:
    """Return the lowest and the highest tolerated value of a disturbance, as two texts."""
    return _side(margin.low, margin.tried[0], margin.unit), _side(margin.high, margin.tried[1], margin.unit)


def _side(end: float | None, tried: float, unit: str) -> str:
    return f"beyond {amount(tried, unit)}" if end is None else amount(end, unit)


def simulated(margins: MarginsRecord) -> str:
    """Return how many simulations were made, and on which mesh."""
    mesh = "" if margins.spacing is None else f" on a mesh of {1e3 * margins.spacing:.3g} mm"
    return f"{margins.simulations} simulations in {margins.simulator}{mesh}"


def sureness(margin: AloneMargin) -> float:
    """Return the smaller of the two ranges of a disturbance, below and above its mean, in standard deviations.

    The result is infinite if the fold succeeds at all tried values.
    """
    return min(deviations(margin, end) for end in (margin.low, margin.high))


def deviations(margin: AloneMargin, end: float | None) -> float:
    """Return how far the end of a range is from the mean, in standard deviations; infinite for None."""
    if end is None:
        return np.inf
    value = np.log1p(end) if margin.unit == "1" else end
    return float(abs(value - margin.mean) / margin.deviation)


def by_sureness(margins: MarginsRecord) -> list[AloneMargin]:
    """Return the ranges of the disturbances, the smallest first."""
    return sorted(margins.alone, key=sureness)


def table(margins: MarginsRecord) -> Table:
    """Return a table with the range of each disturbance alone.

    The smallest range, in standard deviations, comes first.
    """
    out = Table(title="Range tolerated, one disturbance at a time", title_justify="left", title_style="bold")
    out.add_column("disturbance", ratio=1)
    for name in ("σ", "from", "to"):
        out.add_column(name, justify="right", no_wrap=True)
    for margin in by_sureness(margins):
        low, high = reach(margin)
        sigma = amount(margin.deviation, margin.unit).lstrip("+")
        out.add_row(TITLES.get(margin.name, margin.name), sigma, low, high)
    return out


def summary(margins: MarginsRecord) -> str:
    """Return lines: how often the fold succeeds, why not and what helps, and what was simulated."""
    together = margins.together
    lines = [f"{together.headline}: mean distance {_spread(together.mean_vertex_distance)}"]
    if margins.moving_vertex_distance is not None:
        lines.append(f"of the part that moves: {_spread(margins.moving_vertex_distance)}")
    lines += [f"{count} of {together.simulations} {cause}: {HELP[cause]}" for cause, count in together.causes.items()]
    return "\n".join([*lines, simulated(margins)])


def _spread(spread: Spread) -> str:
    return (
        f"{1e3 * spread.median:.1f} mm in the median, {1e3 * spread.q90:.1f} mm at 90 %, "
        f"{1e3 * spread.worst:.1f} mm at worst"
    )
