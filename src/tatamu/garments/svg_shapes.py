"""Finds the shapes that an SVG drawing shows: templates, hidden parts and what clip paths cut away are left out.

Coordinates are those of the outermost `viewBox`, with y up. Attributes, style sheets and inheritance follow SVG 2. A
feature that changes the outline and is not supported is refused by its name.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
import shapely

from tatamu.base.errors import InputError
from tatamu.garments.drawing import SELF_SHOWN, DrawnCurve, check_parts, polyline

CONTAINERS = ("g", "a", "svg", "switch", "use")
"""Elements whose children are drawn. Those of others, such as `symbol` and `mask`, are templates or no shapes."""
GEOMETRY = {
    "rect": ("x", "y", "width", "height", "rx", "ry"),
    "circle": ("cx", "cy", "r"),
    "ellipse": ("cx", "cy", "rx", "ry"),
    "line": ("x1", "y1", "x2", "y2"),
    **dict.fromkeys(("polyline", "polygon", "path"), ()),
}
"""Lengths of each kind of shape."""
SIZES = {"rect": ("width", "height"), "circle": ("r",), "ellipse": ("rx", "ry")}
"""Lengths of each kind of shape without which nothing is drawn."""
INCH = 0.0254


class LengthUnit(NamedTuple):
    """A unit of lengths (CSS Values and Units, section 6.2)."""

    pixels: float
    metres: float = 0.0
    """0 for px, which is not the same in all programs."""
    name: str = ""


UNITS = {
    "": LengthUnit(1.0),
    "px": LengthUnit(1.0),
    "mm": LengthUnit(96 / 25.4, 1e-3, "millimetres"),
    "cm": LengthUnit(96 / 2.54, 1e-2, "centimetres"),
    "q": LengthUnit(96 / 101.6, 0.25e-3, "quarter millimetres"),
    "in": LengthUnit(96.0, INCH, "inches"),
    "pt": LengthUnit(96 / 72, INCH / 72.0, "points of 1/72 inch"),
    "pc": LengthUnit(16.0, INCH / 6.0, "picas of 1/6 inch"),
}
LENGTH = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*([a-z%]*)\s*", re.IGNORECASE)
Sheet = tuple[tuple[tuple[int, int, int], str, frozenset[str], Mapping[str, str]], ...]
"""Rules of a style sheet: specificity, tag, classes and id of the selector, and the declarations."""


class Page(NamedTuple):
    """The visible area of a drawing, or of a part with a `viewBox` of its own."""

    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True)
class Shape:
    """The curves of one shape that is drawn."""

    elements: tuple[Element, ...]
    """The shape's element, and each template and reference through which it is drawn, from the inside out."""
    curves: tuple[DrawnCurve, ...]
    fill: str
    rule: str
    """Rule for the inside of curves that lie in one another: nonzero or evenodd."""


@dataclass(frozen=True)
class _Place:
    """Where, and with which inherited style, an element is drawn."""

    matrix: np.ndarray
    """Matrix from the element's coordinates to those of the drawing, shape (2, 3)."""
    page: Page | None
    style: Mapping[str, str] = field(default_factory=dict)
    within: tuple[Element, ...] = ()
    """The elements that contain this one, or refer to it."""

    def moved(self, linear: Any, offset: Any, page: Page | None = None) -> _Place:
        """Return the place of inner coordinates, by a matrix (2, 2) and an offset to this place's, maybe on a page."""
        turn, shift = self.matrix[:, :2], self.matrix[:, 2]
        return replace(self, matrix=np.column_stack([turn @ linear, turn @ offset + shift]), page=page or self.page)

    def drawn(self, points: np.ndarray) -> np.ndarray:
        """Return points in the coordinates of the drawing, shape (k, 2) each."""
        return np.asarray(points @ self.matrix[:, :2].T + self.matrix[:, 2])


