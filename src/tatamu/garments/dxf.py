"""Reads DXF files: the pieces of a sewing pattern, or else one curve for each layer, with the layer's name."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from tatamu.base.errors import InputError, one_line
from tatamu.base.files import foreign, opened, read_bytes
from tatamu.garments import apparel
from tatamu.garments.drawing import (
    MAX_COORDINATE,
    MAX_DRAWING,
    MAX_PARTS,
    SELF_SHOWN,
    DrawnCurve,
    DrawnPieces,
    Piece,
    check_parts,
    polyline,
)
from tatamu.garments.pieces import distinct, grouped
from tatamu.garments.units import NAMES, Unit

KINDS = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")
"""Types of DXF entities that are curves."""
MAX_ENTITIES = 60_000
"""Maximum number of entities, each inserted block counted as its own; each takes a third of a millisecond."""
MAX_CURVED = 10_000
"""Largest number of curves of a drawing; straight lines are not counted. Reading takes a millisecond per curve."""
Layers = dict[str, list[np.ndarray]]


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
        check_parts(total, 0, MAX_ENTITIES)
        return known.setdefault(name, total)

    size("", ())


def _pieces(document: Any, path: Path) -> DrawnPieces:
    space = document.modelspace()
    blocks = [list(_parts([insert])) for insert in space.query("INSERT")]
    loose = [entity for entity in space if entity.dxftype() != "INSERT"]
    if not blocks and not any(entity.dxftype() in KINDS for entity in loose):
        blocks = [list(_parts(block)) for block in document.blocks if not block.is_any_layout]
        names = [block.name for block in document.blocks if not block.is_any_layout]
    else:
        names = [insert.dxf.name for insert in space.query("INSERT")]
    unit = _unit(document, [*loose, *(entity for block in blocks for entity in block)], path)
    named = [(one_line(name), block) for name, block in zip(names, blocks, strict=True)]
    pieces = _pattern(named, loose, unit.metres)
    if not pieces:
        layers = _layers(loose, unit.metres)
        if not any(curve.closed for curve in _curves(layers, unit.metres)):
            layers = _layers([*loose, *(entity for block in blocks for entity in block)], unit.metres)
        pieces = grouped(_curves(layers, unit.metres))
    return DrawnPieces(pieces, unit)


def _parts(entities: Iterable[Any]) -> Iterable[Any]:
    """Yield all entities of a drawing, with those of inserted blocks at their positions."""
    from ezdxf.disassemble import recursive_decompose

    return recursive_decompose(entities)


def _texts(entities: Iterable[Any]) -> list[str]:
    return [
        one_line(str(entity.dxf.text if entity.dxftype() == "TEXT" else entity.plain_text()))
        for entity in entities
        if entity.dxftype() in ("TEXT", "MTEXT")
    ]


def _unit(document: Any, entities: list[Any], path: Path) -> Unit:
    """Return the unit of a drawing. One in a text overrides $INSUNITS, which many programs do not set."""
    from ezdxf.enums import InsertUnits
    from ezdxf.units import conversion_factor

    stated = apparel.unit(_texts(entities))
    if stated is not None:
        return stated
    # A file without a header states no unit: the unit is then unknown, even if the reader has a default.
    code = int(document.units) if b"$INSUNITS" in read_bytes(path, MAX_DRAWING) else 0
    if code == 0:
        return Unit(1e-3, "millimetres", "assumed: the DXF states no unit")
    try:
        metres = float(conversion_factor(InsertUnits(code), InsertUnits.Meters))
    except (ValueError, TypeError):
        raise InputError(f"{path}: its unit ($INSUNITS {code}) has no size in metres; give scale") from None
    near = next((name for scale, name in NAMES.items() if abs(scale / metres - 1.0) < 1e-6), None)
    return Unit(metres, near or InsertUnits(code).name.lower(), f"DXF, $INSUNITS {code}")


def _layers(entities: Iterable[Any], scale: float) -> Layers:
    """Return all polylines of a drawing, shape (k, 2), by layer."""
    layers: Layers = {}
    drawn = [entity for entity in entities if entity.dxftype() in KINDS]
    bent = sum(entity.dxftype() != "LINE" for entity in drawn)
    if bent > MAX_CURVED:
        raise InputError(
            f"outline: must have at most {MAX_CURVED} curves besides lines, given {bent}; simplify the drawing"
        )
    points = 0
    for entity in drawn:
        flat = _flattened(entity, scale)
        points += len(flat)
        if points > MAX_PARTS:
            raise InputError(f"outline: must have curves of at most {MAX_PARTS} points in all; simplify the drawing")
        if len(flat) > 1:
            layers.setdefault(one_line(str(entity.dxf.layer)), []).append(flat)
    return layers


def _flattened(entity: Any, scale: float) -> np.ndarray:
    """Return points along a curve, shape (k, 2)."""
    from ezdxf.path import make_path

    kind = entity.dxftype()
    drawn = None if kind == "LINE" else make_path(entity)
    ends = (entity.dxf.start, entity.dxf.end) if drawn is None else drawn.control_vertices()
    corners = np.array([(p.x, p.y) for p in ends], dtype=float).reshape(-1, 2)
    if not (np.abs(corners) < MAX_COORDINATE).all():
        raise InputError(
            f"outline: must have coordinates that are finite and at most {MAX_COORDINATE:g}, given others in a {kind}"
        )
    if drawn is None:
        return corners
    if len(corners) > MAX_PARTS:
        raise InputError(f"outline: must have curves of at most {MAX_PARTS} points, given more in a {kind}")
    extent = float(np.ptp(corners, axis=0).max(initial=0.0)) if len(corners) else 0.0
    # at most 0.1 mm off, or more for very large arcs
    near = max(1e-4 / scale, 1e-5 * extent, 1e-10 * float(np.abs(corners).max(initial=0.0)))
    return np.array([(p.x, p.y) for p in drawn.flattening(near)], dtype=float).reshape(-1, 2)


def _curves(layers: Layers, scale: float) -> list[DrawnCurve]:
    found = [
        polyline("" if layer.lower() in ("0", "defpoints") else layer, line)
        for layer, lines in layers.items()
        for line in _merged(lines, 1e-6 / scale)
    ]
    return [curve for curve in found if curve]


def _merged(lines: list[np.ndarray], near: float) -> list[np.ndarray]:
    """Join lines that touch at their ends, and return all lines."""
    rounded = [np.round(line / near) for line in lines]
    joined = shapely.line_merge(shapely.MultiLineString([line for line in rounded if len(np.unique(line, axis=0)) > 1]))
    return [near * np.array(line.coords) for line in shapely.get_parts(joined)]


def _pattern(blocks: list[tuple[str, list[Any]]], loose: list[Any], scale: float) -> tuple[Piece, ...]:
    """Return the pieces of a sewing pattern in the apparel industry's form; none if it has another form."""
    made = []
    for block, entities in blocks:
        curves = {layer: _curves({layer: lines}, scale) for layer, lines in _layers(entities, scale).items()}
        piece = apparel.piece(apparel.title(_texts(entities), block), curves)
        if piece is not None:
            made.append((block, piece))
    if not made and apparel.is_pattern(_texts(loose)):  # the blocks were exploded: their entities lie outside blocks
        curves = {layer: _curves({layer: lines}, scale) for layer, lines in _layers(loose, scale).items()}
        return apparel.loose_pieces(curves)
    titles = [piece.name for _, piece in made]
    names = distinct([block if titles.count(piece.name) > 1 else piece.name for block, piece in made])
    return tuple(replace(piece, name=name) for name, (_, piece) in zip(names, made, strict=True))
