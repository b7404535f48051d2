"""Texts on measured folds, for the terminal and the page."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tatamu.after.feedback.correction import MIN_SHIFT, Correction, Expected
from tatamu.after.feedback.observe import Feedback
from tatamu.evaluation.disturbances.channels import Channel, channel_of
from tatamu.folding.manipulation import HANDS, HandShift
from tatamu.folding.score import MARKS
from tatamu.study.result import Result

MARK_TITLES = {
    "left_along": "left corner, along",
    "left_across": "left corner, across",
    "right_along": "right corner, along",
    "right_across": "right corner, across",
    "slip_along": "lower hem, along",
    "slip_across": "lower hem, across",
}
BEYOND = "too far from all simulated scenarios, so it is left out; check the grasp and the numbers, and measure again"
NOTHING = f"nothing to correct: no expected error moves a hand by {1e3 * MIN_SHIFT:.1f} mm"


def by_gain(found: Feedback) -> list[tuple[Channel, float, float, float]]:
    """Return the mean, and deviations before and after, of each systematic error; what became surest comes first."""
    means = dict(zip(found.posterior.names, found.posterior.mean, strict=True))
    rows = [(channel_of(name), float(means[name]), before, after) for name, before, after in found.posterior.deviations]
    return sorted(rows, key=lambda row: row[3] / row[2])


def again(found: Feedback) -> str | None:
    """Return how much of what was measured last is expected to come again; None if no corner was measured."""
    fold = found.folds[found.newest]
    expected = fold.emulator.marks(found.posterior.mean + fold.correction)
    measured = dict(zip([MARKS[place] for place in fold.places], fold.values, strict=True))
    parts = []
    for axis in ("along", "across"):
        corners = [name for name in measured if name.endswith(axis) and not name.startswith("slip")]
        if corners:
            pair = (np.mean([measured[name] for name in corners]), np.mean([expected[MARKS.index(n)] for n in corners]))
            parts.append(f"{1e3 * pair[1]:+.1f} mm of {1e3 * pair[0]:+.1f} mm {axis} the fold")
    return (
        f"without a correction, the next fold is expected to repeat {', '.join(parts)}; the rest differs from fold to "
        "fold"
        if parts
        else None
    )


def posterior_lines(found: Feedback) -> Iterator[str]:
    """Yield lines for the terminal: what was inferred from measured folds."""
    posterior, count = found.posterior, len(found.folds)
    yield f"{count} measured fold{'s' if count > 1 else ''}"
    for place in found.implausible:
        yield f"warning: measured fold {place} is {BEYOND}"
    if not posterior.used:
        return
    undetermined = posterior.undetermined()
    determined = [row for row in by_gain(found) if row[0].name not in undetermined]
    listed = 4  # at most
    for error, mean, before, after in determined[:listed]:
        yield f"{error.title}: {error.text(mean)}, σ {error.spread(after)} (before {error.spread(before)})"
    for pair in posterior.alike()[:listed]:
        one, other = channel_of(pair.one), channel_of(pair.other)
        yield f"cannot be told apart: {one.title} and {other.title} (correlation {pair.correlation:+.2f})"
    if undetermined:
        yield f"not determined: {', '.join(channel_of(name).title for name in undetermined)}"
    if sentence := again(found):
        yield sentence


def correction_lines(correction: Correction) -> Iterator[str]:
    """Yield lines: the shift of each hand, and the outcomes that are expected without and with it."""
    if correction.is_none:
        yield NOTHING
        yield f"expected: {_expected(correction.before)}"
        return
    for hand, shift in zip(HANDS, correction.shifts, strict=False):
        yield f"{hand} hand: {shift_text(shift)}"
    yield f"expected without the correction: {_expected(correction.before)}"
    yield f"expected with the correction: {_expected(correction.after)}"


def next_lines(found: Result) -> Iterator[str]:
    """Yield lines on a fold that was learned after measured folds: its correction and its expected outcome."""
    for hand, shift in zip(HANDS, found.task.shift, strict=False):
        yield f"{hand} hand, shift of every trial: {shift_text(shift)}"
    if found.success is not None:
        spread = found.success.mean_vertex_distance
        yield f"expected: median distance {1e3 * spread.median:.1f} mm (90 % within {1e3 * spread.q90:.1f} mm)"


def shift_text(shift: HandShift) -> str:
    """Return the shifts of a hand's grasp and release, and its change of height [mm]."""
    grasp, release = (f"{1e3 * along:+.1f}, {1e3 * across:+.1f}" for along, across in (shift.grasp, shift.release))
    return f"grasp {grasp} mm, release {release} mm (along, across), height {1e3 * shift.height:+.1f} mm"


def _expected(end: Expected) -> str:
    low, high = (1e3 * value for value in end.distance_interval)
    return (
        f"mean distance {1e3 * end.distance:.1f} mm (90 % interval {low:.1f} to {high:.1f} mm), within the limit in "
        f"{100 * end.within:.0f} % of folds"
    )
