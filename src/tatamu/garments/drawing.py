"""Curves from SVG and DXF files."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from tatamu.errors import InputError
from tatamu.files import read_text

STEPS = 32
"""Points per curved segment of an SVG path."""
SAME = 1e-3
"""Ends nearer than this part of a curve's length are one point."""


@dataclass(frozen=True)
class DrawnCurve:
    """A polyline of a drawing: x to the right, y up [mm]."""

    name: str
    """The id of an SVG element, the layer of a DXF entity; may be empty."""
    points: np.ndarray
    """Shape (k, 2); of a closed curve without the closing point."""
    closed: bool


def read_drawing(path: Path) -> list[DrawnCurve]:
    """All curves of an SVG or DXF file, in millimetres.

    Raises:
        InputError: The file cannot be read, is neither, or has no curves.
    """
    readers = {".svg": _svg, ".dxf": _dxf}
    if path.suffix.lower() not in readers:
        raise InputError(f"{path}: outline: must be an .svg or a .dxf file")
    curves = readers[path.suffix.lower()](path)
    if not curves:
        raise InputError(f"{path}: outline: has no curve")
    return curves


def _curve(name: str, points: np.ndarray) -> DrawnCurve | None:
    """A curve without repeated points; None of fewer than two."""
    length = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], length > 1e-9])]
    if len(points) < 2:
        return None
    closed = len(points) > 3 and bool(np.linalg.norm(points[0] - points[-1]) < SAME * length.sum())
    return DrawnCurve(name, points[:-1] if closed else points, closed)


def _svg(path: Path) -> list[DrawnCurve]:
    """One SVG unit is a millimetre unless width and height say otherwise."""
    from xml.etree.ElementTree import ParseError

    import svgelements

    read_text(path)
    try:
        drawing = svgelements.SVG.parse(str(path), ppi=25.4, reify=True)
        shapes = [s for s in drawing.elements() if isinstance(s, svgelements.Shape)]
    except (ParseError, ValueError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: is not an SVG file ({error})") from None
    curves = [
        _curve(shape.id or "", _flattened(part) * [1, -1])
        for shape in shapes
        for part in svgelements.Path(shape).as_subpaths()
    ]
    return [curve for curve in curves if curve]


def _flattened(part: Any) -> np.ndarray:
    """Points along an SVG subpath, shape (k, 2)."""
    import svgelements

    points: list[tuple[float, float]] = []
    for segment in svgelements.Path(part):
        if isinstance(segment, svgelements.Move):
            points.append((segment.end.x, segment.end.y))
            continue
        steps = 1 if isinstance(segment, (svgelements.Line, svgelements.Close)) else STEPS
        points += [(p.x, p.y) for p in (segment.point(k / steps) for k in range(1, steps + 1)) if p is not None]
    return np.array(points, dtype=float).reshape(-1, 2)


def _dxf(path: Path) -> list[DrawnCurve]:
    """Units as the file says, millimetres if it does not; lines and arcs of one layer that meet are one curve."""
    from ezdxf.enums import InsertUnits
    from ezdxf.filemanagement import readfile
    from ezdxf.lldxf.const import DXFError
    from ezdxf.path import make_path
    from ezdxf.units import conversion_factor

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # old versions of the format, which are read all the same
            document = readfile(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except DXFError as error:
        raise InputError(f"{path}: is not a DXF file ({error})") from None
    try:
        scale = conversion_factor(InsertUnits(document.units), InsertUnits.Millimeters) if document.units else 1.0
    except (ValueError, TypeError):
        raise InputError(f"{path}: its unit ($INSUNITS {document.units}) has no size in millimetres") from None
    layers: dict[str, list[np.ndarray]] = {}
    for entity in document.modelspace().query("LINE LWPOLYLINE POLYLINE ARC CIRCLE ELLIPSE SPLINE"):
        try:
            flat = [(p.x, p.y) for p in make_path(entity).flattening(0.1 / scale)]
        except ValueError as error:
            raise InputError(f"{path}: a {entity.dxftype()} is damaged ({error})") from None
        layers.setdefault(entity.dxf.layer, []).append(scale * np.array(flat))
    curves = [_curve(layer, line) for layer, lines in layers.items() for line in _merged(lines)]
    return [curve for curve in curves if curve]


def _merged(lines: list[np.ndarray]) -> list[np.ndarray]:
    rounded = [np.round(line, 3) for line in lines]  # [mm]: what was drawn to meet, meets
    joined = shapely.line_merge(shapely.MultiLineString([line for line in rounded if len(np.unique(line, axis=0)) > 1]))
    return [np.array(line.coords) for line in shapely.get_parts(joined)]
