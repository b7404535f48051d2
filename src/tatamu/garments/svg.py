"""Reads SVG files: their curves, and the length of one unit of the drawing.

Coordinates stay in units of the outermost `viewBox`, whose length follows from `width`. There, px is 1/96 inch and pt
1/72 inch (CSS Values and Units, section 6.2), but a px of Illustrator is 1/72 inch, and one of Inkscape before 0.92
1/90 inch.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

from tatamu.base.errors import InputError, one_line
from tatamu.base.files import MIB, foreign, read_text
from tatamu.garments.drawing import MAX_DRAWING, DrawnPieces, grouped
from tatamu.garments.svg_shapes import INCH, LENGTH, UNITS, Page, Shape, view_box, visible_shapes
from tatamu.garments.units import Unit

GIVEN_BY_PROGRAM = re.compile(
    r"(path|line|polyline|polygon|rect|rectangle|ellipse|circle|vector|shape|curve|group|g|use|svg|layer|spline|object)"
    r"[\s_.-]*[0-9][0-9\s_.-]*|(path|line|polyline|polygon|rect|rectangle|ellipse|circle|vector|shape|curve)",
    re.IGNORECASE,
)
"""Names that drawing programs give, such as path1234, Rectangle_2 or Vector."""
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


def read_svg(path: Path) -> DrawnPieces:
    """Read the curves of an SVG file."""
    text = read_text(path, MAX_DRAWING)
    with foreign(path, "an SVG file"):
        _check_entities(text)
        root = ElementTree.fromstring(text.encode())
        if root.tag.rpartition("}")[2] != "svg":
            raise ValueError(f"the file contains <{root.tag.rpartition('}')[2]}>")
        unit = _unit(root, text)
        pixels = [float(size[1]) * UNITS[size[2].lower()].pixels for size in _sizes(root).values()]
        page = view_box(root) or (Page(0.0, 0.0, *pixels) if len(pixels) == 2 else None)
        shapes, notes = visible_shapes(root, page)
        curves = [replace(curve, name=_name(shape)) for shape in shapes for curve in shape.curves]
        pieces = grouped(curves)
        return DrawnPieces(tuple(replace(piece, remarks=(*notes, *piece.remarks)) for piece in pieces), unit)


def _check_entities(text: str) -> None:
    """Refuse an SVG file whose XML entities would expand to too much text."""
    entities = dict(re.findall(r"<!ENTITY\s+([^\s%]+)\s+[\"']([^\"']*)[\"']", text))
    if any("&" in value for value in entities.values()) or re.search(r"<!ENTITY\s+%", text):
        raise InputError("outline: must not have XML entities that contain other entities")
    used = Counter(re.findall(r"&([^\s&;]+);", text)) if entities else Counter()
    if sum(len(value) * used[name] for name, value in entities.items()) > MAX_DRAWING:
        raise InputError(f"outline: must have XML entities of at most {MAX_DRAWING / MIB:.0f} MiB in total")


def _name(shape: Shape) -> str:
    """Return the name that the author of a drawing gave a shape."""
    for element in shape.elements:
        label = element.get(f"{INKSCAPE}label") or element.get("data-name") or element.get("id") or ""
        label = re.sub(r"_x([0-9A-Fa-f]{2,4})_", lambda code: chr(int(code[1], 16)), label)  # Illustrator's codes
        if label and not GIVEN_BY_PROGRAM.fullmatch(label):
            return one_line(label)
    return ""


def _sizes(root: ElementTree.Element) -> dict[str, re.Match[str]]:
    found = {side: LENGTH.fullmatch(root.get(side, "")) for side in ("width", "height")}
    return {side: size for side, size in found.items() if size and size[2].lower() in UNITS and float(size[1]) > 0.0}


def _program(root: ElementTree.Element, text: str) -> tuple[str, int]:
    """Return the kind of file that a program wrote, and its number of px per inch."""
    version = root.get(f"{INKSCAPE}version", "")
    if version or "http://www.inkscape.org/namespaces" in text:
        first = re.match(r"0\.([0-9]+)", version)
        return "Inkscape SVG", 90 if first and int(first[1]) < 92 else 96
    # Illustrator's export for screens has no comment, but names its layers.
    if re.search(r"<!--\s*Generator:\s*Adobe Illustrator|http://ns.adobe.com/|<svg[^>]*\sdata-name=\"Layer", text):
        return "Illustrator SVG", 72
    return "SVG", 96


def _unit(root: ElementTree.Element, text: str) -> Unit:
    """Return the unit of the drawing's coordinates."""
    program, per_inch = _program(root, text)
    pixel = INCH / per_inch
    name = "points of 1/72 inch" if per_inch == 72 else f"pixels of 1/{per_inch} inch"
    sizes, seen = _sizes(root), view_box(root)
    if not sizes and program == "SVG":
        return Unit(1e-3, "millimetres", "assumed: the SVG has no width")
    if not sizes:
        return Unit(pixel, name, f"{program} without a width")
    side, first = next(iter(sizes.items()))
    stated = f"{program}, {side} {first[0].strip()}"
    if seen is None:
        return Unit(pixel, name, f"{stated}, no viewBox")
    scales = [float(size[1]) * (UNITS[size[2].lower()].metres or pixel) / getattr(seen, k) for k, size in sizes.items()]
    return Unit(_scale(scales, root.get("preserveAspectRatio", "")), UNITS[first[2].lower()].name or name, stated)


def _scale(scales: list[float], fitting: str) -> float:
    """Return the length of one unit of a drawing [m] that is fitted into a page, from those along its sides."""
    if max(scales) <= 1.001 * min(scales):
        return scales[0]
    if fitting.strip().startswith("none"):
        ratio = "page and viewBox must have the same aspect ratio"
        raise InputError(f"outline: {ratio}, because preserveAspectRatio = none stretches the drawing")
    return max(scales) if "slice" in fitting else min(scales)
