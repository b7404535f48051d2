"""Texts on margins, for the page, and the table and summary on a terminal."""

from __future__ import annotations

import numpy as np
from rich.table import Table

from tatamu.evaluation.disturbances.channels import channel_of
from tatamu.evaluation.outcome import HELP
from tatamu.evaluation.success import AloneMargin, MarginsRecord, Spread


def deviations(margin: AloneMargin, end: float | None) -> float:
    """Return how far the end of a range is from the mean, in standard deviations; infinite for None."""
    if end is None:
        return np.inf
    value = np.log1p(end) if margin.unit == "1" else end
    return float(abs(value - margin.mean) / margin.deviation)


def sureness(margin: AloneMargin) -> float:
    """Return the smaller of the two ranges of a disturbance, below and above its mean, in standard deviations.

    The result is infinite if the fold succeeds at all tried values.
    """
    return min(deviations(margin, end) for end in (margin.low, margin.high))


def by_sureness(margins: MarginsRecord) -> list[AloneMargin]:
    """Return the ranges of the disturbances, the smallest first."""
    return sorted(margins.alone, key=sureness)


def reach(margin: AloneMargin) -> tuple[str, str]:
    """Return the lowest and the highest tolerated value of a disturbance, as two texts."""
    text = channel_of(margin.name).text
    pairs = zip((margin.low, margin.high), margin.tried, strict=True)
    low, high = (f"beyond {text(tried)}" if end is None else text(end) for end, tried in pairs)
    return low, high


def rows(margins: MarginsRecord) -> list[tuple[str, str, str, str]]:
    """Return title, deviation, and lowest and highest tolerated value of each disturbance, the smallest range first."""
    named = [(channel_of(margin.name), margin) for margin in by_sureness(margins)]
    return [(channel.title, channel.spread(margin.deviation), *reach(margin)) for channel, margin in named]


def table(margins: MarginsRecord) -> Table:
    """Return a table with the range of each disturbance alone.

    The smallest range, in standard deviations, comes first.
    """
    out = Table(title="Range tolerated, one disturbance at a time", title_justify="left", title_style="bold")
    out.add_column("disturbance", ratio=1)
    for name in ("σ", "from", "to"):
        out.add_column(name, justify="right", no_wrap=True)
    for row in rows(margins):
        out.add_row(*row)
    return out


def simulated(margins: MarginsRecord) -> str:
    """Return how many simulations were made, and on which mesh."""
    mesh = "" if margins.spacing is None else f" on a mesh of {1e3 * margins.spacing:.3g} mm"
    return f"{margins.simulations} simulations in {margins.simulator}{mesh}"


def summary(margins: MarginsRecord) -> str:
    """Return lines: how often the fold succeeds, why not and what helps, and what was simulated."""
    together = margins.together
    lines = [f"{together.headline}; mean distance from the target: {_spread(together.mean_vertex_distance)}"]
    if margins.moving_vertex_distance is not None:
        lines.append(f"mean distance of the part that moves: {_spread(margins.moving_vertex_distance)}")
    lines += [
        f"{count} of {together.simulations} fail ({cause}): {HELP[cause]}" for cause, count in together.causes.items()
    ]
    return "\n".join([*lines, simulated(margins)])


def _spread(spread: Spread) -> str:
    return (
        f"median {1e3 * spread.median:.1f} mm, 90th percentile {1e3 * spread.q90:.1f} mm, "
        f"worst {1e3 * spread.worst:.1f} mm"
    )
