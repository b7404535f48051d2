"""Computes distances between predicted nodes of a cloth and the nodes that a camera saw.

A displaced camera sees a node that is at x at y = R x + t, both relative to the middle of the bar. R, t, and the
remaining distance follow from sums over all pairs of x and y (Kabsch 1976), so only these sums are stored.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Displacement:
    """The displacement of a camera: a rotation and a translation."""

    rotation: np.ndarray
    """Rotation matrix R of the camera's displacement, shape (3, 3)."""
    translation: np.ndarray
    """Translation t of the camera's displacement [m], shape (3,)."""

    @property
    def angle(self) -> float:
        """Angle of the camera's rotation [rad]."""
        return float(np.arccos(np.clip(0.5 * (np.trace(self.rotation) - 1.0), -1.0, 1.0)))

    def __str__(self) -> str:
        turned = f" and {np.degrees(self.angle):.1f} degrees" if self.angle else ""
        return f"{1e3 * np.linalg.norm(self.translation):.0f} mm{turned}"


UNMOVED = Displacement(np.eye(3), np.zeros(3))


@dataclass(frozen=True)
class Pairs:
    """Means over pairs of a real position x and the position y at which a camera sees the node."""

    place: np.ndarray
    """Mean of the real positions x [m], shape (3,)."""
    seen: np.ndarray
    """Mean of the seen positions y [m], shape (3,)."""
    squares: float
    """Mean of |x|² + |y|² [m²]."""
    products: np.ndarray
    """Mean of the outer products y x' [m²], shape (3, 3)."""

    @classmethod
    def of(cls, places: np.ndarray, seen: np.ndarray) -> Pairs:
        """Return the means over k pairs of positions [m], shape (k, 3)."""
        squares = float((places**2 + seen**2).sum(axis=1).mean())
        return cls(places.mean(axis=0), seen.mean(axis=0), squares, seen.T @ places / len(places))

    @classmethod
    def mean(cls, each: Sequence[Pairs]) -> Pairs:
        """Return the average over recordings, with equal weights."""
        return cls(
            np.mean([pairs.place for pairs in each], axis=0),
            np.mean([pairs.seen for pairs in each], axis=0),
            float(np.mean([pairs.squares for pairs in each])),
            np.mean([pairs.products for pairs in each], axis=0),
        )

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> Pairs:
        """Make the means over pairs from a dictionary that `plain` returned."""
        place, seen, products = (np.array(plain[name]) for name in ("place", "seen", "products"))
        return cls(place, seen, float(plain["squares"]), products)

    def plain(self) -> dict[str, Any]:
        """Return the means over pairs as a dictionary of numbers and lists, for a JSON file."""
        arrays = {"place": self.place, "seen": self.seen, "products": self.products}
        return {"squares": self.squares, **{name: array.tolist() for name, array in arrays.items()}}

    def distance(self, by: Displacement = UNMOVED) -> float:
        """Return the RMS distance between R x + t and y [m] for a displaced camera."""
        turned = by.rotation @ self.place
        moved = float(by.translation @ (by.translation + 2.0 * (turned - self.seen)))
        square = self.squares - 2.0 * float((by.rotation * self.products).sum()) + moved
        return float(np.sqrt(max(square, 0.0)))

    def displacement(self) -> Displacement:
        """Return the displacement of the camera, rotation and translation, for which R x + t is nearest to y."""
        left, _, right = np.linalg.svd(self.products - np.outer(self.seen, self.place))
        mirrored = np.sign(np.linalg.det(left @ right))
        rotation = left @ np.diag([1.0, 1.0, mirrored]) @ right
        return Displacement(rotation, self.seen - rotation @ self.place)

    def translation(self) -> Displacement:
        """Return the displacement of the camera, a translation without rotation, for which x + t is nearest to y."""
        return Displacement(np.eye(3), self.seen - self.place)
