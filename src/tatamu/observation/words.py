"""Texts on an observed fold, for the terminal and the page."""

from __future__ import annotations

from collections.abc import Iterator

from tatamu.disturbances import CHANNELS
from tatamu.folding.manipulation import HANDS
from tatamu.folding.marks import MARKS
from tatamu.folding.shift import HandShift
from tatamu.margins.words import SHOWN, TITLES, amount
from tatamu.observation.correction import Expected
from tatamu.observation.observe import BEYOND, Observed

MARK_TITLES = dict(
    zip(
        MARKS,
        (
            "left corner, along",
            "left corner, across",
            "right corner, along",
            "right corner, across",
            "lower hem, along",
            "lower hem, across",
        ),
        strict=True,
    )
)
"""Meaning of each measured number."""
UNITS = {channel.name: channel.unit for channel in CHANNELS}
NAMED = 4
"""Number of disturbances that the terminal lists."""


def shown(name: str, value: float) -> str:
    """Return a value of a disturbance with its sign and unit; relative ones to first order."""
    return amount(value, UNITS[name])


def deviation(name: str, value: float) -> str:
    """Return a standard deviation of a disturbance with its unit."""
    return amount(value, UNITS[name]).lstrip("+")


def title(name: str) -> str:
    """Return the meaning of a positive value of a disturbance."""
    return TITLES.get(name, name)


def learned_most(observed: Observed) -> list[tuple[str, float, float, float]]:
    """Return name, mean, prior and posterior deviation of the inferred disturbances, the most certain first."""
    posterior = observed.posterior
    means = dict(zip(posterior.names, posterior.mean, strict=True))
    rows = [(name, float(means[name]), before, after) for name, before, after in posterior.deviations]
    return sorted(rows, key=lambda row: row[3] / row[2])


def posterior_lines(observed: Observed) -> Iterator[str]:
    """Yield the lines on the posterior for the console."""
    posterior = observed.posterior
    count = observed.number
    yield (
        f"{count} observed fold{'s' if count > 1 else ''}, {observed.draws.simulated} new simulations; "
        f"effective sample size {posterior.effective:.0f} of {len(posterior.members)}"
    )
    for number in observed.implausible:
        yield f"warning: observed fold {number} is {BEYOND}"
    if not posterior.used:
        return
    for name, mean, before, after in learned_most(observed)[:NAMED]:
        yield f"{title(name)}: {shown(name, mean)}, σ {deviation(name, after)} (before {deviation(name, before)})"
    for pair in posterior.alike()[:NAMED]:
        yield f"looks alike: {title(pair.one)}; {title(pair.other)} (correlation {pair.correlation:+.2f})"
    untold = posterior.untold()
    if untold:
        yield f"not told: {', '.join(title(name) for name in untold)}"


def correction_lines(observed: Observed) -> Iterator[str]:
    """Yield the lines on the correction and its expected outcome."""
    correction = observed.correction
    if correction.is_none:
        yield "no correction is expected to bring the fold nearer"
        yield f"expected: {_expected(correction.before)}"
        return
    for hand, shift in zip(HANDS, correction.shifts, strict=False):
        yield f"{hand} hand: {shift_text(shift)}"
    yield f"expected without it: {_expected(correction.before)}"
    yield f"expected with it: {_expected(correction.after)}"


def shift_text(shift: HandShift) -> str:
    """Return the shift of a hand in millimetres, along the fold and across it."""
    grasp, release = (f"{1e3 * along:+.1f}, {1e3 * across:+.1f}" for along, across in (shift.grasp, shift.release))
    return f"grasp {grasp} mm, release {release} mm (along, across), height {1e3 * shift.height:+.1f} mm"


def _expected(expected: Expected) -> str:
    low, high = expected.distance_interval
    return f"mean distance {1e3 * expected.distance:.1f} mm (90 % interval {1e3 * low:.1f} to {1e3 * high:.1f} mm)"


__all__ = ["MARK_TITLES", "SHOWN", "correction_lines", "posterior_lines", "shift_text", "shown", "title"]
