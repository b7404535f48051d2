"""Texts on an observed fold, for the terminal and the page."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tatamu.after.feedback.corrected import CorrectionRecord, End, kept
from tatamu.after.feedback.correction import WORTH
from tatamu.after.feedback.folder import ObservedFolder
from tatamu.after.feedback.observe import BEYOND, Observed
from tatamu.after.margins.texts import SHOWN, TITLES, amount
from tatamu.evaluation.disturbances import CHANNELS
from tatamu.folding.manipulation import HANDS
from tatamu.folding.marks import MARKS
from tatamu.folding.shift import HandShift
from tatamu.study.result import Result

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
"""Descriptions of the marks, which are lengths that are measured after a fold."""
UNITS = {channel.name: channel.unit for channel in CHANNELS}
NAMED = 4
"""Largest number of disturbances that the terminal lists."""


def shown(name: str, value: float) -> str:
    """Return the value of a disturbance as text, with its sign and unit.

    The logarithm of a factor is shown as a relative change, to first order.
    """
    return amount(value, UNITS[name])


def deviation(name: str, value: float) -> str:
    """Return the standard deviation of a disturbance as text, with its unit."""
    return amount(value, UNITS[name]).lstrip("+")


def title(name: str) -> str:
    """Return a text that says what a positive value of a disturbance means."""
    return TITLES.get(name, name)


def learned_most(observed: Observed) -> list[tuple[str, float, float, float]]:
    """Return the name, mean, and standard deviations before and after observations of the inferred disturbances.

    The disturbance whose standard deviation was reduced by the largest factor comes first.
    """
    posterior = observed.posterior
    means = dict(zip(posterior.names, posterior.mean, strict=True))
    rows = [(name, float(means[name]), before, after) for name, before, after in posterior.deviations]
    return sorted(rows, key=lambda row: row[3] / row[2])


def posterior_lines(observed: Observed) -> Iterator[str]:
    """Yield lines of text for the terminal: the errors of the set-up that were inferred from observed folds."""
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
        yield f"cannot be told apart: {title(pair.one)}; {title(pair.other)} (correlation {pair.correlation:+.2f})"
    untold = posterior.untold()
    if untold:
        yield f"not determined: {', '.join(title(name) for name in untold)}"


def correction_lines(record: CorrectionRecord) -> Iterator[str]:
    """Yield lines of text: the correction of each hand, and the outcomes that are expected without and with it."""
    before, after = record.expected["before"], record.expected["after"]
    if not record.hands:
        yield f"no correction is expected to bring the fold {1e3 * WORTH:.1f} mm nearer"
        yield f"expected: {_expected(before)}"
        return
    for hand, shift in zip(HANDS, record.hands, strict=False):
        yield f"{hand} hand: {shift_text(shift)}"
    yield f"expected without it: {_expected(before)}"
    yield f"expected with it: {_expected(after)}"


def next_lines(last: Path, found: Result) -> Iterator[str]:
    """Yield lines of text on a fold that was learned after observed folds: its corrections and its expected outcome.

    Args:
        last: Folder of the last observed fold.
        found: The fold learned after it.
    """
    for hand, shift in zip(HANDS, found.task.shift, strict=False):
        yield f"{hand} hand, of every trial: {shift_text(shift)}"
    record = kept(ObservedFolder.of(last))
    if record is not None:
        yield f"expected of {last}: {_expected(record.expected['before'])}"
    if found.held is not None:
        spread = found.held.mean_vertex_distance
        median, most = 1e3 * spread.median, 1e3 * spread.q90
        yield f"expected of this fold: median distance {median:.1f} mm (90 % within {most:.1f} mm)"


def shift_text(shift: HandShift) -> str:
    """Return a hand's correction as text: the shifts of its grasp and its release, and its change of height [mm]."""
    grasp, release = (f"{1e3 * along:+.1f}, {1e3 * across:+.1f}" for along, across in (shift.grasp, shift.release))
    return f"grasp {grasp} mm, release {release} mm (along, across), height {1e3 * shift.height:+.1f} mm"


def _expected(end: End) -> str:
    low, high = end.interval
    distance = 1e3 * end.mean_vertex_distance
    return f"mean distance {distance:.1f} mm (90 % interval {1e3 * low:.1f} to {1e3 * high:.1f} mm)"


__all__ = ["MARK_TITLES", "SHOWN", "correction_lines", "next_lines", "posterior_lines", "shift_text", "shown", "title"]
