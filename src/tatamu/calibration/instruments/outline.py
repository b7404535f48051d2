"""Computes the outline of a draped disc of cloth from above, and measures of this outline.

A disc of cloth hangs over a round plate. Seen from above, its hem is a curve r(phi): the distance r from the plate's
axis at the angle phi. The drape coefficient DC (Cusick 1968; BS 5058, ISO 9073-9) compares three areas. They are the
area inside the outline, the flat specimen, and the plate:

    DC = (A_outline - A_plate) / (A_specimen - A_plate)

In a drape test, a *node* is a fold of the hem that stands out from the plate: a local maximum of r with a prominence
above 3 mm.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from tatamu.simulation.mesh.topology import Topology

ANGLES = 360
"""Default number of angles of an outline, one for each degree."""
TOUCHING = 1e-9
"""Tolerance at the ends of a segment, as a fraction of its length. Without this tolerance, a ray might pass between two
neighbouring segments."""


@dataclass(frozen=True)
class PlanOutline:
    """The outline of a draped disc from above, as radii about the plate's axis."""

    radii: np.ndarray
    """Radii at equally spaced angles, starting at the angle 0 [m], shape (k,)."""

    @classmethod
    def of(cls, positions: np.ndarray, faces: np.ndarray, centre: np.ndarray, angles: int = ANGLES) -> Self:
        """Return the outline of a mesh from above: the largest distance of the cloth from the centre at each angle.

        Args:
            positions: Positions of the vertices [m], shape (n, 3).
            faces: Triangles, shape (m, 3).
            centre: Centre of the plate, which is inside the cloth [m], shape (2,).
            angles: Number of angles.
        """
        plan = positions[:, :2] - centre
        return cls(_reach(plan[Topology(faces).edges], angles))

    @classmethod
    def of_curve(cls, curve: np.ndarray, centre: np.ndarray, angles: int = ANGLES) -> Self:
        """Return the outline of a closed curve, such as a curve from a photo.

        The curve has points [m] of shape (k, 2), and its first point is not repeated at the end.
        """
        plan = np.asarray(curve) - centre
        return cls(_reach(np.stack([plan, np.roll(plan, -1, axis=0)], axis=1), angles))

    @property
    def curve(self) -> np.ndarray:
        """Points of the closed outline relative to the plate's axis [m], shape (k + 1, 2)."""
        angles = 2.0 * np.pi * np.arange(len(self.radii) + 1) / len(self.radii)
        radii = np.append(self.radii, self.radii[0])
        return radii[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])

    @property
    def area(self) -> float:
        """Area inside the outline [m^2]."""
        step = 2.0 * np.pi / len(self.radii)
        turned = np.roll(self.radii, -1)
        return float(0.5 * np.sin(step) * (self.radii * turned).sum())

    def drape_coefficient(self, specimen: float, plate: float) -> float:
        """Return the drape coefficient [-] for a flat cloth and a plate with the given radii [m]."""
        covered = np.pi * plate**2
        return float((self.area - covered) / (np.pi * specimen**2 - covered))

    @property
    def peaks(self) -> np.ndarray:
        """Indices of the radii at the nodes, the outermost points of the hem's folds, shape (k,)."""
        from scipy.signal import find_peaks  # this import takes half a second

        start = int(self.radii.argmin())
        once = np.append(np.roll(self.radii, -start), self.radii[start])
        return np.sort((find_peaks(once, prominence=0.003)[0] + start) % len(self.radii))

    @property
    def nodes(self) -> int:
        """Number of nodes. A node is a fold of the hem, where the radius has a local maximum."""
        return len(self.peaks)


def centroid(curve: np.ndarray) -> np.ndarray:
    """Return the centroid of the area inside a closed curve [m], shape (2,).

    If the disc is centred on the plate, the centroid is the centre of the plate.
    """
    turned = np.roll(curve, -1, axis=0)
    across = curve[:, 0] * turned[:, 1] - turned[:, 0] * curve[:, 1]
    return np.asarray(((curve + turned) * across[:, None]).sum(axis=0) / (3.0 * across.sum()))


def _reach(segments: np.ndarray, angles: int) -> np.ndarray:
    """Return the distance at which each ray from the origin crosses the segments for the last time [m], shape (k,).

    The distance is 0 for a ray that crosses no segment.

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
