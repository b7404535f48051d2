"""The plan outline of a draped disc, and the measures read from it.

Seen from above, the hem of a cloth over a round plate is a curve r(phi) about the plate's axis. The drape coefficient
(Cusick 1968; BS 5058, ISO 9073-9) compares its area with those of the flat specimen and of the plate:

    DC = (A_outline - A_plate) / (A_specimen - A_plate)

A node is a fold of the hem: a local maximum of r with a prominence above `PROMINENCE`.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.signal import find_peaks

from tatamu.topology import Topology

ANGLES = 360
"""Number of angles of an outline: one for each degree."""
TOUCHING = 1e-9
"""Tolerance at a segment's ends, as a fraction of the segment, so that no ray slips between two segments."""
PROMINENCE = 0.003
"""Least prominence of a node [m]."""


@dataclass(frozen=True)
class PlanOutline:
    """Radii of the outline about the plate's axis."""

    radii: np.ndarray
    """Radii at evenly spaced angles from 0 [m], shape (k,)."""

    @classmethod
    def of(cls, positions: np.ndarray, faces: np.ndarray, centre: np.ndarray, angles: int = ANGLES) -> PlanOutline:
        """Return the silhouette of a mesh from above: the extent of the cloth at each angle.

        Args:
            positions: Positions of the vertices [m], shape (n, 3).
            faces: Triangles, shape (m, 3).
            centre: Centre of the plate [m], shape (2,); the cloth surrounds it.
            angles: Number of angles.
        """
        plan = positions[:, :2] - centre
        return cls(_reach(plan[Topology(faces).edges], angles))

    @classmethod
    def of_curve(cls, curve: np.ndarray, centre: np.ndarray, angles: int = ANGLES) -> PlanOutline:
        """Return the outline of a closed curve without its closing point [m], shape (k, 2), such as from a photo."""
        plan = np.asarray(curve) - centre
        return cls(_reach(np.stack([plan, np.roll(plan, -1, axis=0)], axis=1), angles))

    @property
    def curve(self) -> np.ndarray:
        """The closed curve about the plate's axis [m], shape (k + 1, 2)."""
        angles = 2.0 * np.pi * np.arange(len(self.radii) + 1) / len(self.radii)
        radii = np.append(self.radii, self.radii[0])
        return radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])

    @property
    def area(self) -> float:
        """Enclosed area [m^2]."""
        step = 2.0 * np.pi / len(self.radii)
        turned = np.roll(self.radii, -1)
        return float(0.5 * np.sin(step) * (self.radii * turned).sum())

    def drape_coefficient(self, specimen: float, plate: float) -> float:
        """Return the drape coefficient [-] of a specimen and a plate of these radii [m]."""
        covered = np.pi * plate**2
        return float((self.area - covered) / (np.pi * specimen**2 - covered))

    @property
    def peaks(self) -> np.ndarray:
        """Indices of the nodes among the radii, shape (k,)."""
        start = int(self.radii.argmin())
        once = np.append(np.roll(self.radii, -start), self.radii[start])
        return np.sort((find_peaks(once, prominence=PROMINENCE)[0] + start) % len(self.radii))

    @property
    def nodes(self) -> int:
        """Number of folds of the hem."""
        return len(self.peaks)

    @property
    def amplitude(self) -> float:
        """Half of the mean distance of nodes beyond the troughs between them [m]; 0 with fewer than two nodes."""
        peaks = self.peaks
        if len(peaks) < 2:
            return 0.0
        around = np.append(peaks, peaks[0] + len(self.radii))
        pairs = pairwise(around)
        troughs = [self.radii[np.arange(a, b) % len(self.radii)].min() for a, b in pairs]
        return float(0.5 * (self.radii[peaks].mean() - np.mean(troughs)))

    @property
    def wavelength(self) -> float:
        """Wavelength of the hem in plan: the mean circle over the nodes [m]; infinite without nodes."""
        return float(2.0 * np.pi * self.radii.mean() / self.nodes) if self.nodes else np.inf

    def harmonic(self, order: int) -> float:
        """Return the amplitude of a harmonic of r(phi) [m]; the second distinguishes warp from weft."""
        return float(2.0 * np.abs(np.fft.rfft(self.radii)[order]) / len(self.radii))


def centroid(curve: np.ndarray) -> np.ndarray:
    """Return the centroid of a closed curve's area [m], shape (2,): the plate's position under a centred disc."""
    turned = np.roll(curve, -1, axis=0)
    across = curve[:, 0] * turned[:, 1] - turned[:, 0] * curve[:, 1]
    return np.asarray(((curve + turned) * across[:, None]).sum(axis=0) / (3.0 * across.sum()))


def _reach(segments: np.ndarray, angles: int) -> np.ndarray:
    """Return the farthest crossing of each ray from the origin with segments [m], shape (k,); 0 without a crossing.

    Args:
        segments: Ends of the segments [m], shape (s, 2, 2).
        angles: Number of rays.
    """
    start = segments[:, 0]
    along = segments[:, 1] - start
    radii = np.zeros(angles)
    for number, angle in enumerate(2.0 * np.pi * np.arange(angles) / angles):
        ray = np.array([np.cos(angle), np.sin(angle)])
        across = along[:, 0] * ray[1] - along[:, 1] * ray[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            part = -(start[:, 0] * ray[1] - start[:, 1] * ray[0]) / across
            reach = (start + part[:, None] * along) @ ray
        hit = (part >= -TOUCHING) & (part <= 1.0 + TOUCHING)
        radii[number] = max(0.0, reach[hit].max(initial=0.0))
    return radii
