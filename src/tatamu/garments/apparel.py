"""Makes pieces from sewing patterns in the apparel industry's form of DXF (ANSI/AAMA-292, ASTM D6673).

Each piece is a block. Its layers are 1 (cut line), 14 (sew line), 11 (cut-outs), 7 (grain line) and 6 (fold line, on
which cloth is folded before it is cut). Others are ignored, such as notches (4, 80 to 83), drill holes (13) and
annotations (15). Texts state the name of a piece and the unit: METRIC is millimetres, ENGLISH is inches.
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
    """Return whether a drawing with these texts is a sewing pattern in the apparel industry's form."""
    return any(STYLE.match(text) for text in texts)


def unit(texts: Iterable[str]) -> Unit | None:
    """Return the unit that the texts of a pattern state."""
    for text in texts:
        found = re.fullmatch(r"\s*UNITS\s*:\s*(METRIC|ENGLISH)\s*", text, re.IGNORECASE)
        if found:
            metres, name = UNITS[found[1].upper()]
            return Unit(metres, name, f"DXF of a pattern, UNITS: {found[1].upper()}")
    return None


def title(texts: Iterable[str], block: str) -> str:
    """Return the name that the texts of a piece state, or else that of its block."""
    for text in texts:
        found = re.fullmatch(r"\s*PIECE NAME\s*:\s*(\S.*?)\s*", text, re.IGNORECASE)
        if found:
            return found[1]
    return block


def piece(name: str, layers: Mapping[str, Sequence[DrawnCurve]]) -> Piece | None:
    """Make a piece from its curves by layer; None without a closed boundary.

    A closed sew line is the outline, because cloth outside is hidden inside the sewn garment; otherwise the cut line
    is.
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
    """Return a nameless piece for each closed boundary of a pattern without blocks."""
    return grouped([DrawnCurve("", curve.points, True) for curve in _closed(layers, BOUNDARY)])


def _closed(layers: Mapping[str, Sequence[DrawnCurve]], layer: str) -> list[DrawnCurve]:
    """Return the closed curves of a layer, from the largest to the smallest extent."""
    loops = [curve for curve in layers.get(layer, ()) if curve.closed]
    return sorted(loops, key=lambda curve: -float(np.prod(np.ptp(curve.points, axis=0))))


def _longest(layers: Mapping[str, Sequence[DrawnCurve]], layer: str) -> np.ndarray | None:
    """Return both ends of the longest line of a layer, shape (2, 2); None if the layer has no line."""
    ends = [curve.points[[0, -1]] for curve in layers.get(layer, ())]
    return max(ends, key=lambda pair: float(np.linalg.norm(pair[1] - pair[0])), default=None)


def _direction(ends: np.ndarray) -> np.ndarray | None:
    length = float(np.linalg.norm(ends[1] - ends[0]))
    return (ends[1] - ends[0]) / length if length > 0.0 else None
