"""Reads DXF files: the pieces of a sewing pattern, or else one curve for each layer, with the layer's name.

Sewing patterns have the apparel industry's form (ANSI/AAMA-292, ASTM D6673). Each piece is a block. Its layers are 1
(cut line), 14 (sew line), 11 (cut-outs), 7 (grain line) and 6 (fold line, on which cloth is folded before it is cut).
Others are ignored, such as notches (4, 80 to 83), drill holes (13) and annotations (15). Texts state the name of a
piece and the unit: METRIC is millimetres, ENGLISH is inches.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from tatamu.base.errors import InputError, one_line
from tatamu.base.files import foreign, opened, read_bytes
from tatamu.garments.drawing import (
    MAX_COORDINATE,
    MAX_DRAWING,
    MAX_PARTS,
    SELF_SHOWN,
    DrawnCurve,
    DrawnPieces,
    Piece,
    check_parts,
    distinct,
    grouped,
    polyline,
)
from tatamu.garments.units import NAMES, Unit

KINDS = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")
"""Types of DXF entities that are curves."""
Layers = dict[str, list[DrawnCurve]]
BOUNDARY, MIRROR, GRAIN, CUT_OUT, SEW = "1", "6", "7", "11", "14"
"""Layers of a piece of a sewing pattern: cut line, fold line, grain line, cut-outs and sew line."""
STYLE = re.compile(r"\s*(ANSI/AAMA|ASTM|UNITS|PIECE NAME|STYLE NAME)\b", re.IGNORECASE)


def read_dxf(path: Path) -> DrawnPieces:
    """Read the pieces of a DXF file. Lines and arcs of one layer that meet become one curve."""
    from ezdxf.filemanagement import readfile

    with opened(path, MAX_DRAWING), foreign(path, "a DXF file"):
        document = readfile(path)
        _check_unpacked(document)
        return _pieces(document, path)


def _check_unpacked(document: Any) -> None:
    """Refuse a drawing whose inserted blocks, which may include other blocks many times, have too many entities."""
    blocks = {"": document.modelspace(), **{f"*{block.name.casefold()}": block for block in document.blocks}}
    known: dict[str, int] = {}

    def size(name: str, around: tuple[str, ...]) -> int:
        if name not in blocks or name in known:
            return known.get(name, 0)
        if name in around:
            raise InputError(SELF_SHOWN)
        check_parts(0, len(around))
        total = 1 + len(blocks[name])
        for insert in blocks[name].query("INSERT"):
            total += max(int(insert.mcount), 1) * size(f"*{insert.dxf.name.casefold()}", (*around, name))
        check_parts(total, 0, 60_000)  # each takes a third of a millisecond
        return known.setdefault(name, total)

    size("", ())


def _pieces(document: Any, path: Path) -> DrawnPieces:
    from ezdxf.disassemble import recursive_decompose

    space = document.modelspace()
    loose = [entity for entity in space if entity.dxftype() != "INSERT"]
    shown = [(insert.dxf.name, [insert]) for insert in space.query("INSERT")]
    if not shown and not any(entity.dxftype() in KINDS for entity in loose):
        shown = [(block.name, block) for block in document.blocks if not block.is_any_layout]
    blocks = [(one_line(name), list(recursive_decompose(entities))) for name, entities in shown]
    everything = [*loose, *(entity for _, block in blocks for entity in block)]
    unit = _unit(everything, document, path)
    pieces = _pattern(blocks, loose, unit.metres)
    if not pieces:
        curves = [curve for layer in _layers(loose, unit.metres).values() for curve in layer]
        if not any(curve.closed for curve in curves):
            curves = [curve for layer in _layers(everything, unit.metres).values() for curve in layer]
        pieces = grouped(curves)
    return DrawnPieces(pieces, unit)


def _texts(entities: Iterable[Any]) -> list[str]:
    return [
        one_line(str(entity.dxf.text if entity.dxftype() == "TEXT" else entity.plain_text()))
        for entity in entities
        if entity.dxftype() in ("TEXT", "MTEXT")
    ]


def _unit(entities: list[Any], document: Any, path: Path) -> Unit:
    """Return the unit of a drawing. One in a text overrides $INSUNITS, which many programs do not set."""
    from ezdxf.enums import InsertUnits
    from ezdxf.units import conversion_factor

    if stated := _stated(_texts(entities), r"\s*UNITS\s*:\s*(METRIC|ENGLISH)\s*"):
        metres, name = {"METRIC": (1e-3, "millimetres"), "ENGLISH": (0.0254, "inches")}[stated.upper()]
        return Unit(metres, name, f"DXF of a pattern, UNITS: {stated.upper()}")
    # A file without a header states no unit: the unit is then unknown, even if the reader has a default.
    code = int(document.units) if b"$INSUNITS" in read_bytes(path, MAX_DRAWING) else 0
    if code == 0:
        return Unit(1e-3, "millimetres", "assumed: the DXF states no unit")
    try:
        metres = float(conversion_factor(InsertUnits(code), InsertUnits.Meters))
    except (ValueError, TypeError):
        raise InputError(
            f"$INSUNITS: must be the code of a unit of length, given {code}; give --scale in metres per unit"
        ) from None
    near = next((name for scale, name in NAMES.items() if abs(scale / metres - 1.0) < 1e-6), None)
    return Unit(metres, near or InsertUnits(code).name.lower(), f"DXF, $INSUNITS {code}")


def _layers(entities: Iterable[Any], scale: float) -> Layers:
    """Return all curves of a drawing by layer; lines that touch at their ends are joined."""
    layers: dict[str, list[np.ndarray]] = {}
    drawn = [entity for entity in entities if entity.dxftype() in KINDS]
    bent = sum(entity.dxftype() != "LINE" for entity in drawn)
    if bent > 10_000:  # each takes a millisecond
        raise InputError(
            f"outline: must have at most 10000 curves other than lines, given {bent}; simplify the drawing"
        )
    points = 0
    for entity in drawn:
        flat = _flattened(entity, scale)
        points += len(flat)
        if points > MAX_PARTS:
            raise InputError(f"outline: must have at most {MAX_PARTS} points in total; simplify the drawing")
        if len(flat) > 1:
            layers.setdefault(one_line(str(entity.dxf.layer)), []).append(flat)
    return {layer: _joined(layer, lines, 1e-6 / scale) for layer, lines in layers.items()}


def _flattened(entity: Any, scale: float) -> np.ndarray:
    """Return points along a curve, shape (k, 2)."""
    from ezdxf.path import make_path

    kind = entity.dxftype()
    drawn = None if kind == "LINE" else make_path(entity)
    ends = (entity.dxf.start, entity.dxf.end) if drawn is None else drawn.control_vertices()
    corners = np.array([(p.x, p.y) for p in ends], dtype=float).reshape(-1, 2)
    if not (np.abs(corners) < MAX_COORDINATE).all():
        raise InputError(f"outline: coordinates of a {kind} must be finite and at most {MAX_COORDINATE:g}")
    if drawn is None:
        return corners
    if len(corners) > MAX_PARTS:
        raise InputError(f"outline: a {kind} must have at most {MAX_PARTS} points; simplify the drawing")
    extent = float(np.ptp(corners, axis=0).max(initial=0.0)) if len(corners) else 0.0
    # at most 0.1 mm off, or more for very large arcs
    near = max(1e-4 / scale, 1e-5 * extent, 1e-10 * float(np.abs(corners).max(initial=0.0)))
    return np.array([(p.x, p.y) for p in drawn.flattening(near)], dtype=float).reshape(-1, 2)


def _joined(layer: str, lines: list[np.ndarray], near: float) -> list[DrawnCurve]:
    """Join the lines of a layer that touch at their ends, and return all lines as curves with the layer's name."""
    rounded = [np.round(line / near) for line in lines]
    joined = shapely.line_merge(shapely.MultiLineString([line for line in rounded if len(np.unique(line, axis=0)) > 1]))
    name = "" if layer.lower() in ("0", "defpoints") else layer
    found = [polyline(name, near * np.array(line.coords)) for line in shapely.get_parts(joined)]
    return [curve for curve in found if curve]


