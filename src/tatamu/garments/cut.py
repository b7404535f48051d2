"""Turns a piece of a drawing, such as a sewing pattern, into the outline of a garment.

The outline is the largest closed curve. Closed curves inside are holes, and open curves along it name its parts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import compress
from pathlib import Path

import numpy as np
import shapely
from shapely.validation import explain_validity

from tatamu.base.errors import InputError
from tatamu.garments.drawing import Piece, where
from tatamu.garments.outline import Outline, counted
from tatamu.garments.outline_sides import lies_along, named_sides, with_ends

SMOOTH = 2e-4
"""Maximum change of an outline by leaving out points [m]."""
MAX_CORNERS = 2_000
"""Maximum number of corners of a curve, because libraries recurse once for each corner, or try all pairs."""
MAX_NOTES = 5
"""Maximum number of notes on named curves that are not on the outline; one further note counts the others."""
Openings = Mapping[str, list[tuple[float, float]]] | Sequence[str]


@dataclass(frozen=True)
class Cut:
    """Outline and openings of a garment that was cut out of a drawing."""

    outline: Outline
    """The outline in the garment's frame [m]."""
    openings: tuple[str, ...]
    """Names of the open sides of the outline."""
    notes: tuple[str, ...]
    """Notes for the user on how the drawing was understood."""


def cut(piece: Piece, matrix: np.ndarray, openings: Openings | None, path: Path, holes: bool | None = None) -> Cut:
    """Return the outline of a garment from a piece of a drawing.

    Args:
        piece: Piece of the drawing.
        matrix: Matrix from the drawing's coordinates to metres in the garment's frame, shape (2, 2).
        openings: Names of open curves or of sides, or curves in the drawing's coordinates by name. By default, every
            named open curve along the outline is an opening.
        path: Path of the file, for messages.
        holes: Whether closed curves inside are holes. By default, a curve that follows the outline is none.

    Raises:
        InputError: If the piece has no closed curve, the outline crosses itself, or an opening does not exist.
    """
    loops = sorted((c for c in piece.curves if c.closed), key=lambda c: -float(shapely.Polygon(c.points).area))
    if not loops:
        raise InputError(where(path, f"must be a closed curve, given {len(piece.curves)} open ones"))
    region, inside = _region([loop.points @ matrix.T for loop in loops], holes, path)
    if piece.fold is not None:
        region = _unfolded(region, piece.fold @ matrix.T, path)
    points = _ring(region)
    drawn = _distinct([(c.name, c.points @ matrix.T) for c in piece.curves if not c.closed and c.name])
    meant = set(drawn) & set(openings or ())
    named = {name: curve for name, curve in drawn.items() if name in meant or lies_along(points, curve)}
    stray = [name for name in drawn if name not in named]
    if isinstance(openings, Mapping):
        given = {name: np.asarray(curve, dtype=float) @ matrix.T for name, curve in openings.items()}
        named = {**named, **given}
    points = with_ends(points, named)
    sides = {name: points[side] for name, side in named_sides(points, named).items()}
    cut_out = tuple(np.array(hole.coords) for hole in region.interiors)
    open_sides = tuple(named) if openings is None else tuple(openings)
    for name in open_sides:
        if name not in sides:
            raise InputError(f"{path}: openings: must name sides of the outline ({', '.join(sides)}), given {name!r}")
    notes = tuple(f"{name}: does not lie along the outline, so is not an opening" for name in stray[:MAX_NOTES])
    if len(stray) > MAX_NOTES:
        notes += (f"{len(stray) - MAX_NOTES} more named curves do not lie along the outline",)
    mirrored = ("unfolded along its mirror line (layer 6)",) if piece.fold is not None else ()
    said = (*piece.remarks, *inside, *mirrored, *(notes if openings is None else ()))
    return Cut(Outline(sides, holes=cut_out), open_sides, said)


