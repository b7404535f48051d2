"""What a simulated reading has to become, and where a reading tells no more than a bound."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import logit

from tatamu.calibration.laboratory import Laboratory, Test
from tatamu.calibration.match import Match, match
from tatamu.calibration.push import Push
from tatamu.calibration.readings import Reading
from tatamu.calibration.sag import Sag
from tatamu.calibration.setup import Setup
from tatamu.errors import SimulationError
from tatamu.material import Material

STRETCH, BENDING, COMPRESSION = (1.0, 1e5), (1e-8, 1e-2), (0.01, 1.0)
"""Ranges in which the parameters are searched [N/m], [N m], [-]."""
WITHIN, FINEST = 1e-3, 1e-5
"""Readings are matched to this part of themselves, or to this length [m] where that is more."""
STIFFEST, LIMPEST = 0.02, 0.96
"""A sag over free length outside these only says that the bending length is far longer, or far shorter."""


@dataclass(frozen=True)
class Target:
    """The reading of one test and the parameter that it tells."""

    test: Test
    parameter: str
    measured: float
    """[m]"""
    uncertainty: float
    """Standard uncertainty of the reading [m]."""
    bound: str | None
    """None, or "at least" or "at most" where the reading tells only that much of the parameter."""
    guess: Callable[[float, float], float]
    """(reading, density) to the parameter by a textbook."""
    limits: tuple[float, float]
    straight: Callable[[float], float]
    """Of the reading: nearly a straight line of the logarithm of the parameter."""
    rising: bool = False
    """Whether the reading rises with the parameter."""
    spread: float = 1.0
    """What the test's own readings leave of the logarithm of the parameter: its standard uncertainty by the textbook.
    Tests of one parameter weigh by it."""

    @property
    def aim(self) -> float:
        """What is matched [m]: the reading, or, of a bound, the reading moved by its uncertainty to where it tells."""
        towards = {None: 0.0, "at least": 1.0, "at most": -1.0}[self.bound] * (-1.0 if self.rising else 1.0)
        return self.measured + towards * self.uncertainty

    def start(self, density: float) -> float:
        """The parameter by the textbook, within its limits: where the search begins."""
        return float(np.clip(self.guess(max(self.aim, 1e-5), density), *self.limits))

    def matched(self, laboratory: Laboratory, material: Material, start: float) -> Match:
        """The parameter at which the laboratory's simulator gives the aim, all else as in `material`.

        Raises:
            SimulationError: The simulator gave up whatever the parameter.
        """

        def reading(value: float) -> float:
            return laboratory.reading(self.test, material.model_copy(update={self.parameter: value}))

        within = max(WITHIN * self.aim, FINEST)
        found = match(reading, self.aim, start, self.limits, within, self.straight, self.rising)
        if not np.isfinite(found.reading):
            raise SimulationError(f"{self.test.name}: {laboratory.simulator} gave up: {laboratory.failure}")
        return found

    def bound_by(self, found: Match) -> str | None:
        """`bound`, or that of a search that ended where the simulator cannot come nearer to the reading."""
        if self.bound is not None or found.reached or abs(found.reading - self.aim) <= self.uncertainty:
            return self.bound
        return "at most" if (found.reading < self.aim) != self.rising else "at least"


def targets_of(setup: Setup, readings: dict[str, Reading]) -> list[Target]:
    """The tests that are matched by a length: elongation, sag and loop, in this order."""
    targets = []
    if setup.elongation is not None:
        hanging, lying = readings["L1"], readings["L2"]
        longer = hanging.value - lying.value
        error = float(np.hypot(hanging.uncertainty, lying.uncertainty))
        bound = "at least" if longer < error else None
        targets.append(
            Target(
                setup.elongation,
                "stretch_stiffness",
                longer,
                error,
                bound,
                setup.elongation.guess,
                STRETCH,
                lambda value: float(np.log(max(value, 1e-9))),
            )
        )
    if setup.sag is not None:
        sag, length, free = readings["sag"], readings["free_length"], setup.sag.free_length
        targets.append(
            Target(
                setup.sag,
                "bending_rigidity",
                sag.value,
                sag.uncertainty,
                sag_bound(sag, free),
                setup.sag.guess,
                BENDING,
                lambda value: float(logit(np.clip(value / free, 1e-4, 1.0 - 1e-4))),
                spread=float(
                    np.hypot(
                        _spread(setup.sag.guess, sag),
                        _spread(lambda free, density: Sag(free).guess(sag.value, density), length),
                    )
                ),
            )
        )
    if setup.loop is not None:
        height, layers = readings["height"], 2.0 * setup.loop.thickness
        targets.append(
            Target(
                setup.loop,
                "bending_rigidity",
                height.value,
                height.uncertainty,
                "at most" if height.value - height.uncertainty < layers else None,
                setup.loop.guess,
                BENDING,
                lambda value: float(np.log(max(value - 0.5 * layers, 1e-4))),
                rising=True,
                spread=_spread(setup.loop.guess, height),
            )
        )
    return targets


def push_target(push: Push, material: Material, readings: dict[str, Reading]) -> Target:
    """The test of a push, which is matched last, once friction is known."""
    pushed, moved = readings["pushed"], readings["moved"]
    error = float(np.hypot(pushed.uncertainty, moved.uncertainty))
    return Target(
        push,
        "compression",
        moved.value,
        error,
        "at most" if moved.value < error else "at least" if moved.value > pushed.value - error else None,
        lambda reading, _: push.guess(reading, material),
        COMPRESSION,
        lambda value: float(-np.log(max(pushed.value - value, 1e-5))),
        rising=True,
    )


def _spread(guess: Callable[[float, float], float], reading: Reading) -> float:
    """Standard uncertainty of the logarithm of a parameter from that of a reading, by the textbook."""
    more, less = (guess(reading.value + step, 1.0) for step in (reading.uncertainty, -reading.uncertainty))
    return max(0.5 * abs(float(np.log(more / less))), 1e-6)


def by_parameter(targets: list[Target]) -> dict[str, list[Target]]:
    """Parameter to the tests that tell it; a test that only bounds it is left out where another one tells it."""
    groups: dict[str, list[Target]] = {}
    for target in targets:
        groups.setdefault(target.parameter, []).append(target)
    return {
        parameter: [target for target in group if target.bound is None] or group[-1:]
        for parameter, group in groups.items()
    }


def weights(group: list[Target]) -> np.ndarray:
    """How much each test of one parameter has to say: inverse squares of their spreads, with the sum 1, shape (k,)."""
    inverse = np.array([target.spread**-2.0 for target in group])
    return np.asarray(inverse / inverse.sum())


def sag_bound(sag: Reading, free_length: float) -> str | None:
    """Whether cloth hangs too straight down, or stands out too level, for its sag to tell bending."""
    if sag.value + sag.uncertainty > LIMPEST * free_length:
        return "at most"
    return "at least" if sag.value - sag.uncertainty < STIFFEST * free_length else None
