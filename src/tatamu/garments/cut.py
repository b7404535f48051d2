"""An outline from the curves of a drawing: the largest closed one, its holes, and curves that name parts of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import shapely
from shapely.validation import explain_validity

from tatamu.errors import InputError
from tatamu.garments.drawing import DrawnCurve
from tatamu.garments.frame import turned
from tatamu.garments.outline import Outline
from tatamu.garments.sides import named_sides, with_ends

SMOOTH = 2e-4
"""Points that change the outline by less than this are left out [m]."""
SAME = 0.99
"""A hole with more than this part of the outline's area is the outline itself, drawn twice."""

Openings = Mapping[str, list[tuple[float, float]]] | Sequence[str]


def cut(
    curves: Sequence[DrawnCurve],
    scale: float,
    up: str,
    openings: Openings | None,
    path: Path,
) -> tuple[Outline, tuple[str, ...]]:
    """The outline in a drawing, in metres and in a garment's frame, and the names of its openings.

    Args:
        curves: All curves of the drawing.
        scale: Metres per unit of the drawing.
        up: The direction of the drawing that points away from the hem: y, -y, x or -x.
        openings: Curves in the drawing's units by name; or names of the drawing's open curves that are openings;
            None: all of them.
        path: The file, for messages.

    Raises:
        InputError: There is no closed curve, or several side by side, or it crosses itself, or an opening is not there.
    """
    loops = sorted((c for c in curves if c.closed), key=lambda c: -_area(c.points))
    if not loops:
        raise InputError(f"{path}: outline: must be a closed curve, given {len(curves)} open ones")
    outer, *inner = (turned(loop.points * scale, up) for loop in loops)
    region = _valid(outer, path)
    holes = [_valid(hole, path) for hole in inner]
    if any(hole.area > SAME * region.area for hole in holes):
        raise InputError(f"{path}: outline: stands twice in the drawing; leave one")
    if not all(region.contains(hole) for hole in holes):
        raise InputError(f"{path}: outline: must be one closed curve with holes inside, given several pieces")
    drawn = _distinct([(c.name, turned(c.points * scale, up)) for c in curves if not c.closed and c.name])
    named, names = _named(drawn, openings, scale, up, path)
    loop = shapely.simplify(shapely.Polygon(outer), SMOOTH).exterior.normalize().coords[:-1]
    points = np.array(loop)
    points = points if shapely.is_ccw(shapely.LinearRing(points)) else points[::-1]
    points = with_ends(points, named)
    sides = named_sides(points, named)
    return Outline({name: points[side] for name, side in sides.items()}, holes=tuple(map(_closed, inner))), names


def _distinct(named: Sequence[tuple[str, np.ndarray]]) -> dict[str, np.ndarray]:
    """Curves by name; of several with one name (a DXF layer may hold all openings) the later ones are numbered."""
    found: dict[str, np.ndarray] = {}
    for name, points in named:
        number = sum(other == name or other.startswith(f"{name} ") for other in found)
        found[f"{name} {number + 1}" if name in found else name] = points
    return found


def _area(points: np.ndarray) -> float:
    return float(shapely.Polygon(points).area)


def _closed(points: np.ndarray) -> np.ndarray:
    return np.vstack([points, points[:1]])


def _valid(points: np.ndarray, path: Path) -> shapely.Polygon:
    region = shapely.Polygon(points)
    if not region.is_valid or not region.area > 0.0:
        raise InputError(f"{path}: outline: must not cross or touch itself ({explain_validity(region)}, in metres)")
    return region


def _named(
    drawn: Mapping[str, np.ndarray],
    openings: Openings | None,
    scale: float,
    up: str,
    path: Path,
) -> tuple[dict[str, np.ndarray], tuple[str, ...]]:
    """Curves that name parts of the outline, and which of them are openings."""
    if openings is None:
        return dict(drawn), tuple(drawn)
    if isinstance(openings, Mapping):
        given = {name: turned(np.asarray(curve, dtype=float) * scale, up) for name, curve in openings.items()}
        return {**drawn, **given}, tuple(given)
    missing = [name for name in openings if name not in drawn]
    if missing:
        known = ", ".join(drawn) or "no open curve with a name"
        raise InputError(f"{path}: openings: must name open curves of the drawing ({known}), given {missing[0]!r}")
    return dict(drawn), tuple(openings)