def visible_shapes(root: Element, page: Page | None) -> tuple[list[Shape], list[str]]:
    """Return the shapes that a drawing shows, and notes on what was left out.

    Raises:
        InputError: If a feature is not supported that changes the outline, or the drawing has too many parts.
    """
    drawing = _Drawing(root)
    shapes = drawing.children(root, _Place(np.eye(2, 3) * [[1], [-1]], page))
    kept = [shape for shape in shapes if page is None or not _is_background(shape, page)]
    notes = [f"the drawing is cut by its {' and '.join(sorted(drawing.cut))}"] if drawing.cut else []
    if len(kept) < len(shapes) and any(curve.closed for shape in kept for curve in shape.curves):
        return kept, [*notes, "left out: a white rectangle of the page's size"]
    return shapes, notes


class _Drawing:
    def __init__(self, root: Element) -> None:
        self.named = {element.get("id"): element for element in reversed([*root.iter()]) if element.get("id")}
        self.sheet = _style_sheet("\n".join(e.text or "" for e in root.iter() if _tag(e) == "style"))
        self.elements = self.numbers = 0
        self.cut: set[str] = set()

    def children(self, element: Element, place: _Place) -> list[Shape]:
        """Return the shapes of an element's children, as far as they are visible."""
        inner = replace(place, within=(*place.within, element))
        check_parts(0, len(place.within))
        children = list(element)
        if _tag(element) == "switch":
            children = [each for each in children if _tag(each) in (*CONTAINERS, *GEOMETRY)][:1]
        return [shape for child in children for shape in self.shapes(child, inner)]

    def shapes(self, element: Element, place: _Place) -> list[Shape]:
        """Return the shapes of an element, as far as they are visible."""
        tag = _tag(element)
        if tag not in CONTAINERS and tag not in GEOMETRY:
            return []
        numbers = (re.findall(r"[0-9.]+(?:[eE][+-]?[0-9]+)?", element.get(name, "")) for name in ("d", "points"))
        self.elements += 1
        self.numbers += sum(map(len, numbers))
        check_parts(self.elements, 0, 50_000)  # each takes a tenth of a millisecond
        check_parts(self.numbers, 0)
        style = self._style(element, place.style)
        clips = any(_tag(each) == "clipPath" for each in place.within)  # opacity means nothing there
        faded = not clips and re.fullmatch(r"0*\.?0+%?|0+\.", style.get("opacity", "1").strip())
        if style.get("display") == "none" or faded:
            return []
        inherited: dict[str, str] = {name: style[name] for name in ("visibility", "fill", "clip-rule") if name in style}
        here = _transformed(replace(place, style=inherited), style)
        if tag in CONTAINERS:
            shown = self._inner(element, here, style)
        else:
            curves = () if style.get("visibility") in ("hidden", "collapse") else _curves(tag, style, here)
            drawn = Shape((element,), curves, style.get("fill", "black"), style.get("clip-rule", "nonzero"))
            shown = [drawn] if curves else []
        for name in ("clip-path", "mask"):
            if style.get(name, "none") != "none":
                shown = self._within(name, style[name], shown, here)
        return shown

    def _inner(self, element: Element, place: _Place, style: Mapping[str, str]) -> list[Shape]:
        """Return the shapes in a container: its children, or those of the element to which it refers."""
        if _tag(element) == "svg":
            return self._framed(element, place, style)
        if _tag(element) != "use":
            return self.children(element, place)
        reference = element.get("href") or element.get("{http://www.w3.org/1999/xlink}href") or ""
        if not reference.startswith("#"):
            raise InputError(
                f"outline: must not use parts of another file, given {reference[:60]}; copy this part into the drawing"
            )
        target = self.named.get(reference[1:])
        if target is None:
            return []
        if target in place.within or target is element:
            raise InputError(SELF_SHOWN)
        moved = place.moved(np.eye(2), [_length("x", style, place), _length("y", style, place)])
        moved = replace(moved, within=(*place.within, element))
        given = {side: style[side] for side in ("width", "height") if side in style}
        if _tag(target) in ("symbol", "svg"):
            origin = {"x": "0", "y": "0"} if _tag(target) == "symbol" else {}
            shapes = self._framed(target, moved, {**self._style(target, {}), **origin, **given})
        else:
            shapes = self.shapes(target, moved)
        return [replace(shape, elements=(*shape.elements, target, element)) for shape in shapes]

    def _framed(self, element: Element, place: _Place, style: Mapping[str, str]) -> list[Shape]:
        """Return the shapes of an element with a viewport of its own, cut at its border."""
        x, y = _length("x", style, place), _length("y", style, place)
        width = _length("width", {"width": "100%", **style}, place)
        height = _length("height", {"height": "100%", **style}, place)
        if not (width > 0.0 and height > 0.0):
            return []
        framed = place.moved(np.eye(2), [x, y], Page(0.0, 0.0, width, height))
        if box := view_box(element):
            scale, offset = _fitted(box, width, height, element.get("preserveAspectRatio", ""))
            framed = framed.moved(np.diag(scale), offset, box)
        shapes = self.children(element, framed)
        if style.get("overflow") in ("visible", "auto"):
            return shapes
        border = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
        return self._cut(shapes, shapely.Polygon(place.drawn(border)), _tag(element))

    def _within(self, name: str, given: str, shapes: list[Shape], place: _Place) -> list[Shape]:
        """Return shapes as far as a clip path or a mask shows them."""
        found = re.fullmatch(r"""\s*url\(\s*["']?#([^"')]+)["']?\s*\)\s*""", given)
        if not found:
            raise InputError(
                f"outline: {name} must have the form url(#name), given {given[:60]}; apply the {name} in the "
                "drawing program"
            )
        element = self.named.get(found[1])
        if element is None or not shapes:  # without its target, a reference has no effect
            return shapes
        if element in place.within:
            raise InputError(SELF_SHOWN)
        style = self._style(element, {})
        if style.get("clipPathUnits" if name == "clip-path" else "maskContentUnits") == "objectBoundingBox":
            place = _boxed(place, shapes)
        shown = self.children(element, _transformed(replace(place, style={}), style))
        opaque = style.get("mask-type") == "alpha"
        if name == "mask" and not opaque and not all(_is_white(shape.fill) for shape in shown):
            raise InputError("outline: masks must be plain white; apply the mask to the outline in the drawing program")
        region = shapely.union_all([_inside(shape) for shape in shown])
        if style.get("clip-path", "none") != "none":
            inner = replace(place, within=(*place.within, element))
            shapes = self._within("clip-path", style["clip-path"], shapes, inner)
        return self._cut(shapes, region, name)

    def _cut(self, shapes: list[Shape], region: Any, name: str) -> list[Shape]:
        """Return shapes as far as they lie within a region."""
        extent = max(1e-9, *np.abs(region.bounds)) if not region.is_empty else 1.0
        wider = region.buffer(1e-6 * extent, join_style="mitre")
        shapely.prepare(wider)
        kept = []
        for shape in shapes:
            curves = tuple(part for curve in shape.curves for part in _cut_curve(curve, region, wider))
            if [*map(id, curves)] != [*map(id, shape.curves)]:
                self.cut.add(name)
            if curves:
                kept.append(replace(shape, curves=curves))
        return kept

    def _style(self, element: Element, inherited: Mapping[str, str]) -> dict[str, str]:
        """Return the attributes of an element, with what style sheets and its own style change."""
        own = {name: value for name, value in element.attrib.items() if value.strip() != "inherit"}
        marks = frozenset([*(f".{name}" for name in element.get("class", "").split()), f"#{element.get('id', '')}"])
        for _, tag, wanted, declared in self.sheet:
            if tag in ("", "*", _tag(element)) and wanted <= marks:
                own.update(declared)
        return {**inherited, **own, **_declarations(element.get("style", ""))}


