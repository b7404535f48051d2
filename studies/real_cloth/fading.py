"""Period and decrement of a cloth that swings while its bar is still."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from studies.real_cloth.recording import Recording
from tatamu.instruments.oscillation import FreeSwing, swings

STILL = 0.05
"""A bar slower than this [m/s] lets the cloth swing freely."""
LEAST = 0.004
"""Smaller extremes of a swing are noise [m]."""
AMPLITUDES = (0.02, 0.04, 0.06)
"""Amplitudes from peak to peak at which decrements are compared [m]."""


def free_swings(recording: Recording, swing: np.ndarray) -> list[FreeSwing]:
    """The swings of a signal at the recording's frames during which the bar is still."""
    times, corners = recording.path
    speed = np.linalg.norm(np.gradient(corners.mean(axis=1), times, axis=0), axis=1)
    seen = np.isfinite(swing)
    order = np.argsort(recording.clock[seen])  # clocks of their own may overtake one another
    found = swings(recording.clock[seen][order], swing[seen][order], LEAST)
    return [each for each in found if speed[(times >= each.start) & (times <= each.end)].max(initial=0.0) < STILL]


def free_motion(signals: Sequence[np.ndarray], measured: Sequence[Recording]) -> tuple[float, np.ndarray, int]:
    """Median period [s], decrements at `AMPLITUDES`, and the number of swings."""
    found = [each for recording, swing in zip(measured, signals, strict=True) for each in free_swings(recording, swing)]
    fading = [each for each in found if np.isfinite(each.decrement)]
    if len(fading) < 3:
        return (float(np.median([each.period for each in found])) if found else np.nan), np.full(3, np.nan), len(found)
    decrements = decrement_line(np.array([(each.amplitude, each.decrement) for each in fading]))
    return float(np.median([each.period for each in found])), decrements, len(found)


def decrement_line(fading: np.ndarray) -> np.ndarray:
    """Decrements at `AMPLITUDES`, by the line through amplitudes [m] and decrements of swings, shape (k, 2)."""
    amplitudes, decrements = fading.T
    return np.asarray(np.polyval(np.polyfit(amplitudes, decrements, 1), np.array(AMPLITUDES)))
