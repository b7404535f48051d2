"""Reads SVG files: their curves, and the length of one unit of the drawing.

Coordinates stay in the units of the outermost `viewBox`. The length of a unit follows from the attribute `width`. In
`width`, the unit px is 1/96 inch and the unit pt is 1/72 inch (CSS Values and Units, section 6.2). There are two
exceptions: a px of Illustrator is 1/72 inch, and a px of Inkscape before 0.92 is 1/90 inch.
"""

from __future__ import annotations

import io
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import MIB, foreign, read_text
from tatamu.garments.drawing import DrawnCurve, DrawnPieces, polyline, where
from tatamu.garments.pieces import grouped
from tatamu.garments.units import Unit
from tatamu.garments.unpacking import LARGEST_DRAWING, check_unpacked

STEPS = 32
"""Number of points per curved segment of an SVG path."""
LONGEST_STYLE = 32_768
"""Largest length of a style sheet that is read [characters]. A longer style sheet is skipped, which does no harm,
because colours and line widths do not matter."""
INCH = 0.0254
LENGTHS = {
    "mm": (1e-3, "millimetres"),
    "cm": (1e-2, "centimetres"),
    "q": (0.25e-3, "quarter millimetres"),
    "in": (INCH, "inches"),
    "pt": (INCH / 72.0, "points of 1/72 inch"),
    "pc": (INCH / 6.0, "picas of 1/6 inch"),
}
"""Length in metres and name of each unit that `width` may have, except px."""
LENGTH = re.compile(r"\s*([+-]?[0-9]*\.?[0-9]+(?:e[+-]?[0-9]+)?)\s*(mm|cm|q|in|pt|pc|px|)\s*", re.IGNORECASE)
GIVEN_BY_PROGRAM = re.compile(
    r"(path|line|polyline|polygon|rect|rectangle|ellipse|circle|vector|shape|curve|group|g|use|svg|layer|spline|object)"
    r"[\s_.-]*[0-9][0-9\s_.-]*|(path|line|polyline|polygon|rect|rectangle|ellipse|circle|vector|shape|curve)",
    re.IGNORECASE,
)
"""Regular expression for names that drawing programs give automatically, such as path1234, Rectangle_2 or Vector."""
NUMBER = re.compile(r"[0-9.]+(?:[eE][+-]?[0-9]+)?")
XLINK = "{http://www.w3.org/1999/xlink}href"
INKSCAPE = "{http://www.inkscape.org/namespaces/inkscape}"


@dataclass(frozen=True)
class _Program:
    """The program that wrote an SVG file."""

    name: str
    pixels: int = 96
    """Number of px per inch in the program's files."""


def read_svg(path: Path) -> DrawnPieces:
    """Read the curves of an SVG file.

    Raises:
        InputError: If the file cannot be read or is not an SVG file.
    """
    text = read_text(path, LARGEST_DRAWING)
    with foreign(path, "an SVG file"):
        _check_entities(text)
        root = ElementTree.fromstring(text.encode())
        if root.tag.rpartition("}")[2] != "svg":
            raise ValueError(f"it holds <{root.tag.rpartition('}')[2]}>")
        _check_unpacked(root)
        unit = _unit(root, text, path)
        return DrawnPieces(grouped(_curves(root)), unit)


def _curves(root: ElementTree.Element) -> list[DrawnCurve]:
    """Return the curves of an SVG drawing, in the drawing's units and with y up."""
    import svgelements

    width, height = _viewbox(root) or (1000.0, 1000.0)
    for size in ("width", "height", "viewBox", "preserveAspectRatio"):
        root.attrib.pop(size, None)
    for element in root.iter():
        if str(element.tag).rpartition("}")[2] == "style":
            element.text = _style(element.text or "")
    plain = io.BytesIO(ElementTree.tostring(root))
    drawing = svgelements.SVG.parse(plain, ppi=96, width=width, height=height, reify=True)
    shapes = [shape for shape in drawing.elements() if isinstance(shape, svgelements.Shape)]
    curves = [
        polyline(_name(shape), _flattened(part) * [1, -1])
        for shape in shapes
        for part in svgelements.Path(shape).as_subpaths()
    ]
    return [curve for curve in curves if curve]