def _region(rings: Sequence[np.ndarray], holes: bool | None, path: Path) -> tuple[shapely.Polygon, tuple[str, ...]]:
    """Return the cloth within the first closed curve, and notes on how the others were interpreted.

    A pattern may have two lines around a piece: the cut line and, inside, the sew line. No drawing states whether an
    inner curve is a hole or a sew line, but only a sew line follows the outline.
    """
    outer, *inner = (_valid(_bounded(ring, path), path) for ring in rings)
    extent = max(np.ptp(rings[0], axis=0))
    is_mark = [max(np.ptp(ring.exterior.coords, axis=0)) < 0.05 * extent and not outer.covers(ring) for ring in inner]
    marks = list(compress(inner, is_mark))
    inner = [ring for ring, mark in zip(inner, is_mark, strict=True) if not mark]
    notes = [f"left out: {counted(marks, 'closed curve')} across the outline"] if marks else []
    if any(ring.area > 0.99 * outer.area for ring in inner):  # the outline, drawn a second time
        raise InputError(where(path, "must occur once in the drawing, given two copies"))
    if not all(outer.covers(ring) for ring in inner):
        raise InputError(where(path, "must be one closed curve with holes inside, given curves that cross each other"))
    if holes is None and inner and _follows(inner[0], outer):
        apart = 1e3 * outer.exterior.hausdorff_distance(inner[0].exterior)
        notes.append(
            f"the drawing has two outlines at most {apart:.0f} mm apart; the inner one is taken for a seam, and the "
            "garment is cut along it (holes = true makes it a hole)"
        )
        outer, *others = inner
        is_hole = [outer.covers(ring) and not _follows(ring, outer) for ring in others]
        inner = list(compress(others, is_hole))
        left_out = [ring for ring, hole in zip(others, is_hole, strict=True) if not hole]
        if left_out:
            notes.append(f"left out: {counted(left_out, 'closed curve')} along or across the inner line")
    if holes is False and inner:
        notes.append(f"left out: {counted(inner, 'closed curve')} inside the outline (holes = false)")
        inner = []
    region = outer.difference(shapely.union_all(inner)) if inner else outer
    if not isinstance(region, shapely.Polygon):
        raise InputError(
            where(path, "must be one closed curve with holes inside, given curves that cut the outline apart")
        )
    return region, tuple(notes)


def _follows(inner: shapely.Polygon, outer: shapely.Polygon) -> bool:
    """Return whether the inner curve runs along the whole outer curve, at most a seam allowance's width inside it."""
    # metres, and a fraction of the piece's size
    allowance = min(0.06, 0.15 * float(np.sqrt(outer.area)))
    return bool(outer.exterior.hausdorff_distance(inner.exterior) < allowance)


def _valid(points: np.ndarray, path: Path) -> shapely.Polygon:
    region = shapely.Polygon(points)
    if not region.is_valid or not region.area > 0.0:
        raise InputError(where(path, f"must not cross or touch itself ({explain_validity(region)}, in metres)"))
    return region


def _unfolded(half: shapely.Polygon, line: np.ndarray, path: Path) -> shapely.Polygon:
    """Return a whole piece: its drawn half, joined with the mirror image."""
    start, along = line[0], (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])

    def image(points: np.ndarray) -> np.ndarray:
        away = points - start
        return start + 2.0 * np.outer(away @ along, along) - away

    halves = [half, shapely.transform(half, image)]
    wider = shapely.union_all([part.buffer(SMOOTH, join_style="mitre") for part in halves])
    both = wider.buffer(-SMOOTH, join_style="mitre")
    if not isinstance(both, shapely.Polygon) or both.area < 1.5 * half.area:
        raise InputError(where(path, "its mirror line (layer 6) must be a side of the piece"))
    return both


def _bounded(points: np.ndarray, path: Path) -> np.ndarray:
    """Return a closed curve, simplified if it has more than `MAX_CORNERS` points."""
    if len(points) <= MAX_CORNERS:
        return points
    around = np.vstack([points, points[:1]])
    parts = [around[start : start + MAX_CORNERS + 1] for start in range(0, len(points), MAX_CORNERS)]
    lines = shapely.simplify([shapely.LineString(part) for part in parts], SMOOTH)
    fewer = np.concatenate([shapely.get_coordinates(line)[:-1] for line in lines])
    if len(fewer) > MAX_CORNERS:
        raise InputError(where(path, f"must have curves of at most {MAX_CORNERS} corners, given {len(fewer)}"))
    return fewer


def _ring(region: shapely.Polygon) -> np.ndarray:
    """Return the outer curve of a region, counter-clockwise and simplified, shape (k, 2)."""
    points = np.array(shapely.simplify(shapely.Polygon(region.exterior), SMOOTH).exterior.normalize().coords[:-1])
    return points if shapely.is_ccw(shapely.LinearRing(points)) else points[::-1]


def _distinct(named: Sequence[tuple[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Return curves by their names. Repeated names are numbered, such as those of all curves in one DXF layer."""
    found: dict[str, np.ndarray] = {}
    for name, points in named:
        number = sum(other == name or other.startswith(f"{name} ") for other in found)
        found[f"{name} {number + 1}" if name in found else name] = points
    return found
