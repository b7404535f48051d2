"""A drawing in lines, dots and words on the table, as SVG and as PNG from the same shapes."""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import dataclass, field
from html import escape

import numpy as np

INK = "#20242c"
FONT = 13
"""Height of the letters [pixels]."""
LETTER = 0.55
"""Mean width of a letter over the height."""
FINER = 3
"""The PNG is drawn this much larger and averaged, for smooth lines."""


@dataclass(frozen=True)
class Line:
    """A polyline, or a filled region."""

    points: np.ndarray
    """Places on the table [m], shape (k, 2)."""
    colour: str = INK
    width: float = 1.0
    """[pixels]; 0: only filled."""
    dash: float = 0.0
    """Length of dashes and gaps [pixels]; 0: drawn through."""
    fill: str | None = None


@dataclass(frozen=True)
class Segments:
    """Many short lines of one kind, such as the edges of a mesh."""

    ends: np.ndarray
    """Places on the table [m], shape (k, 2, 2)."""
    colour: str
    width: float = 0.5
    """[pixels]."""


@dataclass(frozen=True)
class Dot:
    """A filled circle."""

    place: np.ndarray
    colour: str
    radius: float = 4.0
    """[pixels]."""


@dataclass(frozen=True)
class Label:
    """A word beside a place, on the side of it that `towards` says."""

    place: np.ndarray
    text: str
    towards: np.ndarray
    """Direction on the table, shape (2,); zero: centred on the place."""
    colour: str = INK


Shape = Line | Segments | Dot | Label


@dataclass(frozen=True)
class Diagram:
    """Shapes on a part of the table, seen from above: x up, y to the left."""

    shapes: tuple[Shape, ...]
    low: np.ndarray
    """Smallest x, y [m], shape (2,)."""
    high: np.ndarray
    """Largest x, y [m], shape (2,)."""
    tall: int = 760
    """Height of the drawing [pixels]."""
    words: str = field(default="", compare=False)
    """What the drawing shows, for those who cannot see it."""

    @property
    def scale(self) -> float:
        """Pixels per metre."""
        return self.tall / float(self.high[0] - self.low[0])

    @property
    def wide(self) -> int:
        """Width of the drawing [pixels]."""
        return round(self.scale * float(self.high[1] - self.low[1]))

    def pixels(self, points: np.ndarray) -> np.ndarray:
        """Places on the table as pixels, x to the right and y down, shape (k, 2)."""
        return np.column_stack([self.high[1] - points[:, 1], self.high[0] - points[:, 0]]) * self.scale

    def svg(self) -> str:
        """The drawing as an SVG element."""
        body = "".join(self._element(shape) for shape in self.shapes)
        return (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.wide} {self.tall}" role="img" '
            f'aria-label="{escape(self.words)}" font-family="sans-serif" font-size="{FONT}">'
            f'<rect width="100%" height="100%" fill="#fff"/>{body}</svg>'
        )

    def _element(self, shape: Shape) -> str:
        if isinstance(shape, Line):
            path = " ".join(f"{x:.1f},{y:.1f}" for x, y in self.pixels(shape.points))
            stroke = f'stroke="{shape.colour}" stroke-width="{shape.width:g}"' if shape.width else 'stroke="none"'
            dash = f' stroke-dasharray="{shape.dash:g}"' if shape.dash else ""
            return f'<polyline points="{path}" fill="{shape.fill or "none"}" {stroke}{dash} stroke-linejoin="round"/>'
        if isinstance(shape, Segments):
            ends = self.pixels(shape.ends.reshape(-1, 2)).reshape(-1, 4)
            path = "".join(f"M{a:.1f} {b:.1f}L{c:.1f} {d:.1f}" for a, b, c, d in ends)
            return f'<path d="{path}" fill="none" stroke="{shape.colour}" stroke-width="{shape.width:g}"/>'
        x, y = self.pixels(shape.place[None])[0]
        if isinstance(shape, Dot):
            return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{shape.radius:g}" fill="{shape.colour}"/>'
        (x, y), anchor = self._beside(shape)
        place = {"l": "start", "m": "middle", "r": "end"}[anchor]
        return (
            f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{place}" dominant-baseline="central" fill="{shape.colour}" '
            f'stroke="#fff" stroke-width="3" paint-order="stroke">{escape(shape.text)}</text>'
        )

    def _beside(self, label: Label) -> tuple[np.ndarray, str]:
        """Where the word goes [pixels], and whether its left end, middle or right end is there; within the drawing."""
        right, down = -label.towards[1], -label.towards[0]
        at = self.pixels(label.place[None])[0] + np.array([right, down]) * 0.9 * FONT
        anchor = "l" if right > 0.4 else "r" if right < -0.4 else "m"
        long = LETTER * FONT * len(label.text)
        before = {"l": 0.0, "m": 0.5, "r": 1.0}[anchor] * long
        at[0] = np.clip(at[0], before, max(self.wide - long + before, before))
        return at, anchor

    def png(self) -> bytes:
        """The drawing as the bytes of a PNG file."""
        from PIL import Image, ImageDraw, ImageFont

        image = Image.new("RGB", (self.wide * FINER, self.tall * FINER), "#fff")
        canvas = ImageDraw.Draw(image)
        font = ImageFont.load_default(FONT * FINER)
        for shape in self.shapes:
            if isinstance(shape, Line):
                path = self.pixels(shape.points) * FINER
                if shape.fill:
                    canvas.polygon([tuple(p) for p in path], fill=shape.fill)
                for piece in _dashes(path, shape.dash * FINER) if shape.width else ():
                    canvas.line([tuple(p) for p in piece], shape.colour, round(shape.width * FINER), joint="curve")
            elif isinstance(shape, Segments):
                for ends in self.pixels(shape.ends.reshape(-1, 2)).reshape(-1, 4) * FINER:
                    canvas.line(tuple(ends), shape.colour, round(shape.width * FINER))
            elif isinstance(shape, Dot):
                x, y = self.pixels(shape.place[None])[0] * FINER
                r = shape.radius * FINER
                canvas.ellipse((x - r, y - r, x + r, y + r), fill=shape.colour)
            else:
                (x, y), anchor = self._beside(shape)
                canvas.text(
                    (x * FINER, y * FINER),
                    shape.text,
                    shape.colour,
                    font,
                    anchor + "m",
                    stroke_width=4,
                    stroke_fill="#fff",
                )
        buffer = io.BytesIO()
        image.reduce(FINER).save(buffer, "PNG", optimize=True)
        return buffer.getvalue()


def _dashes(path: np.ndarray, length: float) -> Iterable[np.ndarray]:
    """A polyline cut into dashes of a length, with gaps as long; whole if the length is zero."""
    if not length:
        return [path]
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    starts = np.arange(0.0, arc[-1], 2 * length)
    return [_part(path, arc, start, min(start + length, arc[-1])) for start in starts]


def _part(path: np.ndarray, arc: np.ndarray, start: float, end: float) -> np.ndarray:
    at = np.concatenate([[start], arc[(arc > start) & (arc < end)], [end]])
    return np.column_stack([np.interp(at, arc, path[:, k]) for k in (0, 1)])
