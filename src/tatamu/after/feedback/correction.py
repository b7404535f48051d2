"""The correction of the next fold: it undoes the expected systematic errors of hands, grasps and table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.after.feedback.emulator import Emulator
from tatamu.after.feedback.posterior import Posterior
from tatamu.evaluation.disturbances import World, hand_errors
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import Manipulation
from tatamu.folding.marks import MARKS
from tatamu.folding.shift import HandShift

CORRECTABLE = ("hands.offset", "hands.difference", "hands.yaw", "grasp", "cloth.place", "table.height")
"""Beginnings of the names of disturbances that a shift of grasp, release and height can correct."""
PARTS = (1.0, 0.75, 0.5, 0.25)
"""Fractions of the expected error whose correction is tried, the whole error first."""
WORTH = 0.0015
"""Least expected decrease of the fold's distance from its target for which a correction is made [m].

It is the error of a ruler. Smaller expected gains make as many set-ups worse as better (docs/notes/observation.md).
"""
INTERVAL = (0.05, 0.95)
"""Quantiles of a 90 % interval."""


@dataclass(frozen=True)
class Expected:
    """The expected outcome of the next fold."""

    marks: np.ndarray
    """Means of the marks [m], shape (m,)."""
    intervals: np.ndarray
    """90 % intervals of the marks [m], shape (m, 2)."""
    distance: float
    """Expected mean vertex distance [m]."""
    distance_interval: tuple[float, float]
    """90 % interval of that distance [m]."""

    @classmethod
    def of(cls, posterior: Posterior, emulator: Emulator, correction: np.ndarray) -> Expected:
        """Return the expected outcome of a fold with a correction, shape (k,)."""
        ends = posterior.ends(emulator, correction)
        distances = emulator.distances(ends)
        low, high = np.quantile(distances, INTERVAL)
        interval = (float(low), float(high))
        return cls(ends.mean(axis=0), np.quantile(ends, INTERVAL, axis=0).T, float(distances.mean()), interval)

    def plain(self) -> dict[str, object]:
        """Return plain data for a file."""
        return {
            "mean_vertex_distance": self.distance,
            "interval": [float(value) for value in self.distance_interval],
            "marks": dict(zip(MARKS, self.marks.tolist(), strict=True)),
        }


@dataclass(frozen=True)
class Correction:
    """The correction of the next fold, and its expected outcomes."""

    change: np.ndarray
    """The correction as a change of disturbances, shape (k,)."""
    shifts: tuple[HandShift, ...]
    """Correction of each hand, from the fold as it was learned, left before right."""
    before: Expected
    """Expected outcome without the correction."""
    after: Expected
    """Expected outcome with the correction."""

    @property
    def is_none(self) -> bool:
        """Whether nothing is changed, because nothing is expected to help."""
        return not self.change.any()


def find_correction(posterior: Posterior, emulator: Emulator, fold: Fold, manipulation: Manipulation) -> Correction:
    """Return the correction with which the next fold is expected to end nearest to its target.

    Args:
        posterior: The posterior of the set-up.
        emulator: Emulator of the learned fold.
        fold: The learned fold.
        manipulation: Its manipulation as learned.
    """
    usable = [any(f"{name}.".startswith(f"{part}.") for part in CORRECTABLE) for name in posterior.names]
    whole = np.where(usable, -posterior.mean, 0.0)
    nothing = np.zeros(len(whole))
    before = Expected.of(posterior, emulator, nothing)
    tried = [(part * whole, Expected.of(posterior, emulator, part * whole)) for part in PARTS]
    change, after = min(tried, key=lambda each: each[1].distance)
    if not posterior.used or after.distance > before.distance - WORTH:
        change, after = nothing, before
    return Correction(change, _shifts(posterior, fold, manipulation, change), before, after)


def _shifts(posterior: Posterior, fold: Fold, manipulation: Manipulation, change: np.ndarray) -> tuple[HandShift, ...]:
    """Return the shift of each hand that corrects errors of minus `change`."""
    errors = World(dict(zip(posterior.names, (-change).tolist(), strict=True)))
    return shift_against(hand_errors(fold, manipulation, errors))


def shift_against(errors: Sequence[tuple[np.ndarray, np.ndarray]]) -> tuple[HandShift, ...]:
    """Return the shift of each hand that corrects errors in the form of `hand_errors`."""
    return tuple(
        HandShift(grasp=_metres(-grasp), release=_metres(-hand[:2]), height=_metres(-hand[2:])[0])
        for grasp, hand in errors
    )


def _metres(values: np.ndarray) -> list[float]:
    """Return lengths in metres, rounded to 0.01 mm [m]."""
    return [round(float(value), 5) + 0.0 for value in values]


def added(one: Sequence[HandShift], other: Sequence[HandShift]) -> tuple[HandShift, ...]:
    """Return two shifts of hands together; an empty one changes nothing."""
    if not one or not other:
        return tuple(one or other)
    return tuple(
        HandShift(
            grasp=[a + b for a, b in zip(first.grasp, second.grasp, strict=True)],
            release=[a + b for a, b in zip(first.release, second.release, strict=True)],
            height=first.height + second.height,
        )
        for first, second in zip(one, other, strict=True)
    )


def as_disturbances(shifts: Sequence[HandShift], less: Sequence[HandShift]) -> dict[str, float]:
    """Return the change of disturbances that shifts of hands amount to, by their names.

    Args:
        shifts: Correction of each hand, left before right; empty for none.
        less: Shifts that the learned fold already has.
    """
    hands = [_numbers(shifts, number) - _numbers(less, number) for number in range(max(len(shifts), len(less)))]
    if not hands:
        return {}
    middle = sum(hands) / len(hands)
    found = {f"hands.offset.{axis}": float(middle[place]) for place, axis in ((2, "along"), (3, "across"), (4, "up"))}
    for side, hand in zip(("left", "right"), hands, strict=False):
        found |= {f"grasp.into.{side}": float(hand[0]), f"grasp.along.{side}": float(hand[1])}
    if len(hands) > 1:
        apart = hands[0] - hands[1]
        found |= {
            f"hands.difference.{axis}": float(apart[place]) for place, axis in ((2, "along"), (3, "across"), (4, "up"))
        }
    return found


def _numbers(shifts: Sequence[HandShift], number: int) -> np.ndarray:
    if number >= len(shifts):
        return np.zeros(5)
    shift = shifts[number]
    return np.array([*shift.grasp, *shift.release, shift.height])
