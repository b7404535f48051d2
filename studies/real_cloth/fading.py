"""Computes the period and the decrement of a cloth that swings while the bar that holds it is still.

The logarithmic decrement describes how fast the swing decays.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from studies.real_cloth.recording import Recording
from tatamu.calibration.instruments.oscillation import FreeSwing, swings

STILL = 0.05
"""Largest speed of the bar that holds a cloth [m/s]. If the bar moves faster, the cloth does not count as swinging
freely."""
MIN_AMPLITUDE = 0.004
"""Smallest distance from rest at which a cloth may turn back in a swing [m]. Smaller movements count as noise."""
AMPLITUDES = (0.02, 0.04, 0.06)
"""Amplitudes of a swinging cloth, from peak to peak, at which decrements are compared [m]."""


def free_swings(recording: Recording, swing: np.ndarray) -> list[FreeSwing]:
    """Return the periods of a cloth's swing during which the bar that holds the cloth is still.

    The argument `swing` has a value for each frame of the recording [m].
    """
    times, corners = recording.path
    speed = np.linalg.norm(np.gradient(corners.mean(axis=1), times, axis=0), axis=1)
    seen = np.isfinite(swing)
    order = np.argsort(recording.clock[seen])  # corrected times may not be in order
    found = swings(recording.clock[seen][order], swing[seen][order], MIN_AMPLITUDE)
    return [each for each in found if speed[(times >= each.start) & (times <= each.end)].max(initial=0.0) < STILL]


def free_motion(signals: Sequence[np.ndarray], measured: Sequence[Recording]) -> tuple[float, np.ndarray, int]:
    """Return the period of the free swings of a cloth as a median [s], their decrements, and the number of periods.

    The decrements are at `AMPLITUDES`.
    """
    found = [each for recording, swing in zip(measured, signals, strict=True) for each in free_swings(recording, swing)]
    fading = [each for each in found if np.isfinite(each.decrement)]
    if len(fading) < 3:
        return (float(np.median([each.period for each in found])) if found else np.nan), np.full(3, np.nan), len(found)
    decrements = decrement_line(np.array([(each.amplitude, each.decrement) for each in fading]))
    return float(np.median([each.period for each in found])), decrements, len(found)


def decrement_line(fading: np.ndarray) -> np.ndarray:
    """Return the decrements of a swing at `AMPLITUDES`, from a straight line of decrement over amplitude.

    The line is fitted to the measured amplitudes [m] and decrements of k periods, shape (k, 2).
    """
    amplitudes, decrements = fading.T
    return np.asarray(np.polyval(np.polyfit(amplitudes, decrements, 1), np.array(AMPLITUDES)))