def view_box(element: Element) -> Page | None:
    """Return the area that the attribute `viewBox` states, if any."""
    numbers = [float(number) for number in re.split(r"[\s,]+", element.get("viewBox", "").strip()) if number]
    return Page(*numbers) if len(numbers) == 4 and numbers[2] > 0.0 and numbers[3] > 0.0 else None


def _tag(element: Element) -> str:
    return str(element.tag).rpartition("}")[2]


def _declarations(text: str) -> dict[str, str]:
    pairs = (part.split(":", 1) for part in text.split(";") if ":" in part)
    return {name.strip().lower(): value.replace("!important", "").strip() for name, value in pairs}


def _style_sheet(text: str) -> Sheet:
    """Return the rules of a style sheet with simple selectors, in the order in which they apply."""
    most = 100_000  # as the time to read them grows with the square
    if len(text) > most:
        raise InputError(f"outline: each style sheet must have at most {most} characters, given {len(text)}")
    plain = re.sub(r"/\*.*?(?:\*/|\Z)", "", text, flags=re.DOTALL)
    plain = re.sub(r"@[^{};]*(?:;|\{(?:[^{}]|\{[^{}]*\})*\})", "", plain)
    rules = []
    for selectors, declared in re.findall(r"([^{}]+)\{([^{}]*)\}", plain):
        for each in selectors.split(","):
            if found := re.fullmatch(r"([\w-]*|\*)((?:[.#][\w-]+)*)", each.strip()):
                marks = re.findall(r"[.#][\w-]+", found[2])
                rank = (sum(mark[0] == "#" for mark in marks), sum(mark[0] == "." for mark in marks), len(found[1]) > 1)
                rules.append((rank, found[1], frozenset(marks), _declarations(declared)))
    return tuple(sorted(rules, key=lambda rule: rule[0]))


