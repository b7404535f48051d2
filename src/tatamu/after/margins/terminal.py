"""Margins on a terminal: a table with the range of each disturbance alone, and a summary of the joint draws."""

from __future__ import annotations

from rich.table import Table

from tatamu.after.margins.page import sureness
from tatamu.after.margins.texts import TITLES, amount, reach, simulated
from tatamu.evaluation.outcome import HELP
from tatamu.evaluation.success import MarginsRecord, Spread


def table(margins: MarginsRecord) -> Table:
    """Return a table with the range of each disturbance alone.

    The smallest range, in standard deviations, comes first.
    """
    out = Table(title="Range tolerated, one disturbance at a time", title_justify="left", title_style="bold")
    out.add_column("disturbance", ratio=1)
    for name in ("σ", "from", "to"):
        out.add_column(name, justify="right", no_wrap=True)
    for margin in sorted(margins.alone, key=sureness):
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
