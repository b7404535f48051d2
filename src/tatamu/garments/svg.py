"""SVG files: their curves, and how long one of their units is.

Coordinates are kept in the units of the outermost `viewBox`. How long such a unit is follows from `width`, whose px is
1/96 inch and pt 1/72 inch (CSS Values and Units, section 6.2); but a px of Illustrator is a point, and one of Inkscape
before 0.92 is 1/90 inch.
"""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from tatamu.errors import InputError
from tatamu.files import read_text
from tatamu.garments.drawing import DrawnPieces, polyline, where
from tatamu.garments.pieces import grouped
from tatamu.garments.units import Unit

STEPS = 32
"""Points per curved segment of an SVG path."""
INCH = 0.0254
LENGTHS = {
    "mm": (1e-3, "millimetres"),
    "cm": (1e-2, "centimetres"),
    "q": (0.25e-3, "quarter millimetres"),
    "in": (INCH, "inches"),
    "pt": (INCH / 72.0, "points of 1/72 inch"),
    "pc": (INCH / 6.0, "picas of 1/6 inch"),
}
"""Metres and names of the units that `width` may have, besides px."""
LENGTH = re.compile(r"\s*([+-]?[0-9]*\.?[0-9]+(?:e[+-]?[0-9]+)?)\s*(mm|cm|q|in|pt|pc|px|)\s*", re.IGNORECASE)
GIVEN_BY_PROGRAM = re.compile(
    r"(path|line|polyline|polygon|rect|rectangle|ellipse|circle|vector|shape|curve|group|g|use|svg|layer|spline|object)"
    r"[\s_.-]*[0-9][0-9\s_.-]*|(path|line|polyline|polygon|rect|rectangle|ellipse|circle|vector|shape|curve)",
    re.IGNORECASE,
)
"""Names that drawing programs give to what its author did not name, such as path1234, Rectangle_2 or Vector."""
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


@dataclass(frozen=True)
class _Program:
    """The program that wrote a file."""

    name: str
    pixels: int = 96
    """How many of its px are an inch."""


def read_svg(path: Path) -> DrawnPieces:
    """The curves of an SVG file.

    Raises:
        InputError: The file cannot be read or is no SVG.
    """
    import svgelements

    text = read_text(path)
    try:
        root = ElementTree.fromstring(text.encode())
        if root.tag.rpartition("}")[2] != "svg":
            raise ValueError(f"it holds <{root.tag.rpartition('}')[2]}>")
        width, height = _viewbox(root) or (1000.0, 1000.0)
        unit = _unit(root, text, path)
        for size in ("width", "height", "viewBox", "preserveAspectRatio"):
            root.attrib.pop(size, None)
        plain = io.BytesIO(ElementTree.tostring(root))
        drawing = svgelements.SVG.parse(plain, ppi=96, width=width, height=height, reify=True)
        shapes = [shape for shape in drawing.elements() if isinstance(shape, svgelements.Shape)]
    except (ElementTree.ParseError, ValueError, TypeError, AttributeError, KeyError, LookupError) as error:
        raise InputError(f"{path}: is not an SVG file ({error})") from None
    curves = [
        polyline(_name(shape), _flattened(part) * [1, -1])
        for shape in shapes
        for part in svgelements.Path(shape).as_subpaths()
    ]
    return DrawnPieces(grouped([curve for curve in curves if curve]), unit)


def _name(shape: Any) -> str:
    """The author's name of a shape; empty where the program gave it."""
    own = shape.values.get("attributes", {})
    label = own.get(f"{INKSCAPE}label") or own.get("data-name") or own.get("id") or ""
    label = re.sub(r"_x([0-9A-Fa-f]{2,4})_", lambda code: chr(int(code[1], 16)), label)  # as Illustrator writes them
    return "" if GIVEN_BY_PROGRAM.fullmatch(label) else label


def _viewbox(root: ElementTree.Element) -> tuple[float, float] | None:
    """Width and height of what is seen, in units of the drawing."""
    numbers = [float(number) for number in re.split(r"[\s,]+", root.get("viewBox", "").strip()) if number]
    if len(numbers) == 4 and numbers[2] > 0.0 and numbers[3] > 0.0:
        return numbers[2], numbers[3]
    return None


def _program(root: ElementTree.Element, text: str) -> _Program:
    version = root.get(f"{INKSCAPE}version", "")
    if version or "http://www.inkscape.org/namespaces" in text:
        first = re.match(r"0\.([0-9]+)", version)
        return _Program("Inkscape SVG", 90 if first and int(first[1]) < 92 else 96)
    if re.search(r"<!--\s*Generator:\s*Adobe Illustrator", text) or "http://ns.adobe.com/" in text:
        return _Program("Illustrator SVG", 72)
    if re.search(r'<svg[^>]*\sdata-name="Layer', text):  # as Illustrator exports for screens, without a comment
        return _Program("Illustrator SVG", 72)
    return _Program("SVG")


def _unit(root: ElementTree.Element, text: str, path: Path) -> Unit:
    """How long a unit of the drawing's coordinates is."""
    program = _program(root, text)
    pixel = INCH / program.pixels
    pixels = "points of 1/72 inch" if program.pixels == 72 else f"pixels of 1/{program.pixels} inch"
    sizes = {side: LENGTH.fullmatch(root.get(side, "")) for side in ("width", "height")}
    given = {side: found for side, found in sizes.items() if found and float(found[1]) > 0.0}
    if not given:
        if program.name != "SVG":
            return Unit(pixel, pixels, f"{program.name} without a width")
        return Unit(1e-3, "millimetres", "assumed: the SVG has no width", assumed=True)
    side, found = next(iter(given.items()))
    name = LENGTHS.get(found[2].lower(), (pixel, pixels))[1]
    stated = f"{program.name}, {side} {found[0].strip()}"
    seen = _viewbox(root)
    if seen is None:
        return Unit(pixel, pixels, f"{stated}, no viewBox")
    return Unit(_per_unit(root, given, seen, pixel, path), name, stated)


def _per_unit(
    root: ElementTree.Element, given: dict[str, re.Match[str]], seen: tuple[float, float], pixel: float, path: Path
) -> float:
    """Metres per unit of a drawing of which an extent `seen` is fitted into its width and height."""
    extent = dict(zip(("width", "height"), seen, strict=True))
    scales = []
    for side, found in given.items():
        metres = LENGTHS.get(found[2].lower(), (pixel, ""))[0]
        scales.append(float(found[1]) * metres / extent[side])
    if max(scales) > 1.001 * min(scales):
        fitting = root.get("preserveAspectRatio", "")
        if fitting.strip().startswith("none"):
            raise InputError(
                where(path, "must not be stretched (preserveAspectRatio none): width is no measure of height")
            )
        return max(scales) if "slice" in fitting else min(scales)
    return scales[0]


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
