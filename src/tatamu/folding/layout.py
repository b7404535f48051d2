"""A garment that lies on the table before a fold, and the line over which it is folded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tatamu.garments import Garment


@dataclass(frozen=True)
class FoldLine:
    """A straight fold line on the table, and the side of it that moves."""

    origin: np.ndarray
    """A point of the line [m], shape (2,)."""
    normal: np.ndarray
    """Unit vector across the fold line, from the moving side to the side that stays, shape (2,)."""

    @property
    def along(self) -> np.ndarray:
        """Unit vector along the fold line, to the left of `normal`, where the left hand is."""
        return np.array([-self.normal[1], self.normal[0]])

    def split(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return distances from the line, negative on the moving side, and coordinates along it [m], shapes (n,)."""
        offset = points[:, :2] - self.origin
        return offset @ self.normal, offset @ self.along

    def mirrored(self, points: np.ndarray) -> np.ndarray:
        """Return the mirror images of n points over the fold line, shape (n, 2)."""
        across, along = self.split(points)
        return self.join(-across, along)

    def join(self, across: np.ndarray, along: np.ndarray) -> np.ndarray:
        """Return the points, shape (n, 2), with these distances and coordinates: the inverse of `split`."""
        return self.origin + across[:, None] * self.normal + along[:, None] * self.along


@dataclass(frozen=True)
class Layout:
    """A garment on the table, and the fold line across it."""

    garment: Garment
    state: np.ndarray
    """The cloth before the fold [m], shape (n, 3)."""
    line: FoldLine

    def split(self, vertices: np.ndarray | slice = slice(None)) -> tuple[np.ndarray, np.ndarray]:
        """Return `FoldLine.split` of these vertices, by default of all."""
        return self.line.split(self.state[vertices])

    def laid(self) -> np.ndarray:
        """Return the positions of the cloth whose moving side is mirrored and laid on top [m], shape (n, 3)."""
        moving = self.split()[0] < 0
        after = self.state.copy()
        after[moving, :2] = self.line.mirrored(self.state)[moving]
        top = float(self.state[:, 2].max()) + 0.5 * self.garment.material.thickness
        after[moving, 2] = 2.0 * top - self.state[moving, 2]
        return after
