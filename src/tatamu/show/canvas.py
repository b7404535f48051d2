"""Paints the shapes of a drawing as pixels, with the library Pillow."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from tatamu.base.curves import arc_lengths
from tatamu.show.image import encoded
from tatamu.show.palette import day
from tatamu.show.projection import Projection
from tatamu.show.shapes import FONT, Box, Dot, Label, Polyline, Segments, Shape

FINER = 3
"""Factor by which shapes are painted larger before the image is reduced, which makes lines smooth."""


def paint(projection: Projection, shapes: Sequence[Shape], background: str) -> bytes:
    """Return the shapes, each painted over the ones before, in the colours of light mode as a PNG file."""
    ground = day(background)
    image = Image.new("RGB", (projection.wide * FINER, projection.tall * FINER), ground)
    canvas = ImageDraw.Draw(image)
    for shape in shapes:
        _paint(canvas, projection, shape, ground)
    return encoded(image.reduce(FINER))


def _paint(canvas: Any, projection: Projection, shape: Shape, ground: str) -> None:
    if isinstance(shape, Polyline):
        path = projection.pixels(shape.points) * FINER
        if shape.fill:
            canvas.polygon([tuple(p) for p in path], fill=day(shape.fill))
        for piece in _dashes(path, shape.dash * FINER) if shape.width else ():
            canvas.line([tuple(p) for p in piece], day(shape.colour), round(shape.width * FINER), joint="curve")
    elif isinstance(shape, Segments):
        for ends in projection.pixels(shape.ends.reshape(-1, 2)).reshape(-1, 4) * FINER:
            canvas.line(tuple(ends), day(shape.colour), round(shape.width * FINER))
    elif isinstance(shape, Dot):
        x, y = projection.pixels(shape.place[None])[0] * FINER
        radius = shape.radius * FINER
        canvas.ellipse((x - radius, y - radius, x + radius, y + radius), fill=day(shape.colour))
    elif isinstance(shape, Box):
        corner, size = projection.box(shape)
        outline = day(shape.edge) if shape.edge else None
        canvas.rectangle((*(corner * FINER), *((corner + size) * FINER)), day(shape.fill), outline, FINER)
    elif isinstance(shape, Label):
        (x, y), anchor = projection.beside(shape)
        look = {"anchor": anchor + "m", "stroke_width": 4, "stroke_fill": ground}
        font = ImageFont.load_default(FONT * FINER)
        canvas.text((x * FINER, y * FINER), shape.text, day(shape.colour), font, **look)
    else:
        raise TypeError("a picture inside a drawing goes into an SVG only")


def _dashes(path: np.ndarray, length: float) -> Iterable[np.ndarray]:
    """Cut a polyline into dashes and gaps of a given length; with 0, it stays whole."""
    if not length:
        return [path]
    arc = arc_lengths(path)
    starts = np.arange(0.0, arc[-1], 2 * length)
    return [_part(path, arc, start, min(start + length, arc[-1])) for start in starts]


def _part(path: np.ndarray, arc: np.ndarray, start: float, end: float) -> np.ndarray:
    at = np.concatenate([[start], arc[(arc > start) & (arc < end)], [end]])
    return np.column_stack([np.interp(at, arc, path[:, k]) for k in (0, 1)])
