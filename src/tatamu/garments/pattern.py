"""Makes a garment from a drawing or a piece of a sewing pattern.

The outline is the largest closed curve. Closed curves inside are holes, and open curves along it name its parts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from shapely.validation import explain_validity

from tatamu.base.errors import InputError
from tatamu.garments.description import GarmentFile
from tatamu.garments.drawing import Piece, chosen, distinct
from tatamu.garments.dxf import read_dxf
from tatamu.garments.garment import Garment
from tatamu.garments.outline import Outline, counted, lies_along, named_sides, with_ends
from tatamu.garments.sewing import front_and_back, one_layer
from tatamu.garments.svg import read_svg
from tatamu.garments.units import check_size_of_file, direction, doubts, plane_turn
from tatamu.simulation.material import Material

READERS = {".svg": read_svg, ".dxf": read_dxf}
"""Function that reads each drawing format, by the file name's ending."""
SMOOTH = 2e-4
"""Maximum change of an outline by leaving out points [m]."""
MAX_CORNERS = 2_000
"""Maximum number of corners of a curve, because libraries recurse once for each corner, or try all pairs."""
Openings = Mapping[str, list[tuple[float, float]]] | Sequence[str]


def from_outline(given: GarmentFile, source: Path, material: Material) -> Garment:
    """Make the garment of an SVG or DXF file."""
    reader = READERS.get(source.suffix.lower())
    if reader is None:
        raise InputError(f"outline: must be a file of type {', '.join(READERS)}")
    drawing = reader(source)
    unit = drawing.unit.scaled(given.scale)
    piece = chosen(drawing, given.piece, unit.metres)
    openings = given.openings
    if isinstance(openings, dict) and source.suffix.lower() == ".svg":  # y points down in SVG files, but up in curves
        openings = {name: [(x, -y) for x, y in curve] for name, curve in openings.items()}
    turn = plane_turn(given.up or "y", piece.grain if given.grain else None)
    try:
        made = cut(piece, unit.metres * turn, openings, given.holes)
    except InputError as error:
        raise InputError(f'{error}; piece "{piece.name}"' if len(drawing.pieces) > 1 else str(error)) from None
    if given.size is None:
        check_size_of_file(made.outline.size, f"outline: {piece.name}", unit)
    outline = made.outline.fitted(given.size)
    notes = [*made.notes, *_turn_note(turn, given.up or "y")]
    notes += [] if given.size else doubts(made.outline.size, unit)
    if given.layers == 2 or (given.layers is None and made.openings):
        garment = front_and_back(given.name, outline, made.openings, material, given.spacing)
    else:
        garment = one_layer(given.name, outline, material, given.spacing)
        hint = "give openings under [garment] for a front and a back, or layers = 1 to confirm"
        notes += [f"the garment has one layer, because no opening is named; {hint}"] if given.layers is None else []
    if piece.grain is not None and not given.grain:  # the piece is not turned, but the warp follows the grain line
        garment = replace(garment, fibre=np.array([[*(turn @ piece.grain), 0.0]]))
    paths = [path for name, path in garment.edges.items() if name.startswith("hole ")]
    if paths:
        holes = counted([shapely.Polygon(garment.unstrained[path, :2]) for path in paths], "hole")
        notes.append(
            f"closed curves inside the outline become {holes}; write holes = false to fill the holes with cloth"
        )
    return replace(garment, reading=unit.reading(given.size), notes=(*notes, *garment.notes))


def _turn_note(turn: np.ndarray, up: str) -> list[str]:
    ahead = turn @ direction(up)[:2]
    degrees = round(float(np.degrees(np.arctan2(ahead[1], ahead[0]))), 1)
    if abs(degrees) < 0.1:
        return []
    return [
        f"the piece is turned by {degrees:g} degrees, so that its grain line points away from the hem (unless grain = "
        "false)"
    ]


@dataclass(frozen=True)
class Cut:
    """Outline and openings of a garment that was cut out of a drawing."""

    outline: Outline
    """The outline in the garment's frame [m]."""
    openings: tuple[str, ...]
    """Names of the open sides of the outline."""
    notes: tuple[str, ...]
    """Notes for the user on how the drawing was understood."""


def cut(piece: Piece, matrix: np.ndarray, openings: Openings | None, holes: bool | None = None) -> Cut:
    """Return the outline of a garment from a piece of a drawing.

    Args:
        piece: Piece of the drawing.
        matrix: Matrix from the drawing's coordinates to metres in the garment's frame, shape (2, 2).
        openings: Names of open curves or of sides, or curves in the drawing's coordinates by name. By default, every
            named open curve along the outline is an opening.
        holes: Whether closed curves inside are holes. By default, a curve that follows the outline is none.

    Raises:
        InputError: If the piece has no closed curve, the outline crosses itself, or an opening does not exist.
    """
    loops = sorted((c for c in piece.curves if c.closed), key=lambda c: -float(shapely.Polygon(c.points).area))
    if not loops:
        raise InputError(f"outline: must be a closed curve, given only open curves ({len(piece.curves)})")
    region, inside = _region([loop.points @ matrix.T for loop in loops], holes)
    if piece.fold is not None:
        region = _unfolded(region, piece.fold @ matrix.T)
    ring = shapely.simplify(shapely.Polygon(region.exterior), SMOOTH).exterior.normalize()
    points = np.array(ring.coords[:-1])
    points = points if shapely.is_ccw(ring) else points[::-1]
    lines = [curve for curve in piece.curves if not curve.closed and curve.name]
    # repeated names are numbered, such as those of all curves in one DXF layer
    drawn = dict(zip(distinct([line.name for line in lines]), [line.points @ matrix.T for line in lines], strict=True))
    meant = set(drawn) & set(openings or ())
    named = {name: curve for name, curve in drawn.items() if name in meant or lies_along(points, curve)}
    stray = [name for name in drawn if name not in named]
    if isinstance(openings, Mapping):
        named |= {name: np.asarray(curve, dtype=float) @ matrix.T for name, curve in openings.items()}
    points = with_ends(points, named)
    sides = {name: points[side] for name, side in named_sides(points, named).items()}
    cut_out = tuple(np.array(hole.coords) for hole in region.interiors)
    open_sides = tuple(named) if openings is None else tuple(openings)
    for name in open_sides:
        if name not in sides:
            raise InputError(f"openings: must name sides of the outline ({', '.join(sides)}), given {name!r}")
    notes = [*piece.remarks, *inside]
    notes += ["the piece is unfolded along its mirror line (layer 6)"] if piece.fold is not None else []
    if openings is None:
        notes += [
            f"curve {name} is not an opening, because the curve does not lie along the outline" for name in stray[:5]
        ]
        notes += [f"{len(stray) - 5} more named curves do not lie along the outline"] if len(stray) > 5 else []
    return Cut(Outline(sides, holes=cut_out), open_sides, tuple(notes))


