"""Finding the parameter at which a simulated reading is the measured one, in few simulations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

FIRST_FACTOR = 1.25
"""Ratio of the second value tried to the first."""
LONGEST_STEP = 2.0
"""Largest step in the logarithm of the parameter."""
MOST = 16
"""Largest number of simulations of one search."""


@dataclass(frozen=True)
class Match:
    """The end of a search."""

    parameter: float
    reading: float
    reached: bool
    """Whether the reading was matched; if not, the parameter is the nearest end of its range."""
    samples: tuple[tuple[float, float], ...]
    """All (parameter, reading) that were simulated, in order of the parameter."""

    def after(self, earlier: tuple[tuple[float, float], ...]) -> Match:
        """Return this match with the samples of an earlier pass before its own."""
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
    """Safeguarded secant search of a parameter on which the reading depends monotonically.

    Args:
        reading: Function that simulates the reading of a parameter; infinite if the cloth is too soft to simulate.
        target: Measured reading.
        start: First parameter.
        limits: Smallest and largest parameter.
        within: Largest accepted difference between the reading and the target.
        straight: Function of the reading that is nearly linear in the logarithm of the parameter.
        rising: Whether the reading rises with the parameter instead of falling.
    """
    if rising:
        found = match(lambda at: _turned(reading(at)), -target, start, limits, within, lambda value: -straight(-value))
        samples = tuple((parameter, -value) for parameter, value in found.samples)
        return replace(found, reading=_turned(found.reading), samples=samples)
    seen: dict[float, float] = {}
    low, high = np.log(limits)
    at = float(np.clip(np.log(start), low, high))
    for _ in range(MOST):
        if at not in seen:
            seen[at] = reading(float(np.exp(at)))
        if abs(seen[at] - target) <= within:
            return _found(at, seen, True)
        if seen[at] > target:
            low = at  # falling: more of the parameter, less of the reading
        else:
            high = at
        if high - low < 1e-6:
            break
        at = _next(seen, target, straight, low, high)
    nearest = min(seen, key=lambda each: abs(seen[each] - target))
    return _found(nearest, seen, False)


def _turned(reading: float) -> float:
    """Return a reading with the opposite sign; infinity, which stands for a failed simulation, stays."""
    return reading if np.isinf(reading) else -reading


def _found(at: float, seen: dict[float, float], reached: bool) -> Match:
    samples = tuple((float(np.exp(each)), seen[each]) for each in sorted(seen) if np.isfinite(seen[each]))
    return Match(float(np.exp(at)), seen[at], reached, samples)


def _next(
    seen: dict[float, float], target: float, straight: Callable[[float], float], low: float, high: float
) -> float:
    """Return the next parameter by the secant through the two nearest samples, limited to the bracket."""
    last = list(seen)[-1]
    finite = sorted((each for each in seen if np.isfinite(seen[each])), key=lambda each: abs(seen[each] - target))
    if not np.isfinite(seen[last]):
        wanted = last + LONGEST_STEP / 2
    elif len(finite) == 1:
        wanted = last + np.log(FIRST_FACTOR) * np.sign(seen[last] - target)
    else:
        a, b = finite[:2]
        slope = (straight(seen[b]) - straight(seen[a])) / (b - a)
        step = (straight(target) - straight(seen[a])) / slope if slope < 0 else np.inf
        wanted = a + float(np.clip(step, -LONGEST_STEP, LONGEST_STEP))
    if not low < wanted < high:
        edge = high if wanted >= high else low
        wanted = edge if edge not in seen else 0.5 * (low + high)
    return float(wanted)