def _transformed(place: _Place, style: Mapping[str, str]) -> _Place:
    """Return the place with the transform of an element."""
    import svgelements

    text = style.get("transform", style.get("patternTransform", "none"))
    if text.strip() in ("", "none"):
        return place
    if style.get("transform-origin", "0").split() not in (["0"], ["0", "0"], ["0px", "0px"], ["top", "left"]):
        raise InputError("outline: must not have a transform-origin; apply the transforms in the drawing program")
    matrix = svgelements.Matrix(text)
    if place.page is not None:
        matrix.render(ppi=96, width=place.page.width, height=place.page.height)
    linear = np.array([[matrix.a, matrix.c], [matrix.b, matrix.d]], dtype=float)
    return place.moved(linear, np.array([matrix.e, matrix.f], dtype=float))


def _boxed(place: _Place, shapes: list[Shape]) -> _Place:
    """Return the place whose unit square is the box around shapes, as for the unit `objectBoundingBox`."""
    points = np.concatenate([curve.points for shape in shapes for curve in shape.curves])
    inverse = np.linalg.inv(np.vstack([place.matrix, [0.0, 0.0, 1.0]]))[:2]
    local = replace(place, matrix=inverse).drawn(points)
    return place.moved(np.diag(np.ptp(local, axis=0)), local.min(axis=0))


def _length(name: str, style: Mapping[str, str], place: _Place) -> float:
    """Return a length in the element's own coordinates; 0 if it is not given."""
    text = style.get(name, "0")
    found = LENGTH.fullmatch(text)
    if found is None or (found[2].lower() not in UNITS and found[2] != "%"):
        raise InputError(
            f"outline: {name} must be a number, a percentage, or a length in mm, cm, in, pt or px, given {text[:40]!r}"
        )
    if found[2] != "%":
        return float(found[1]) * UNITS[found[2].lower()].pixels
    if place.page is None:
        raise InputError(
            f"outline: {name} must be a length if the page has no size, given {text[:40]}; give the drawing a viewBox"
        )
    width, height = place.page.width, place.page.height
    whole = float(np.hypot(width, height) / np.sqrt(2.0))  # a percentage of `r` is one of the root mean square
    if name != "r":
        whole = width if name in ("x", "width", "cx", "x1", "x2", "rx") else height
    return float(found[1]) / 100.0 * whole


def _fitted(box: Page, width: float, height: float, fitting: str) -> tuple[np.ndarray, np.ndarray]:
    """Return scales and offset of a `viewBox` in a viewport, as its `preserveAspectRatio` says."""
    words = fitting.split() or ["xMidYMid"]
    scale = np.array([width / box.width, height / box.height])
    if words[0] != "none":
        scale[:] = scale.max() if "slice" in words else scale.min()
    free = np.array([width, height]) - scale * [box.width, box.height]
    share = [{"Min": 0.0, "Max": 1.0}.get(part, 0.5) for part in (words[0][1:4], words[0][5:8])]
    return scale, free * (share if words[0] != "none" else 0.0) - scale * [box.x, box.y]


