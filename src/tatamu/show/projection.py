"""Defines the projection of a drawing: the visible rectangle of a plane, its scale and its orientation."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tatamu.show.shapes import FONT, Box, Label

LETTER = 0.55
"""Ratio of the mean width of a letter to its height."""
FROM_ABOVE = np.array([[0.0, -1.0], [1.0, 0.0]])
"""Axes of a view from above, with x up and y to the left. This is how a robot sees the table in front of it."""
UPRIGHT = np.eye(2)
"""Axes of an upright view, with the first coordinate to the right and the second coordinate up."""


@dataclass
class Projection:
    """The projection of a rectangle of a plane to a grid of pixels."""

    low: np.ndarray
    """Smallest coordinates of the rectangle that the drawing shows [m], shape (2,)."""
    high: np.ndarray
    """Largest coordinates of the rectangle that the drawing shows [m], shape (2,)."""
    scale: float
    """Number of pixels per metre of the plane."""
    axes: np.ndarray = field(default_factory=lambda: UPRIGHT)
    """Directions right and up in the plane, shape (2, 2): `FROM_ABOVE` or `UPRIGHT`."""
    margin: float = 0.0
    """Width of the border around the rectangle [pixels]."""

    @property
    def _corner(self) -> np.ndarray:
        """Upper left corner of the rectangle, to the right and upwards from the origin [m], shape (2,)."""
        ends = np.array([self.low, self.high]) @ self.axes.T
        return np.array([ends[:, 0].min(), ends[:, 1].max()])

    @property
    def size(self) -> np.ndarray:
        """Width and height of the drawing, including the margin [pixels], shape (2,)."""
        return self.scale * np.abs(self.axes @ (self.high - self.low)) + 2 * self.margin

    @property
    def wide(self) -> int:
        """Width of the drawing in whole pixels."""
        return round(float(self.size[0]))

    @property
    def tall(self) -> int:
        """Height of the drawing in whole pixels."""
        return round(float(self.size[1]))

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Project points of the plane [m], shape (k, 2), to pixels, with x to the right and y down."""
        return (points @ self.axes.T - self._corner) * [self.scale, -self.scale] + self.margin

    def box(self, box: Box) -> tuple[np.ndarray, np.ndarray]:
        """Return the upper left corner of a rectangle in the drawing, and its width and height [pixels]."""
        corners = self.pixels(np.array([box.low, box.high]))
        return corners.min(axis=0), np.ptp(corners, axis=0)

    def beside(self, label: Label) -> tuple[np.ndarray, str]:
        """Return where a word stands inside the drawing [pixels], and by which part: l(eft), m(iddle) or r(ight)."""
        right, up = self.axes @ label.towards
        at = self.pixels(label.place[None])[0] + np.array([right, -up]) * 0.9 * FONT
        anchor = "l" if right > 0.4 else "r" if right < -0.4 else "m"
        long = LETTER * FONT * len(label.text)
        before = {"l": 0.0, "m": 0.5, "r": 1.0}[anchor] * long
        at[0] = np.clip(at[0], before, max(self.wide - long + before, before))
        return at, anchor
