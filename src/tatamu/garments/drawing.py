"""Drawings of garments: their unit, and their pieces, which are found among all curves and chosen by name."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from tatamu.base.errors import InputError, one_line
from tatamu.base.files import MIB
from tatamu.garments.outline import numbered
from tatamu.garments.units import Unit

MAX_DRAWING = 16 * MIB
"""Largest size of a drawing's file [bytes]."""
MAX_PARTS = 500_000
"""Maximum number of numbers in paths, each included part counted as its own."""
SELF_SHOWN = "outline: must not contain a part that refers to itself"
MAX_COORDINATE = 1e9
"""Largest allowed coordinate of a drawing, in the drawing's unit."""
MAX_CURVES = 5_000
"""Maximum number of closed curves of a drawing, and of open curves."""


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


@dataclass(frozen=True)
class DrawnPieces:
    """The pieces of a drawing, and the drawing's unit."""

    pieces: tuple[Piece, ...]
    unit: Unit


def check_parts(count: int, depth: int, most: int = MAX_PARTS) -> None:
    """Refuse a drawing with too many parts, or with parts that are too deep in one another."""
    if depth >= 100:
        raise InputError("outline: groups must be nested at most 100 deep; flatten the groups")
    if count > most:
        raise InputError(
            f"outline: must have at most {most} elements and path coordinates in total; simplify the drawing"
        )


def polyline(name: str, points: np.ndarray) -> DrawnCurve | None:
    """Make a curve without repeated points; None if fewer than two points are left.

    Raises:
        InputError: If a coordinate is not finite or exceeds `MAX_COORDINATE`, or the curve has too many points.
    """
    if not (np.abs(points) < MAX_COORDINATE).all():
        raise InputError(f"outline: coordinates must be finite and at most {MAX_COORDINATE:g}")
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], length > 1e-9])]
    if len(points) < 2:
        return None
    if len(points) > 100_000:
        given = f"given {len(points)}; simplify the drawing"
        raise InputError(f"outline: each curve must have at most 100000 points, {given}")
    closed = len(points) > 3 and bool(np.linalg.norm(points[0] - points[-1]) < 1e-3 * length.sum())
    return DrawnCurve(one_line(name), points[:-1] if closed else points, closed)


def grouped(curves: Sequence[DrawnCurve]) -> tuple[Piece, ...]:
    """Group the curves of a drawing into pieces, from the largest to the smallest.

    Every closed curve that lies in no other makes a piece, with the closed curves inside, and with the open curves that
    are closest to it. A drawing without closed curves is one piece.

    Raises:
        InputError: If there are too many curves.
    """
    closed = [curve for curve in curves if curve.closed]
    if len(closed) > MAX_CURVES:
        raise InputError(
            f"outline: must have at most {MAX_CURVES} closed curves, given {len(closed)}; remove text from the drawing"
        )
    if len(curves) - len(closed) > MAX_CURVES:
        given = f"given {len(curves) - len(closed)}; simplify the drawing"
        raise InputError(f"outline: must have at most {MAX_CURVES} open curves, {given}")
    if not closed:
        return (Piece("", tuple(curves)),) if curves else ()
    loops = sorted(((_region(curve), curve) for curve in closed), key=lambda loop: -float(loop[0].area))
    groups = _around([region for region, _ in loops])
    members = [[loops[number][1] for number in group] for group in groups]
    outer = shapely.STRtree([loops[group[0]][0] for group in groups])
    for curve in curves:
        if not curve.closed:
            members[int(outer.query_nearest(shapely.LineString(curve.points)).min())].append(curve)
    names = distinct([own[0].name or f"piece {number}" for number, own in enumerate(members, start=1)])
    return tuple(Piece(name, tuple(own)) for name, own in zip(names, members, strict=True))


def _around(regions: Sequence[shapely.Geometry]) -> list[list[int]]:
    """Return the indices of each outermost region and all regions inside, of regions in falling order of size."""
    tree = shapely.STRtree(regions)
    groups: dict[int, list[int]] = {}
    overlaps = 0
    for number, own in enumerate(regions):
        near = sorted(int(other) for other in tree.query(own) if other in groups)
        overlaps += len(near)
        # each pair takes time
        if overlaps > 100_000:
            raise InputError(
                "outline: must have at most 100000 pairs of overlapping closed curves; simplify the drawing"
            )
        around = next((other for other in near if _surrounds(regions[other], own)), number)
        groups.setdefault(around, []).append(number)
    return list(groups.values())


def _surrounds(outer: shapely.Geometry, region: shapely.Geometry) -> bool:
    """Return whether most of `region` lies inside `outer`, or it is a small mark that touches `outer`."""
    if not shapely.intersects(outer, region):
        return False
    return bool(region.area < 1e-3 * outer.area or outer.intersection(region).area > 0.5 * region.area)


def _region(loop: DrawnCurve) -> shapely.Geometry:
    """Return the region inside a closed curve, or its convex hull if the curve crosses itself."""
    region = shapely.Polygon(loop.points)
    if region.is_valid:
        shapely.prepare(region)
        return region
    return region.convex_hull


def distinct(names: Sequence[str]) -> list[str]:
    """Return different names, by numbering repeated ones."""
    found: dict[str, None] = {}  # quicker to look up than a list
    for name in names:
        found[numbered(name, found)] = None
    return list(found)


def found_by_name(names: Sequence[str], name: str) -> int | None:
    """Return the index of a name, or of the only one that differs in upper and lower case or in spaces alone."""
    same = [k for k, each in enumerate(names) if each.casefold().split() == name.casefold().split()]
    return names.index(name) if name in names else same[0] if len(same) == 1 else None


def in_toml(text: str) -> str:
    """Return a text as it is written in a TOML file, in quotation marks."""
    return json.dumps(text, ensure_ascii=False)


def chosen(drawing: DrawnPieces, name: str | None, scale: float) -> Piece:
    """Return the piece with a name, in upper or lower case, or the only piece of the drawing.

    Raises:
        InputError: If the drawing has no curve, no piece has this name, or several pieces need a name.
    """
    if not drawing.pieces:
        raise InputError("outline: must contain a curve, given none")
    if name is None and len(drawing.pieces) == 1:
        return drawing.pieces[0]
    place = None if name is None else found_by_name([piece.name for piece in drawing.pieces], name)
    if place is not None:
        return drawing.pieces[place]
    known = ", ".join(_described(piece, scale) for piece in drawing.pieces)
    if name is not None:
        raise InputError(f"piece: must be one of {known}, given {name!r}")
    how = f"choose one with piece = {in_toml(drawing.pieces[0].name)} under [garment] in a garment file"
    raise InputError(f"outline: must be a single piece, given {len(drawing.pieces)} pieces: {known}; {how}")


def _described(piece: Piece, scale: float) -> str:
    points = np.concatenate([curve.points for curve in piece.curves])
    width, height = np.ptp(points, axis=0).tolist()
    return f"{in_toml(piece.name)} ({scale * width:.2f} x {scale * height:.2f} m)"