def _curves(tag: str, style: Mapping[str, str], place: _Place) -> tuple[DrawnCurve, ...]:
    """Return the curves of a shape in the drawing's coordinates."""
    import svgelements

    lengths = {name: _length(name, style, place) for name in GEOMETRY[tag] if style.get(name, "auto") != "auto"}
    if not all(lengths.get(name, 0.0) > 0.0 for name in SIZES.get(tag, ())):
        return ()
    if tag == "path":
        text = style.get("d", "")
        try:
            made = svgelements.Path(text)
        except Exception:
            raise InputError(f"outline: must have valid path data, given {text[:40]!r}") from None
    else:
        shape = getattr(svgelements, "SimpleLine" if tag == "line" else tag.capitalize())
        made = shape({**lengths, "points": style.get("points", "")})
    parts = svgelements.Path(made).as_subpaths()
    curves = [polyline("", place.drawn(_flattened(part))) for part in parts]
    return tuple(curve for curve in curves if curve)


def _flattened(part: Any) -> np.ndarray:
    """Return points along an SVG subpath, shape (k, 2)."""
    import svgelements

    at = np.arange(1, 33) / 32  # of each curved segment
    points = [np.empty((0, 2))]
    for segment in svgelements.Path(part):
        if isinstance(segment, (svgelements.Move, svgelements.Line, svgelements.Close)):
            points.append(np.array([[segment.end.x, segment.end.y]] if segment.end is not None else np.empty((0, 2))))
        else:
            points.append(np.asarray(segment.npoint(at), dtype=float))
    return np.concatenate(points)


def _inside(shape: Shape) -> Any:
    """Return the region inside a shape, by its rule for curves that lie in one another."""
    parts = [shapely.Polygon(curve.points) for curve in shape.curves if len(curve.points) > 2]
    parts = sorted((part if part.is_valid else part.buffer(0.0) for part in parts), key=lambda part: -part.area)
    region: Any = shapely.Polygon()
    for part in parts:
        if shape.rule == "evenodd":
            region = region.symmetric_difference(part)
        else:
            hole = _turn(part) != _turn(parts[0])
            region = region.difference(part) if hole else region.union(part)
    return region


def _turn(part: Any) -> bool:
    return isinstance(part, shapely.Polygon) and bool(part.exterior.is_ccw)


def _cut_curve(curve: DrawnCurve, region: Any, wider: Any) -> list[DrawnCurve]:
    """Return the parts of a curve that lie within a region; the curve itself if it does as a whole."""
    line, loop = shapely.LineString(curve.points), shapely.Polygon(curve.points if curve.closed else ())
    if wider.covers(line) and (loop.is_empty or wider.covers(loop.buffer(0.0))):
        return [curve]
    if curve.closed:
        if not loop.is_valid:
            raise InputError(
                "outline: a curve that crosses itself must not be clipped or masked; cut the curve itself in the "
                "drawing program"
            )
        found = shapely.get_parts(loop.intersection(region))
        parts = [part for part in found if isinstance(part, shapely.Polygon) and not part.is_empty]
        rings = [ring.coords for part in parts for ring in (part.exterior, *part.interiors)]
    else:
        found = shapely.get_parts(shapely.line_merge(line.intersection(region)))
        rings = [part.coords for part in found if isinstance(part, shapely.LineString) and not part.is_empty]
    made = [polyline(curve.name, np.array(ring)) for ring in rings]
    return [each for each in made if each]


def _is_white(fill: str) -> bool:
    import svgelements

    try:
        colour = svgelements.Color(fill)
    except ValueError:
        return False
    return colour.value is not None and min(colour.red, colour.green, colour.blue) >= 240


def _is_background(shape: Shape, page: Page) -> bool:
    """Return whether a shape is a white rectangle that covers the page."""
    if len(shape.curves) != 1 or not shape.curves[0].closed or not _is_white(shape.fill):
        return False
    points = shape.curves[0].points * [1, -1]
    area = shapely.Polygon(points).area
    low, high = points.min(axis=0), points.max(axis=0)
    start, size = np.array(page).reshape(2, 2)
    room = 0.01  # by which it may be smaller on each side
    covers = (low <= start + room * size).all() and (high >= start + (1.0 - room) * size).all()
    return bool(covers and abs(area - np.prod(high - low)) < 1e-6 * area)
