"""Makes drawings to scale from lines, dots, words and dimensions in metres, as SVG or as PNG.

Colours are names of `palette` or "#rrggbb". An SVG has those of light and of dark mode.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any

import numpy as np

from tatamu.show.palette import COLOURS, day
from tatamu.show.projection import FROM_ABOVE, Projection
from tatamu.show.shapes import FONT, Box, Dot, Label, Picture, Polyline, Segments, Shape

__all__ = ["FROM_ABOVE", "Drawing"]

HEAD = 7.0
"""Length of an arrow's head [pixels]."""
CAPTION = 22
"""Height of one line of text in the caption below a drawing [pixels]."""


@dataclass
class Drawing(Projection):
    """Shapes in a rectangle of a plane, which are drawn to scale."""

    shapes: list[Shape] = field(default_factory=list)
    caption: Sequence[str] = ()
    """Lines of text below the drawing."""
    background: str | None = "card"
    words: str = ""
    """Description of the drawing for readers who cannot see it."""

    @classmethod
    def around(cls, points: np.ndarray, width: float, height: float, *, margin: float = 34.0) -> Drawing:
        """Return an empty drawing of width x height [pixels] and a margin, into which points [m], shape (n, 2), fit."""
        low, high = points.min(axis=0), points.max(axis=0)
        scale = float(min(np.array([width, height]) / np.maximum(high - low, 1e-9)))
        return cls(low, high, scale, margin=margin)

    def add(self, *shapes: Shape) -> None:
        """Add shapes, which are drawn over the shapes added before."""
        self.shapes.extend(shapes)

    def line(self, points: Any, colour: str = "ink", width: float = 1.5, **more: Any) -> None:
        """Draw a line through points [m], shape (k, 2). The other arguments are fields of `Polyline`."""
        self.add(Polyline(np.asarray(points, dtype=float), colour, width, **more))

    def arrow(
        self, points: Any, colour: str, width: float = 1.5, *, head: float | None = None, both: bool = False
    ) -> None:
        """Draw a line with an arrow's head of a length [m] at its end or at both; None for a head of `HEAD` pixels."""
        path = np.asarray(points, dtype=float)
        length = HEAD / self.scale if head is None else head
        self.line(path, colour, width)
        for end, before in ((path[-1], path[-2]), (path[0], path[1])) if both else ((path[-1], path[-2]),):
            back = length * (before - end) / max(float(np.linalg.norm(before - end)), 1e-12)
            across = 0.5 * np.array([-back[1], back[0]])
            self.line([end + back + across, end, end + back - across], colour, width)

    def label(self, place: Any, text: str, colour: str = "ink", towards: Any = (0.0, 0.0)) -> None:
        """Write a word at a position: centred on the position or, if `towards` is not zero, next to the position."""
        self.add(Label(np.asarray(place, dtype=float), text, np.asarray(towards, dtype=float), colour))

    def dimension(self, start: Any, end: Any, name: str, colour: str = "reading") -> None:
        """Draw a line with arrows at both ends, with a name above it or to its right."""
        ends = np.array([start, end], dtype=float)
        self.arrow(ends, colour, both=True)
        right, up = self.axes @ (ends[1] - ends[0])
        across = np.array([-up, right]) / max(float(np.hypot(right, up)), 1e-12)
        if across @ [0.5, 1.0] < 0.0:
            across = -across
        if name:
            self.label(ends.mean(axis=0), name, colour, self.axes.T @ across)

    def ruler(self, right_end: Any, colour: str = "muted") -> None:
        """Draw a scale bar of ten centimetres, with its length written above; `right_end` is its right end [m]."""
        end = np.asarray(right_end, dtype=float)
        left = self.axes.T @ np.array([-0.1, 0.0])
        up = self.axes.T @ np.array([0.0, 1.0])
        tick = 4.0 / self.scale * up
        self.line([end + left + tick, end + left, end, end + tick], colour)
        self.label(end + 0.5 * left, "10 cm", colour, up)

    def svg(self) -> str:
        """Return the drawing as an SVG element."""
        total = self.tall + (CAPTION * len(self.caption) + 16 if self.caption else 0)
        body = "".join(self._element(shape) for shape in self.shapes)
        if self.caption:  # the inner element cuts off everything outside the drawing
            body = f'<svg width="{self.wide}" height="{self.tall}">{body}</svg>'
        lines = "".join(
            f'<text x="12" y="{self.tall + CAPTION * (k + 1)}" {_look("muted" if k else "ink")}>{escape(text)}</text>'
            for k, text in enumerate(self.caption)
        )
        ground = f'<rect width="100%" height="100%" {_look(self.background)}/>' if self.background else ""
        inside = f"{ground}{body}{lines}"
        label = f' role="img" aria-label="{escape(self.words)}"' if self.words else ""
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.wide} {total}" width="{self.wide}" '
            f'height="{total}"{label} font-family="system-ui, sans-serif" font-size="{FONT}">'
            f"{_dark(inside)}{inside}</svg>"
        )

    def _repr_svg_(self) -> str:
        return self.svg()

    def _element(self, shape: Shape) -> str:
        if isinstance(shape, Polyline):
            path = " ".join(f"{x:.1f},{y:.1f}" for x, y in self.pixels(shape.points))
            dash = f' stroke-dasharray="{shape.dash:g}"' if shape.dash else ""
            look = _look(shape.fill, shape.colour, shape.width, shape.opacity)
            return f'<polyline points="{path}" {look}{dash} stroke-linejoin="round" stroke-linecap="round"/>'
        if isinstance(shape, Segments):
            ends = self.pixels(shape.ends.reshape(-1, 2)).reshape(-1, 4).round(1)
            path = "".join(f"M{a:g} {b:g}L{c:g} {d:g}" for a, b, c, d in ends)
            return f'<path d="{path}" {_look(None, shape.colour, shape.width, shape.opacity)}/>'
        if isinstance(shape, Box):
            (x, y), (width, height) = self.box(shape)
            place = f'x="{x:.1f}" y="{y:.1f}" width="{width:.1f}" height="{height:.1f}"'
            return f"<rect {place} {_look(shape.fill, shape.edge, 1.0)}/>"
        if isinstance(shape, Dot):
            x, y = self.pixels(shape.place[None])[0]
            return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{shape.radius:g}" {_look(shape.colour)}/>'
        if isinstance(shape, Picture):
            return f'<image href="{shape.source}" width="{self.wide}" height="{self.tall}"/>'
        (x, y), anchor = self.beside(shape)
        place = {"l": "start", "m": "middle", "r": "end"}[anchor]
        return (
            f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{place}" dominant-baseline="central" paint-order="stroke" '
            f"{_look(shape.colour, self.background, 3.0)}>{escape(shape.text)}</text>"
        )

    def png(self) -> bytes:
        """Return the drawing in light mode, without its caption, as the bytes of a PNG file."""
        from tatamu.show.canvas import paint  # Pillow is only needed for pixels

        return paint(self, self.shapes, self.background or "card")


def _look(fill: str | None, stroke: str | None = None, width: float = 0.0, opacity: float = 1.0) -> str:
    """Return the attributes that colour an SVG element in light mode, and the classes for dark mode."""
    line = stroke if width else None
    named = [f"{what}-{colour}" for what, colour in (("fill", fill), ("stroke", line)) if colour in COLOURS]
    parts = [f'fill="{day(fill) if fill else "none"}"']
    if line:
        parts.append(f'stroke="{day(line)}" stroke-width="{width:g}"')
    if opacity != 1.0:
        parts.append(f'opacity="{opacity:g}"')
    if named:
        parts.append(f'class="{" ".join(named)}"')
    return " ".join(parts)


def _dark(inside: str) -> str:
    """Return a style element that defines, for dark mode, all colours that the SVG elements `inside` use."""
    used = {name for names in re.findall(r' class="([^"]+)"', inside) for name in names.split()}
    rules = [
        f".{what}-{name}{{{what}:{night}}}"
        for name, (light, night) in COLOURS.items()
        for what in ("fill", "stroke")
        if light != night and f"{what}-{name}" in used
    ]
    return f"<style>@media (prefers-color-scheme:dark){{{''.join(rules)}}}</style>" if rules else ""
