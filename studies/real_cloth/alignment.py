"""Distances of predicted nodes from those that a camera sees, without and with a displacement of the camera.

A camera with a wrong place sees everything with the same rotation and translation,

    y = R x + t

with the real place x of a node and its seen place y, both from the middle of the bar. R and t by least squares, and the
remaining distance, follow from sums over the pairs (Kabsch 1976), so only these sums are kept of a rollout.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Displacement:
    """A rotation and a translation."""

    rotation: np.ndarray
    """R, shape (3, 3)."""
    translation: np.ndarray
    """t [m], shape (3,)."""

    @property
    def angle(self) -> float:
        """Angle by which it turns [rad]."""
        return float(np.arccos(np.clip(0.5 * (np.trace(self.rotation) - 1.0), -1.0, 1.0)))

    def __str__(self) -> str:
        turned = f" and {np.degrees(self.angle):.1f} degrees" if self.angle else ""
        return f"{1e3 * np.linalg.norm(self.translation):.0f} mm{turned}"


UNMOVED = Displacement(np.eye(3), np.zeros(3))


@dataclass(frozen=True)
class Pairs:
    """Means over pairs of real and seen places of nodes."""

    place: np.ndarray
    """Mean of x [m], shape (3,)."""
    seen: np.ndarray
    """Mean of y [m], shape (3,)."""
    squares: float
    """Mean of |x|² + |y|² [m²]."""
    products: np.ndarray
    """Mean of y x' [m²], shape (3, 3)."""

    @classmethod
    def of(cls, places: np.ndarray, seen: np.ndarray) -> Pairs:
        """Return the means of some pairs.

        Args:
            places: Places from the middle of the bar [m], shape (k, 3), k > 0.
            seen: Seen places, in the same frame and shape.
        """
        squares = float((places**2 + seen**2).sum(axis=1).mean())
        return cls(places.mean(axis=0), seen.mean(axis=0), squares, seen.T @ places / len(places))

    @classmethod
    def mean(cls, each: Sequence[Pairs]) -> Pairs:
        """Average several recordings with equal weights."""
        return cls(
            np.mean([pairs.place for pairs in each], axis=0),
            np.mean([pairs.seen for pairs in each], axis=0),
            float(np.mean([pairs.squares for pairs in each])),
            np.mean([pairs.products for pairs in each], axis=0),
        )

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> Pairs:
        """Read pairs from plain numbers and lists, as `plain` writes them."""
        place, seen, products = (np.array(plain[name]) for name in ("place", "seen", "products"))
        return cls(place, seen, float(plain["squares"]), products)

    def plain(self) -> dict[str, Any]:
        """Return the means as plain data."""
        arrays = {"place": self.place, "seen": self.seen, "products": self.products}
        return {"squares": self.squares, **{name: array.tolist() for name, array in arrays.items()}}

    def distance(self, by: Displacement = UNMOVED) -> float:
        """RMS distance of R x + t and y [m]."""
        turned = by.rotation @ self.place
        moved = float(by.translation @ (by.translation + 2.0 * (turned - self.seen)))
        square = self.squares - 2.0 * float((by.rotation * self.products).sum()) + moved
        return float(np.sqrt(max(square, 0.0)))

    def displacement(self) -> Displacement:
        """Return the displacement with the smallest remaining distance."""
        left, _, right = np.linalg.svd(self.products - np.outer(self.seen, self.place))
        mirrored = np.sign(np.linalg.det(left @ right))
        rotation = left @ np.diag([1.0, 1.0, mirrored]) @ right
        return Displacement(rotation, self.seen - rotation @ self.place)

    def translation(self) -> Displacement:
        """Return the best displacement without turning."""
        return Displacement(np.eye(3), self.seen - self.place)
