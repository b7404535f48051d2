"""The correction of the next fold: it undoes the expected systematic errors of hands, grasps and table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tatamu.after.feedback.emulator import Emulator
from tatamu.after.feedback.posterior import Posterior
from tatamu.evaluation.disturbances import Disturbances, Scenario, disturbed_scene, hand_errors, mean_scenario
from tatamu.evaluation.disturbances.channels import prefix_in
from tatamu.folding.fold import Fold as TargetFold
from tatamu.folding.manipulation import HandShift, Manipulation
from tatamu.folding.score import MARKS, Limits
from tatamu.study.result import Result

CORRECTABLE = ("hands.offset", "hands.difference", "hands.yaw", "cloth.place", "table.height")
"""Beginnings of the names of disturbances that are corrected.

Errors of the grasp are mostly new in each fold, and a grasp that is shifted outwards could miss the cloth."""
MIN_SHIFT = 0.0005
"""Smallest shift of a hand for which a correction is made [m]."""
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
    within: float
    """Share of next folds whose judged distance is within its limit."""

    @classmethod
    def of(cls, posterior: Posterior, emulator: Emulator, change: np.ndarray) -> Expected:
        """Return the expected outcome of a fold with a correction, shape (k,)."""
        ends = posterior.ends(emulator, change)
        distances = emulator.distances(ends)
        low, high = np.quantile(distances, INTERVAL)
        marks = emulator.marks(posterior.mean + change)
        within = float((emulator.judged_distances(ends) <= Limits().mean_vertex_distance).mean())
        spread = (float(low), float(high))
        return cls(marks, np.quantile(ends, INTERVAL, axis=0).T, float(distances.mean()), spread, within)

    def describe(self) -> dict[str, object]:
        """Return plain data for a file."""
        return {
            "mean_vertex_distance": self.distance,
            "interval": list(self.distance_interval),
            "within": self.within,
            "marks": dict(zip(MARKS, self.marks.tolist(), strict=True)),
        }


@dataclass(frozen=True)
class Correction:
    """The correction of the next fold, and its expected outcomes."""

    folds: int
    """Number of measured folds from which the correction follows."""
    change: np.ndarray
    """The correction as a change of disturbances, shape (k,)."""
    shifts: tuple[HandShift, ...]
    """Shift of each hand from the fold as it was learned, left before right; empty if nothing is corrected."""
    before: Expected
    """Expected outcome without the correction."""
    after: Expected
    """Expected outcome with the correction."""

    @property
    def is_none(self) -> bool:
        """Whether nothing is corrected."""
        return not self.shifts

    def describe(self) -> dict[str, object]:
        """Return the contents of `correction.json`."""
        return {
            "version": 1,
            "observed": self.folds,
            "hands": [shift.model_dump() for shift in self.shifts],
            "expected": {"before": self.before.describe(), "after": self.after.describe()},
        }


def find_correction(posterior: Posterior, emulator: Emulator, learned: Result) -> Correction:
    """Return the correction that undoes the expected systematic errors."""
    shifts = shifts_against(learned.task.fold, learned.manipulation, posterior.scenario)
    largest = max(abs(value) for shift in shifts for value in (*shift.grasp, *shift.release, shift.height))
    if not posterior.used or largest < MIN_SHIFT:
        shifts = ()
    change = emulator.moved(as_disturbances(shifts, ()))
    before, after = (Expected.of(posterior, emulator, each) for each in (0.0 * change, change))
    return Correction(len(posterior.chances), change, shifts, before, after)


def shifts_against(fold: TargetFold, manipulation: Manipulation, scenario: Scenario) -> tuple[HandShift, ...]:
    """Return the shift of each hand that undoes the `CORRECTABLE` errors of a scenario.

    Hands are raised but never lowered: a hand that is too high costs little, and one that is too low meets the table or
    drags the cloth.
    """
    undone = {name: value for name, value in scenario.values.items() if prefix_in(name, CORRECTABLE)}
    return tuple(
        HandShift(grasp=_metres(-grasp), release=_metres(-hand[:2]), height=max(0.0, _metres(-hand[2:])[0]))
        for grasp, hand in hand_errors(fold, manipulation, Scenario(undone))
    )


def corrected(learned: Result, correction: Correction, disturbances: Disturbances) -> Result:
    """Return a learned fold with a correction.

    The corrected real fold should end like the learned one, whose rollout is kept. The scene has the corrected hands
    with their expected errors. `disturbances` is the posterior.
    """
    task = replace(learned.task, shift=added(learned.task.shift, correction.shifts))
    manipulation = task.manipulation(learned.best.parameters)
    description = learned.record.task.model_copy(update={"shift": list(task.shift) or None})
    record = learned.record.model_copy(
        update={"task": description, "disturbances": disturbances.describe(), "success": None}
    )
    scene = disturbed_scene(task.fold, manipulation, mean_scenario(disturbances))
    return Result(record, manipulation, scene, learned.rollout, None, task)


def _metres(values: np.ndarray) -> list[float]:
    """Return lengths rounded to 0.01 mm [m]."""
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
    """Return the change of disturbances, by their names, that has the effect of shifts minus other shifts."""
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