def _style(text: str) -> str:
    """Return a style sheet of an SVG file without its comments.

    A long style sheet is replaced by an empty one, because the time to read it grows with the square of its length.
    """
    plain = re.sub(r"/\*.*?(?:\*/|\Z)", "", text, flags=re.DOTALL)
    return plain if len(plain) <= LONGEST_STYLE else ""


def _check_entities(text: str) -> None:
    """Refuse an SVG file whose XML entities would expand to too much text.

    Raises:
        InputError: If entities refer to other entities, or entities are used too often.
    """
    entities = dict(re.findall(r"<!ENTITY\s+([^\s%]+)\s+[\"']([^\"']*)[\"']", text))
    if any("&" in value for value in entities.values()) or re.search(r"<!ENTITY\s+%", text):
        raise InputError("outline: must have entities that name no others")
    used = Counter(re.findall(r"&([^\s&;]+);", text)) if entities else Counter()
    if sum(len(value) * used[name] for name, value in entities.items()) > LARGEST_DRAWING:
        raise InputError(f"outline: must have entities that unpack to at most {LARGEST_DRAWING / MIB:.0f} MiB")


def _check_unpacked(root: ElementTree.Element) -> None:
    """Refuse a drawing that has too many elements after each `use` element is replaced by the elements that it repeats.

    Raises:
        InputError: If the drawing then has too many elements.
    """
    named = {element.get("id"): element for element in root.iter() if element.get("id")}

    def parts(element: ElementTree.Element) -> Iterator[tuple[ElementTree.Element, int]]:
        yield from ((child, 1) for child in element)
        target = named.get((element.get("href") or element.get(XLINK) or "").removeprefix("#"))
        if target is not None and str(element.tag).rpartition("}")[2] == "use":
            yield target, 1

    def own(element: ElementTree.Element) -> int:
        return 1 + sum(len(NUMBER.findall(element.get(name, ""))) for name in ("d", "points"))

    check_unpacked(root, parts, own)


def _name(shape: Any) -> str:
    """Return the name that the author of a drawing gave a shape; empty if a program gave the name."""
    own = shape.values.get("attributes", {})
    label = own.get(f"{INKSCAPE}label") or own.get("data-name") or own.get("id") or ""
    label = re.sub(r"_x([0-9A-Fa-f]{2,4})_", lambda code: chr(int(code[1], 16)), label)  # Illustrator's codes
    return "" if GIVEN_BY_PROGRAM.fullmatch(label) else label


def _viewbox(root: ElementTree.Element) -> tuple[float, float] | None:
    """Return the width and height of a drawing's visible area, in its units; None if the file states no area."""
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
    if re.search(r'<svg[^>]*\sdata-name="Layer', text):  # Illustrator's export for screens, which has no comment
        return _Program("Illustrator SVG", 72)
    return _Program("SVG")


def _unit(root: ElementTree.Element, text: str, path: Path) -> Unit:
    """Return the unit of a drawing's coordinates, with its length."""
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
    seen = _viewbox(root)
    if seen is None:
        return Unit(pixel, pixels, f"{stated}, no viewBox")
    return Unit(_per_unit(root, given, seen, pixel, path), name, stated)


def _per_unit(
    root: ElementTree.Element, given: dict[str, re.Match[str]], seen: tuple[float, float], pixel: float, path: Path
) -> float:
    """Return the length of one unit of a drawing [m].

    The visible extent `seen`, in units of the drawing, is fitted into the width and height that the file states.
    """
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
    """Return points along an SVG subpath, shape (k, 2)."""
    import svgelements

    at = np.arange(1, STEPS + 1) / STEPS
    points = [np.empty((0, 2))]
    for segment in svgelements.Path(part):
        if isinstance(segment, (svgelements.Move, svgelements.Line, svgelements.Close)):
            points.append(np.array([[segment.end.x, segment.end.y]] if segment.end is not None else np.empty((0, 2))))
        else:
            points.append(np.asarray(segment.npoint(at), dtype=float))
    return np.concatenate(points)
