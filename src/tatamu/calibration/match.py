"""Find the parameter at which the simulated reading equals the measured reading, in few simulations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

MAX_STEP = 2.0
"""Largest step of the search, as a change of the parameter's logarithm."""


@dataclass(frozen=True)
class Match:
    """The result of a search for a parameter."""

    parameter: float
    reading: float
    reached: bool
    """Whether the reading was reached. If not, the parameter with the nearest reading is kept."""
    samples: tuple[tuple[float, float], ...]
    """All simulated values of the parameter in rising order, each with its reading."""

    def after(self, earlier: tuple[tuple[float, float], ...]) -> Match:
        """Return this result with the samples of an earlier search added."""
        return replace(self, samples=tuple(sorted({*earlier, *self.samples})))


def match(
    reading: Callable[[float], float],
    target: float,
    start: float,
    limits: tuple[float, float],
    within: float,
    straight: Callable[[float], float],
    rising: bool = False,
) -> Match:
    """Search for a parameter by a secant method whose steps stay between bounds of the solution.

    The reading must depend monotonically on the parameter.

    Args:
        reading: Function that simulates the reading for a parameter. It returns infinity if the cloth is too soft to
            simulate.
        target: Measured reading.
        start: First value of the parameter.
        limits: Smallest and largest value of the parameter.
        within: Largest accepted difference between the simulated reading and the target.
        straight: Function of the reading that is nearly linear in the logarithm of the parameter.
        rising: Whether the reading rises with the parameter; otherwise it falls.
    """
    if rising:
        found = match(lambda at: _turned(reading(at)), -target, start, limits, within, lambda value: -straight(-value))
        samples = tuple((parameter, -value) for parameter, value in found.samples)
        return replace(found, reading=_turned(found.reading), samples=samples)
    seen: dict[float, float] = {}
    low, high = np.log(limits)
    at = float(np.clip(np.log(start), low, high))
    for _ in range(16):
        if at not in seen:
            seen[at] = reading(float(np.exp(at)))
        if abs(seen[at] - target) <= within:
            return _found(at, seen, True)
        if seen[at] > target:
            low = at  # the reading falls with the parameter, so the parameter must be larger
        else:
            high = at
        if high - low < 1e-6:
            break
        at = _next(seen, target, straight, low, high)
    nearest = min(seen, key=lambda each: abs(seen[each] - target))
    return _found(nearest, seen, False)


def _turned(reading: float) -> float:
    """Return a reading with the opposite sign. Infinity remains, because it stands for a failed simulation."""
    return reading if np.isinf(reading) else -reading


def _found(at: float, seen: dict[float, float], reached: bool) -> Match:
    samples = tuple((float(np.exp(each)), seen[each]) for each in sorted(seen) if np.isfinite(seen[each]))
    return Match(float(np.exp(at)), seen[at], reached, samples)


def _next(
    seen: dict[float, float], target: float, straight: Callable[[float], float], low: float, high: float
) -> float:
    """Return the next value of the parameter's logarithm, inside the bracket from `low` to `high`.

    The next value follows from the secant through the two samples whose readings are nearest to the target.
    """
    last = list(seen)[-1]
    finite = sorted((each for each in seen if np.isfinite(seen[each])), key=lambda each: abs(seen[each] - target))
    if not np.isfinite(seen[last]):
        wanted = last + MAX_STEP / 2
    elif len(finite) == 1:
        wanted = last + np.log(1.25) * np.sign(seen[last] - target)
    else:
        a, b = finite[:2]
        slope = (straight(seen[b]) - straight(seen[a])) / (b - a)
        step = (straight(target) - straight(seen[a])) / slope if slope < 0 else np.inf
        wanted = a + float(np.clip(step, -MAX_STEP, MAX_STEP))
    if not low < wanted < high:
        edge = high if wanted >= high else low
        wanted = edge if edge not in seen else 0.5 * (low + high)
    return float(wanted)
