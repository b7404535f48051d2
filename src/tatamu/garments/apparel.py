"""The apparel industry's form of DXF, ANSI/AAMA-292 and ASTM D6673: a block for each piece, layers with a meaning.

The layers have numbers. Layer 1 has the boundary of a piece, along which it is cut, and layer 14 the lines along which
it is sewn. Layer 11 has cut-outs, layer 7 the grain line, and layer 6 the fold line of a piece that is cut on a fold. A
flat garment does not need the other layers: turn points (2), curve points (3), notches (4 and 80 to 83), reference
lines (5, 9, 10), lines that are only drawn (8), drill holes (13), annotations (15) and the finer copies for checking
(84 to 87). Texts state the name of a piece and the unit: METRIC is millimetres, ENGLISH is inches.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from tatamu.garments.drawing import DrawnCurve, Piece
from tatamu.garments.pieces import grouped
from tatamu.garments.units import Unit

BOUNDARY, MIRROR, GRAIN, CUT_OUT, SEW = "1", "6", "7", "11", "14"
UNITS = {"METRIC": (1e-3, "millimetres"), "ENGLISH": (0.0254, "inches")}
STYLE = re.compile(r"\s*(ANSI/AAMA|ASTM|UNITS|PIECE NAME|STYLE NAME)\b", re.IGNORECASE)


def is_pattern(texts: Sequence[str]) -> bool:
    """Return whether the texts of a drawing are those of a pattern in this form."""
    return any(STYLE.match(text) for text in texts)


def unit(texts: Iterable[str]) -> Unit | None:
    """The unit that a pattern's text states; None if it states none."""
    for text in texts:
        found = re.fullmatch(r"\s*UNITS\s*:\s*(METRIC|ENGLISH)\s*", text, re.IGNORECASE)
        if found:
            metres, name = UNITS[found[1].upper()]
            return Unit(metres, name, f"DXF of a pattern, UNITS: {found[1].upper()}")
    return None


def title(texts: Iterable[str], block: str) -> str:
    """Return the name of a piece: its text, or the name of its block."""
    for text in texts:
        found = re.fullmatch(r"\s*PIECE NAME\s*:\s*(\S.*?)\s*", text, re.IGNORECASE)
        if found:
            return found[1]
    return block


def piece(name: str, layers: Mapping[str, Sequence[DrawnCurve]]) -> Piece | None:
    """A piece from its curves by layer; None without a closed boundary.

    The outline is the sew line if it is closed, because cloth outside of it ends up inside the garment; otherwise it is
    the cut line.
    """
    cut = _closed(layers, BOUNDARY)
    if not cut:
        return None
    sewn = _closed(layers, SEW)
    outline = sewn[0] if sewn else cut[0]
    remarks = ("along its sew line (layer 14), inside of which the seam allowance lies",) if sewn else ()
    holes = [DrawnCurve("", hole.points, True) for hole in _closed(layers, CUT_OUT)]
    fold = _longest(layers, MIRROR)
    grain = _longest(layers, GRAIN)
    return Piece(
        name,
        (DrawnCurve(name, outline.points, True), *holes),
        None if grain is None else _direction(grain),
        fold,
        remarks,
    )


def loose_pieces(layers: Mapping[str, Sequence[DrawnCurve]]) -> tuple[Piece, ...]:
    """Return the pieces of a pattern without blocks: its boundaries, without names."""
    return grouped([DrawnCurve("", curve.points, True) for curve in _closed(layers, BOUNDARY)])


def _closed(layers: Mapping[str, Sequence[DrawnCurve]], layer: str) -> list[DrawnCurve]:
    """Closed curves of a layer, the one of largest extent first."""
    loops = [curve for curve in layers.get(layer, ()) if curve.closed]
    return sorted(loops, key=lambda curve: -float(np.prod(np.ptp(curve.points, axis=0))))


def _longest(layers: Mapping[str, Sequence[DrawnCurve]], layer: str) -> np.ndarray | None:
    """Ends of the longest line of a layer, shape (2, 2)."""
    ends = [curve.points[[0, -1]] for curve in layers.get(layer, ())]
    return max(ends, key=lambda pair: float(np.linalg.norm(pair[1] - pair[0])), default=None)


def _direction(ends: np.ndarray) -> np.ndarray | None:
    length = float(np.linalg.norm(ends[1] - ends[0]))
    return (ends[1] - ends[0]) / length if length > 0.0 else None