def _pattern(blocks: list[tuple[str, list[Any]]], loose: list[Any], scale: float) -> tuple[Piece, ...]:
    """Return the pieces of a sewing pattern in the apparel industry's form; none if it has another form."""
    made = []
    for block, entities in blocks:
        title = _stated(_texts(entities), r"\s*PIECE NAME\s*:\s*(\S.*?)\s*") or block
        piece = _pattern_piece(title, _layers(entities, scale))
        if piece is not None:
            made.append((block, piece))
    # if the blocks were exploded, their entities lie outside blocks
    if not made and any(STYLE.match(text) for text in _texts(loose)):
        return grouped([replace(curve, name="") for curve in _closed(_layers(loose, scale), BOUNDARY)])
    titles = [piece.name for _, piece in made]
    names = distinct([block if titles.count(piece.name) > 1 else piece.name for block, piece in made])
    return tuple(replace(piece, name=name) for name, (_, piece) in zip(names, made, strict=True))


def _stated(texts: Iterable[str], form: str) -> str | None:
    """Return what the first text of a form, a regular expression with a group, states."""
    return next((found[1] for text in texts if (found := re.fullmatch(form, text, re.IGNORECASE))), None)


def _pattern_piece(name: str, layers: Layers) -> Piece | None:
    """Make a piece of a sewing pattern from its curves by layer; None without a closed boundary.

    A closed sew line is the outline, because cloth outside is hidden inside the sewn garment; otherwise the cut line
    is.
    """
    cut, sewn = _closed(layers, BOUNDARY), _closed(layers, SEW)
    if not cut:
        return None
    remarks = (
        ("the garment is cut along the sew line (layer 14), because the seam allowance ends up inside",) if sewn else ()
    )
    holes = [replace(hole, name="") for hole in _closed(layers, CUT_OUT)]
    grain = _longest(layers, GRAIN)
    along = np.zeros(2) if grain is None else grain[1] - grain[0]
    length = float(np.linalg.norm(along))
    curves = (replace((sewn or cut)[0], name=name), *holes)
    return Piece(name, curves, along / length if length > 0.0 else None, _longest(layers, MIRROR), remarks)


def _closed(layers: Layers, layer: str) -> list[DrawnCurve]:
    """Return the closed curves of a layer, from the largest to the smallest extent."""
    loops = [curve for curve in layers.get(layer, ()) if curve.closed]
    return sorted(loops, key=lambda curve: -float(np.prod(np.ptp(curve.points, axis=0))))


def _longest(layers: Layers, layer: str) -> np.ndarray | None:
    """Return both ends of the longest line of a layer, shape (2, 2); None if the layer has no line."""
    ends = [curve.points[[0, -1]] for curve in layers.get(layer, ())]
    return max(ends, key=lambda pair: float(np.linalg.norm(pair[1] - pair[0])), default=None)
