"""Drawings of garments: pieces made of curves, and their unit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError, one_line
from tatamu.base.files import MIB
from tatamu.garments.units import Unit

MAX_DRAWING = 16 * MIB
"""Largest size of a drawing's file [bytes]."""
MAX_PARTS = 500_000
"""Maximum number of elements and of numbers in paths, each included part counted as its own."""
DEEPEST = 100
"""Maximum depth to which parts include other parts."""
SELF_SHOWN = "outline: must not contain a part that shows itself"
MAX_COORDINATE = 1e9
"""Largest allowed coordinate of a drawing, in the drawing's unit."""
MAX_POINTS = 100_000
"""Largest number of points of a curve in a drawing."""


@dataclass(frozen=True)
class DrawnCurve:
    """A polyline of a drawing: x to the right, y up, in the drawing's unit."""

    name: str
    """Name that the author of the drawing gave the curve; empty if the curve has no name."""
    points: np.ndarray
    """Points of the polyline, shape (k, 2). A closed curve does not repeat its first point."""
    closed: bool


@dataclass(frozen=True)
class Piece:
    """One piece of a pattern: a closed outline, holes in it, and open curves that name parts of the outline."""

    name: str
    curves: tuple[DrawnCurve, ...]
    grain: np.ndarray | None = None
    """Direction of the grain line, shape (2,); None if the piece has no grain line."""
    fold: np.ndarray | None = None
    """Two points of the fold line, shape (2, 2). The cloth is folded along this line when the piece is cut, so the
    drawing shows one half of the piece. None if the piece is not cut on a fold."""
    remarks: tuple[str, ...] = ()
    """Notes for the user on how the piece was interpreted."""

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of the piece, in the drawing's unit."""
        points = np.concatenate([curve.points for curve in self.curves])
        width, height = np.ptp(points, axis=0)
        return float(width), float(height)


@dataclass(frozen=True)
class DrawnPieces:
    """The pieces of a drawing, and the drawing's unit."""

    pieces: tuple[Piece, ...]
    unit: Unit


def check_parts(count: int, depth: int, most: int = MAX_PARTS) -> None:
    """Refuse a drawing with too many parts, or with parts that are too deep in one another."""
    if depth >= DEEPEST:
        raise InputError(f"outline: must have groups nested at most {DEEPEST} deep; flatten the groups")
    if count > most:
        raise InputError(f"outline: must have at most {most} elements and numbers of paths; simplify the drawing")


def polyline(name: str, points: np.ndarray) -> DrawnCurve | None:
    """Make a curve without repeated points; None if fewer than two points are left.

    Raises:
        InputError: If a coordinate is not finite or exceeds `MAX_COORDINATE`, or the curve has too many points.
    """
    if not (np.abs(points) < MAX_COORDINATE).all():
        raise InputError(f"outline: must have coordinates that are finite and at most {MAX_COORDINATE:g}")
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], length > 1e-9])]
    if len(points) < 2:
        return None
    if len(points) > MAX_POINTS:
        raise InputError(
            f"outline: must have curves of at most {MAX_POINTS} points, given {len(points)}; simplify the drawing"
        )
    closed = len(points) > 3 and bool(np.linalg.norm(points[0] - points[-1]) < 1e-3 * length.sum())
    return DrawnCurve(one_line(name), points[:-1] if closed else points, closed)


def where(path: Path, text: str) -> str:
    """Return an error message about the outline in a file."""
    return f"{path}: outline: {text}"
