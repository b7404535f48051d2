"""Drawings of garments: pieces made of curves, and their unit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.errors import InputError, one_line
from tatamu.garments.units import Unit

FARTHEST = 1e9
"""Largest coordinate of a drawing, in any unit."""
MOST_POINTS = 100_000
"""Largest number of points of a curve in a drawing."""
SAME = 1e-3
"""Largest distance of two ends that count as one point, as a fraction of the curve's length."""


@dataclass(frozen=True)
class DrawnCurve:
    """A polyline of a drawing: x to the right, y up, in the drawing's unit."""

    name: str
    """The name given by its author; empty if there is none."""
    points: np.ndarray
    """Shape (k, 2); of a closed curve without the closing point."""
    closed: bool


@dataclass(frozen=True)
class Piece:
    """One part of a pattern: its closed outline, holes in it, and open curves that name parts of the outline."""

    name: str
    curves: tuple[DrawnCurve, ...]
    grain: np.ndarray | None = None
    """Direction of the grain line, shape (2,)."""
    fold: np.ndarray | None = None
    """Two points of the line on which the cloth is folded when the piece is cut, shape (2, 2): the piece is a half."""
    remarks: tuple[str, ...] = ()
    """Notes on choices made while reading."""

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height as drawn, in the drawing's unit."""
        points = np.concatenate([curve.points for curve in self.curves])
        width, height = np.ptp(points, axis=0)
        return float(width), float(height)


@dataclass(frozen=True)
class DrawnPieces:
    """The contents of a file."""

    pieces: tuple[Piece, ...]
    unit: Unit


def polyline(name: str, points: np.ndarray) -> DrawnCurve | None:
    """Make a curve without repeated points; None if fewer than two are left.

    Raises:
        InputError: If a point is not finite, or farther from the origin than any drawing is.
    """
    if not (np.abs(points) < FARTHEST).all():
        raise InputError(f"outline: must have coordinates that are finite and at most {FARTHEST:g}")
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], length > 1e-9])]
    if len(points) < 2:
        return None
    if len(points) > MOST_POINTS:
        raise InputError(f"outline: must have curves of at most {MOST_POINTS} points, given {len(points)}; simplify it")
    closed = len(points) > 3 and bool(np.linalg.norm(points[0] - points[-1]) < SAME * length.sum())
    return DrawnCurve(one_line(name), points[:-1] if closed else points, closed)


def where(path: Path, text: str) -> str:
    """Return the beginning of a message about the outline in a file."""
    return f"{path}: outline: {text}"
