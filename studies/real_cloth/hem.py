"""The hem of a draped disc as seen from above, with measures that others have published, and wavy discs."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tatamu.calibration.instruments.drapemeter import Drapemeter
from tatamu.calibration.instruments.outline import PlanOutline
from tatamu.simulation.rollout import Rollout

WAVE = 0.02
"""Length of the waves of wavy cloth [m]: heights at the distance d have the correlation exp(-d² / (2 WAVE²))."""
WAVES = 200
"""Number of cosine waves whose sum is the height of wavy cloth."""


class Hem(PlanOutline):
    """The outline of a draped disc from above."""

    @property
    def amplitude(self) -> float:
        """Half the difference between the mean radii of nodes and troughs [m]; 0 with fewer than two nodes."""
        peaks = self.peaks
        if len(peaks) < 2:
            return 0.0
        around = np.append(peaks, peaks[0] + len(self.radii))
        pairs = pairwise(around)
        troughs = [self.radii[np.arange(a, b) % len(self.radii)].min() for a, b in pairs]
        return float(0.5 * (self.radii[peaks].mean() - np.mean(troughs)))

    @property
    def wavelength(self) -> float:
        """Circumference of a circle with the mean radius, per node [m]; infinite without nodes."""
        return float(2.0 * np.pi * self.radii.mean() / self.nodes) if self.nodes else np.inf

    def harmonic(self, order: int) -> float:
        """Return the amplitude of a harmonic of the radii [m].

        The second harmonic is large if the cloth bends differently along warp and weft.
        """
        return float(2.0 * np.abs(np.fft.rfft(self.radii)[order]) / len(self.radii))


@dataclass(frozen=True)
class WavyDrapemeter(Drapemeter):
    """A drapemeter whose unstrained cloth is wavy outside the plate."""

    waviness: float = 0.0
    """Standard deviation of the height of the unstrained cloth [m]."""

    @property
    def unstrained(self) -> np.ndarray:
        if not self.waviness:
            return super().unstrained
        points, _ = self.mesh
        random = np.random.default_rng([self.seed, 2])
        waves = random.standard_normal((2, WAVES)) / WAVE
        phases = random.uniform(0.0, 2.0 * np.pi, WAVES)
        height = self.waviness * np.sqrt(2.0 / WAVES) * np.cos(points @ waves + phases).sum(axis=1)
        beyond = np.hypot(*points.T) - self.plate - self.row
        return np.column_stack([points, np.clip(beyond / WAVE, 0.0, 1.0) * height])

    def outline(self, rollout: Rollout, frame: int = -1) -> Hem:
        """Return the outline of the cloth from above, with the plate's axis at the origin."""
        return Hem.of(rollout.positions[frame], rollout.faces, np.zeros(2))
