"""Reads SVG files: their curves, and the length of one unit of the drawing.

Coordinates stay in units of the outermost `viewBox`, whose length follows from `width`. There, px is 1/96 inch and pt
1/72 inch (CSS Values and Units, section 6.2), but a px of Illustrator is 1/72 inch, and one of Inkscape before 0.92
1/90 inch.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

from tatamu.base.errors import InputError, one_line
from tatamu.base.files import MIB, foreign, read_text
from tatamu.garments.drawing import DrawnPieces, where
from tatamu.garments.pieces import grouped
from tatamu.garments.svg_shapes import PIXELS, Page, Shape, view_box, visible_shapes
from tatamu.garments.units import Unit
from tatamu.garments.unpacking import LARGEST_DRAWING

INCH = 0.0254
LENGTHS = {
    "mm": (1e-3, "millimetres"),
    "cm": (1e-2, "centimetres"),
    "q": (0.25e-3, "quarter millimetres"),
    "in": (INCH, "inches"),
    "pt": (INCH / 72.0, "points of 1/72 inch"),
    "pc": (INCH / 6.0, "picas of 1/6 inch"),
}
"""Metres and name of each unit of `width`, except px."""
LENGTH = re.compile(r"\s*([+-]?[0-9]*\.?[0-9]+(?:e[+-]?[0-9]+)?)\s*(mm|cm|q|in|pt|pc|px|)\s*", re.IGNORECASE)
GIVEN_BY_PROGRAM = re.compile(
    r"(path|line|polyline|polygon|rect|rectangle|ellipse|circle|vector|shape|curve|group|g|use|svg|layer|spline|object)"
    r"[\s_.-]*[0-9][0-9\s_.-]*|(path|line|polyline|polygon|rect|rectangle|ellipse|circle|vector|shape|curve)",
    re.IGNORECASE,
)
"""Names that drawing programs give, such as path1234, Rectangle_2 or Vector."""
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


@dataclass(frozen=True)
class _Program:
    name: str
    pixels: int = 96
    """Number of px per inch."""


def read_svg(path: Path) -> DrawnPieces:
    """Read the curves of an SVG file."""
    text = read_text(path, LARGEST_DRAWING)
    with foreign(path, "an SVG file"):
        _check_entities(text)
        root = ElementTree.fromstring(text.encode())
        if root.tag.rpartition("}")[2] != "svg":
            raise ValueError(f"it holds <{root.tag.rpartition('}')[2]}>")
        unit = _unit(root, text, path)
        shapes, notes = visible_shapes(root, _page(root))
        curves = [replace(curve, name=_name(shape)) for shape in shapes for curve in shape.curves]
        pieces = grouped(curves)
        return DrawnPieces(tuple(replace(piece, remarks=(*notes, *piece.remarks)) for piece in pieces), unit)


def _check_entities(text: str) -> None:
    """Refuse an SVG file whose XML entities would expand to too much text."""
    entities = dict(re.findall(r"<!ENTITY\s+([^\s%]+)\s+[\"']([^\"']*)[\"']", text))
    if any("&" in value for value in entities.values()) or re.search(r"<!ENTITY\s+%", text):
        raise InputError("outline: must have XML entities without other entities inside")
    used = Counter(re.findall(r"&([^\s&;]+);", text)) if entities else Counter()
    if sum(len(value) * used[name] for name, value in entities.items()) > LARGEST_DRAWING:
        raise InputError(f"outline: must have XML entities of at most {LARGEST_DRAWING / MIB:.0f} MiB in total")


def _name(shape: Shape) -> str:
    """Return the name that the author of a drawing gave a shape."""
    for element in shape.elements:
        label = element.get(f"{INKSCAPE}label") or element.get("data-name") or element.get("id") or ""
        label = re.sub(r"_x([0-9A-Fa-f]{2,4})_", lambda code: chr(int(code[1], 16)), label)  # Illustrator's codes
        if label and not GIVEN_BY_PROGRAM.fullmatch(label):
            return one_line(label)
    return ""


def _page(root: ElementTree.Element) -> Page | None:
    """Return the visible area in units of the drawing, if the file states it."""
    sizes = [LENGTH.fullmatch(root.get(side, "")) for side in ("width", "height")]
    pixels = [float(found[1]) * PIXELS[found[2].lower()] for found in sizes if found]
    stated = Page(0.0, 0.0, *pixels) if len(pixels) == 2 and min(pixels) > 0.0 else None
    return view_box(root) or stated


def _program(root: ElementTree.Element, text: str) -> _Program:
    version = root.get(f"{INKSCAPE}version", "")
    if version or "http://www.inkscape.org/namespaces" in text:
        first = re.match(r"0\.([0-9]+)", version)
        return _Program("Inkscape SVG", 90 if first and int(first[1]) < 92 else 96)
    if re.search(r"<!--\s*Generator:\s*Adobe Illustrator", text) or "http://ns.adobe.com/" in text:
        return _Program("Illustrator SVG", 72)
    if re.search(r'<svg[^>]*\sdata-name="Layer', text):  # Illustrator's export for screens, which has no comment
        return _Program("Illustrator SVG", 72)
    return _Program("SVG")


def _unit(root: ElementTree.Element, text: str, path: Path) -> Unit:
    """Return the unit of the drawing's coordinates."""
    program = _program(root, text)
    pixel = INCH / program.pixels
    pixels = "points of 1/72 inch" if program.pixels == 72 else f"pixels of 1/{program.pixels} inch"
    sizes = {side: LENGTH.fullmatch(root.get(side, "")) for side in ("width", "height")}
    given = {side: found for side, found in sizes.items() if found and float(found[1]) > 0.0}
    if not given:
        if program.name != "SVG":
            return Unit(pixel, pixels, f"{program.name} without a width")
        return Unit(1e-3, "millimetres", "assumed: the SVG has no width")
    side, found = next(iter(given.items()))
    name = LENGTHS.get(found[2].lower(), (pixel, pixels))[1]
    stated = f"{program.name}, {side} {found[0].strip()}"
    seen = view_box(root)
    if seen is None:
        return Unit(pixel, pixels, f"{stated}, no viewBox")
    return Unit(_per_unit(root, given, (seen.width, seen.height), pixel, path), name, stated)


def _per_unit(
    root: ElementTree.Element, given: dict[str, re.Match[str]], seen: tuple[float, float], pixel: float, path: Path
) -> float:
    """Return the length of one unit of a drawing [m], whose visible extent `seen` is fitted into the stated size."""
    extent = dict(zip(("width", "height"), seen, strict=True))
    scales = []
    for side, found in given.items():
        metres = LENGTHS.get(found[2].lower(), (pixel, ""))[0]
        scales.append(float(found[1]) * metres / extent[side])
    if max(scales) > 1.001 * min(scales):
        fitting = root.get("preserveAspectRatio", "")
        if fitting.strip().startswith("none"):
            raise InputError(
                where(
                    path,
                    "must not be stretched (preserveAspectRatio none), because its width does not give the scale of "
                    "its height",
                )
            )
        return max(scales) if "slice" in fitting else min(scales)
    return scales[0]