def _region(rings: Sequence[np.ndarray], holes: bool | None) -> tuple[shapely.Polygon, tuple[str, ...]]:
    """Return the cloth within the first closed curve, and notes on how the others were interpreted.

    A pattern may have two lines around a piece: the cut line and, inside, the sew line. No drawing states whether an
    inner curve is a hole or a sew line, but only a sew line follows the outline.
    """
    outer, *others = map(_within, rings)
    inner = np.array(others, dtype=object)
    bounds = shapely.bounds(inner)
    small = (bounds[:, 2:] - bounds[:, :2]).max(axis=1) < 0.05 * max(np.ptp(rings[0], axis=0))
    covered = shapely.covers(outer, inner)
    marks, kept = inner[small & ~covered], ~small | covered
    inner = inner[kept]
    notes = []
    if len(marks):
        notes.append(
            f"small curves across the outline are taken as marks and left out: {counted(marks, 'closed curve')}"
        )
    if (shapely.area(inner) > 0.99 * outer.area).any():  # the outline, drawn a second time
        raise InputError("outline: must occur once in the drawing, given two copies")
    if not covered[kept].all():
        raise InputError("outline: must be one closed curve with holes inside, given curves that cross one another")
    if holes is None and len(inner) and _follows(inner[0], outer):
        apart = 1e3 * outer.exterior.hausdorff_distance(inner[0].exterior)
        notes.append(
            f"the inner outline is taken as the seam, where the garment ends (at most {apart:.0f} mm inside the outer "
            "outline); write holes = true if the inner outline is a hole"
        )
        outer, inner = inner[0], inner[1:]
        is_hole = np.array([outer.covers(ring) and not _follows(ring, outer) for ring in inner], dtype=bool)
        if not is_hole.all():
            left_out = counted(inner[~is_hole], "closed curve")
            notes.append(f"curves that follow or cross the seam are left out: {left_out}")
        inner = inner[is_hole]
    if holes is False and len(inner):
        notes.append(f"curves inside the outline are left out, because holes = false: {counted(inner, 'closed curve')}")
        inner = inner[:0]
    region = outer.difference(shapely.union_all(inner)) if len(inner) else outer
    if not isinstance(region, shapely.Polygon):
        raise InputError("outline: must be one closed curve with holes inside, given curves that divide the piece")
    return region, tuple(notes)


def _follows(inner: shapely.Polygon, outer: shapely.Polygon) -> bool:
    """Return whether the inner curve runs along the whole outer curve, at most a seam allowance's width inside it."""
    # metres, and a fraction of the piece's size
    allowance = min(0.06, 0.15 * float(np.sqrt(outer.area)))
    return bool(outer.exterior.hausdorff_distance(inner.exterior) < allowance)


def _unfolded(half: shapely.Polygon, line: np.ndarray) -> shapely.Polygon:
    """Return a whole piece: its drawn half, joined with the mirror image."""
    start, along = line[0], (line[1] - line[0]) / np.linalg.norm(line[1] - line[0])

    def image(points: np.ndarray) -> np.ndarray:
        away = points - start
        return start + 2.0 * np.outer(away @ along, along) - away

    halves = [half, shapely.transform(half, image)]
    wider = shapely.union_all([part.buffer(SMOOTH, join_style="mitre") for part in halves])
    both = wider.buffer(-SMOOTH, join_style="mitre")
    if not isinstance(both, shapely.Polygon) or both.area < 1.5 * half.area:
        raise InputError("outline: the mirror line (layer 6) must lie along a side of the piece")
    return both


def _within(points: np.ndarray) -> shapely.Polygon:
    """Return the region inside a closed curve, which is simplified if it has more than `MAX_CORNERS` points."""
    if len(points) > MAX_CORNERS:
        around = np.vstack([points, points[:1]])
        parts = [around[start : start + MAX_CORNERS + 1] for start in range(0, len(points), MAX_CORNERS)]
        lines = shapely.simplify([shapely.LineString(part) for part in parts], SMOOTH)
        points = np.concatenate([shapely.get_coordinates(line)[:-1] for line in lines])
    if len(points) > MAX_CORNERS:
        raise InputError(f"outline: each curve must have at most {MAX_CORNERS} corners, given {len(points)}")
    region = shapely.Polygon(points)
    if not region.is_valid or not region.area > 0.0:
        raise InputError(f"outline: must not cross or touch itself ({explain_validity(region)}; coordinates in metres)")
    return region
