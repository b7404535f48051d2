"""Reads the periods and the decrements of a signal that swings freely about its position of rest.

The period T is read from the zero crossings of the signal. The decrement delta is read from the extremes a_k, the
largest deflections between two crossings:

    T = time between two crossings in the same direction,    delta = 2 ln((a_k + a_(k+1)) / (a_(k+1) + a_(k+2)))

A small error of the position of rest has little effect on these formulas.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np


@dataclass(frozen=True)
class FreeSwing:
    """One period of a free oscillation, between two zero crossings in the same direction."""

    start: float
    """Start of the period [s]."""
    period: float
    """Length of the period [s]."""
    amplitude: float
    """Amplitude from peak to peak [m]: the sum of the sizes of the two extremes of the period."""
    decrement: float
    """Logarithmic decrement per period [-]; NaN if no extreme follows the period."""

    @property
    def end(self) -> float:
        """End of the period [s]."""
        return self.start + self.period


def swings(times: np.ndarray, signal: np.ndarray, least: float) -> list[FreeSwing]:
    """Return all periods of a signal that swings about 0 and whose extremes are large enough.

    Args:
        times: Increasing times [s], shape (k,).
        signal: Values of the signal [m], shape (k,).
        least: Least size of an extreme [m]. Smaller extremes count as noise.
    """
    crossings = _crossings(times, signal)
    extremes = [_extreme(times, signal, start, end) for start, end in pairwise(crossings)]
    found = []
    for k, (first, second) in enumerate(pairwise(extremes)):
        if min(first, second) < least:
            continue
        third = extremes[k + 2] if k + 2 < len(extremes) else 0.0
        decrement = 2.0 * np.log((first + second) / (second + third)) if third >= least else np.nan
        found.append(FreeSwing(crossings[k], crossings[k + 2] - crossings[k], first + second, float(decrement)))
    return found


def _crossings(times: np.ndarray, signal: np.ndarray) -> list[float]:
    """Return the times at which the signal passes 0 [s], found by linear interpolation."""
    change = np.flatnonzero(np.sign(signal[:-1]) * np.sign(signal[1:]) < 0)
    part = signal[change] / (signal[change] - signal[change + 1])
    return list(times[change] + part * (times[change + 1] - times[change]))


def _extreme(times: np.ndarray, signal: np.ndarray, start: float, end: float) -> float:
    """Return the size of the extreme between two crossings [m].

    The extreme is the vertex of a parabola through the largest sample and its two neighbours.
    """
    inside = np.flatnonzero((times > start) & (times < end))
    if not len(inside):
        return 0.0
    top = int(inside[np.abs(signal[inside]).argmax()])
    if not 0 < top < len(signal) - 1:
        return float(abs(signal[top]))
    near = slice(top - 1, top + 2)
    a, b, c = np.polyfit(times[near] - times[top], np.abs(signal[near]), 2)
    if not a < 0.0:
        return float(abs(signal[top]))
    highest = c - b * b / (4.0 * a)
    return float(min(max(highest, abs(signal[top])), 1.3 * abs(signal[top])))
