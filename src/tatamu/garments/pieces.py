"""Finds the pieces of a drawing among its curves, and chooses a piece by its name."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import shapely

from tatamu.base.errors import InputError
from tatamu.garments.drawing import DrawnCurve, DrawnPieces, Piece, where

MAX_CURVES = 5_000
"""Maximum number of closed curves of a drawing, and of open curves."""


def grouped(curves: Sequence[DrawnCurve]) -> tuple[Piece, ...]:
    """Group the curves of a drawing into pieces, from the largest to the smallest.

    Every closed curve that lies in no other makes a piece, with the closed curves inside, and with the open curves that
    are closest to it. A drawing without closed curves is one piece.

    Raises:
        InputError: If there are too many curves.
    """
    closed = [curve for curve in curves if curve.closed]
    if len(closed) > MAX_CURVES:
        raise InputError(f"outline: must have at most {MAX_CURVES} closed curves, given {len(closed)}; leave text out")
    if len(curves) - len(closed) > MAX_CURVES:
        raise InputError(f"outline: must have at most {MAX_CURVES} open curves, given {len(curves) - len(closed)}")
    regions = {id(curve): _region(curve) for curve in closed}
    loops = sorted(closed, key=lambda curve: -float(regions[id(curve)].area))
    if not loops:
        return (Piece("", tuple(curves)),) if curves else ()
    groups = _around([regions[id(loop)] for loop in loops])
    members = [[loops[number] for number in group] for group in groups]
    beside = [curve for curve in curves if not curve.closed]
    outer = shapely.STRtree([regions[id(group[0])] for group in members])
    for curve, lines in zip(beside, [shapely.LineString(curve.points) for curve in beside], strict=True):
        members[int(outer.query_nearest(lines).min())].append(curve)
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
            raise InputError("outline: must have closed curves inside or beside one another, given too many that cross")
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
    return [
        name if name not in names[:number] else f"{name} {names[:number].count(name) + 1}"
        for number, name in enumerate(names)
    ]


def chosen(drawing: DrawnPieces, name: str | None, scale: float, path: Path) -> Piece:
    """Return the piece with a name, in upper or lower case, or the only piece of the drawing.

    Raises:
        InputError: If the drawing has no curve, no piece has this name, or several pieces need a name.
    """
    if not drawing.pieces:
        raise InputError(where(path, "has no curve"))
    fitting = [piece for piece in drawing.pieces if name is None or piece.name.casefold() == name.casefold()]
    if len(fitting) == 1:
        return fitting[0]
    known = ", ".join(_described(piece, scale) for piece in drawing.pieces)
    if name is not None:
        raise InputError(f"{path}: piece: must be one of {known}, given {name!r}")
    example = drawing.pieces[0].name
    raise InputError(
        where(
            path, f'has several pieces; choose one with piece = "{example}" under [garment] in a garment file: {known}'
        )
    )


def _described(piece: Piece, scale: float) -> str:
    width, height = piece.extent
    return f'"{piece.name}" ({scale * width:.2f} x {scale * height:.2f} m)'
