"""DXF files: their curves by layer or, of a pattern in the apparel industry's form, its pieces; and their unit."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from tatamu.errors import InputError
from tatamu.garments import apparel
from tatamu.garments.drawing import DrawnCurve, DrawnPieces, Piece, polyline
from tatamu.garments.pieces import distinct, grouped
from tatamu.garments.units import NAMES, Unit

KINDS = ("LINE", "LWPOLYLINE", "POLYLINE", "ARC", "CIRCLE", "ELLIPSE", "SPLINE")
"""Entities that are curves."""
NAMELESS = ("0", "defpoints")
"""Layers that every DXF has: no name of a curve."""
FLATNESS = 1e-4
"""Arcs become polylines that leave them by less than this [m]."""
MEETING = 1e-6
"""Ends that are this near to each other were drawn to meet [m]."""
Layers = dict[str, list[np.ndarray]]


def read_dxf(path: Path) -> DrawnPieces:
    """The pieces of a DXF file; lines and arcs of one layer that meet are one curve.

    Raises:
        InputError: The file cannot be read or is no DXF.
    """
    document = _document(path)
    space = document.modelspace()
    blocks = [list(_parts([insert])) for insert in space.query("INSERT")]
    loose = [entity for entity in space if entity.dxftype() != "INSERT"]
    if not blocks and not any(entity.dxftype() in KINDS for entity in loose):
        blocks = [list(_parts(block)) for block in document.blocks if not block.is_any_layout]
        names = [block.name for block in document.blocks if not block.is_any_layout]
    else:
        names = [insert.dxf.name for insert in space.query("INSERT")]
    unit = _unit(document, [*loose, *(entity for block in blocks for entity in block)], path)
    named = [(name, block) for name, block in zip(names, blocks, strict=True)]
    pieces = _pattern(named, loose, unit.metres, path)
    if not pieces:
        layers = _layers(loose, unit.metres, path)
        if not any(curve.closed for curve in _curves(layers, unit.metres)):
            layers = _layers([*loose, *(entity for block in blocks for entity in block)], unit.metres, path)
        pieces = grouped(_curves(layers, unit.metres))
    return DrawnPieces(pieces, unit)


def _document(path: Path) -> Any:
    from ezdxf.filemanagement import readfile
    from ezdxf.lldxf.const import DXFError

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # old versions of the format, which are read all the same
            return readfile(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except (DXFError, UnicodeDecodeError, ValueError) as error:
        raise InputError(f"{path}: is not a DXF file ({error})") from None


def _parts(entities: Iterable[Any]) -> Iterable[Any]:
    """The entities of blocks, where they were inserted."""
    from ezdxf.disassemble import recursive_decompose

    return recursive_decompose(entities)


def _texts(entities: Iterable[Any]) -> list[str]:
    """The texts of a drawing."""
    return [
        str(entity.dxf.text if entity.dxftype() == "TEXT" else entity.plain_text()).strip()
        for entity in entities
        if entity.dxftype() in ("TEXT", "MTEXT")
    ]


def _unit(document: Any, entities: list[Any], path: Path) -> Unit:
    """The unit in the text of the pattern goes before $INSUNITS of the header, which many programs leave as it is."""
    from ezdxf.enums import InsertUnits
    from ezdxf.units import conversion_factor

    stated = apparel.unit(_texts(entities))
    if stated is not None:
        return stated
    # A file without a header has none of its own: its unit is then not known, whatever the reader's default is.
    code = int(document.units) if b"$INSUNITS" in path.read_bytes() else 0
    if code == 0:
        return Unit(1e-3, "millimetres", "assumed: the DXF states no unit", assumed=True)
    try:
        metres = float(conversion_factor(InsertUnits(code), InsertUnits.Meters))
    except (ValueError, TypeError):
        raise InputError(f"{path}: its unit ($INSUNITS {code}) has no size in metres; give scale") from None
    near = next((name for scale, name in NAMES.items() if abs(scale / metres - 1.0) < 1e-6), None)
    return Unit(metres, near or InsertUnits(code).name.lower(), f"DXF, $INSUNITS {code}")


def _layers(entities: Iterable[Any], scale: float, path: Path) -> Layers:
    """All lines of a drawing by layer, each of shape (k, 2)."""
    from ezdxf.path import make_path

    layers: Layers = {}
    for entity in entities:
        if entity.dxftype() not in KINDS:
            continue
        try:
            flat = [(p.x, p.y) for p in make_path(entity).flattening(FLATNESS / scale)]
        except ValueError as error:
            raise InputError(f"{path}: a {entity.dxftype()} is damaged ({error})") from None
        if len(flat) > 1:
            layers.setdefault(str(entity.dxf.layer), []).append(np.array(flat))
    return layers


def _curves(layers: Layers, scale: float) -> list[DrawnCurve]:
    found = [
        polyline("" if layer.lower() in NAMELESS else layer, line)
        for layer, lines in layers.items()
        for line in _merged(lines, MEETING / scale)
    ]
    return [curve for curve in found if curve]


def _merged(lines: list[np.ndarray], near: float) -> list[np.ndarray]:
    """Lines that meet made one."""
    rounded = [np.round(line / near) for line in lines]
    joined = shapely.line_merge(shapely.MultiLineString([line for line in rounded if len(np.unique(line, axis=0)) > 1]))
    return [near * np.array(line.coords) for line in shapely.get_parts(joined)]


def _pattern(blocks: list[tuple[str, list[Any]]], loose: list[Any], scale: float, path: Path) -> tuple[Piece, ...]:
    """The pieces of a pattern in the apparel industry's form; none if it is no such pattern."""
    made = []
    for block, entities in blocks:
        curves = {layer: _curves({layer: lines}, scale) for layer, lines in _layers(entities, scale, path).items()}
        piece = apparel.piece(apparel.title(_texts(entities), block), curves)
        if piece is not None:
            made.append((block, piece))
    if not made and apparel.is_pattern(_texts(loose)):  # its blocks were exploded
        curves = {layer: _curves({layer: lines}, scale) for layer, lines in _layers(loose, scale, path).items()}
        return apparel.loose_pieces(curves)
    titles = [piece.name for _, piece in made]
    names = distinct([block if titles.count(piece.name) > 1 else piece.name for block, piece in made])
    return tuple(
        Piece(name, piece.curves, piece.grain, piece.fold, piece.remarks)
        for name, (_, piece) in zip(names, made, strict=True)
    )
