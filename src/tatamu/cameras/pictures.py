"""Draws pictures for checking a result: curves over the photograph, and the table as seen from above."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from tatamu.base.errors import InputError
from tatamu.base.files import replacing
from tatamu.cameras import opencv
from tatamu.cameras.locate import Located
from tatamu.cameras.photograph import Photograph
from tatamu.cameras.reading import FoldReading
from tatamu.show.palette import day

FORMATS = {".png": "PNG", ".jpg": "JPEG", ".jpeg": "JPEG"}
MAX_PIXELS = 1600
"""Largest number of pixels along the longer side of a picture for checking."""
OUTLINE, FITTED = "#d02090", "#ffffff"
"""Colours of the found outline and of the fitted outline."""


class Overlay:
    """A photograph, or a part of a photograph, on which curves and dots are drawn."""

    def __init__(self, photograph: Photograph, around: np.ndarray | None = None) -> None:
        """Resize the photograph, cut to the pixels `around`, shape (n, 2), if they are given."""
        self._photograph = photograph
        image = Image.fromarray(photograph.pixels)
        if around is None:
            low, high = np.zeros(2), np.array(image.size, dtype=float)
        else:
            room = 0.25 * np.ptp(around, axis=0).max()
            low = np.maximum(around.min(axis=0) - room, 0.0).round()
            high = np.minimum(around.max(axis=0) + room, image.size).round()
        self._low = low
        longer = float((high - low).max())
        self._factor = min(1.0, MAX_PIXELS / longer) if around is None else 1000 / longer
        width, height = (int(side) for side in np.round((high - low) * self._factor))
        size = (width, height)
        self.image = image.crop((*low.astype(int), *high.astype(int))).resize(size, Image.Resampling.LANCZOS)
        self._canvas = ImageDraw.Draw(self.image)
        self._wide = max(2, round(max(size) / 600))
        self._font = ImageFont.load_default(max(11, round(max(size) / 75)))

    def curve(self, pixels: np.ndarray, colour: str, width: float = 1.0, closed: bool = False) -> None:
        points = np.vstack([pixels, pixels[:1]]) if closed else pixels
        self._canvas.line(self._at(points), day(colour), max(1, round(width * self._wide)), joint="curve")

    def dot(self, pixel: np.ndarray, colour: str, text: str = "", before: bool = False) -> None:
        ((x, y),) = self._at(pixel[None])
        radius = 2 * self._wide
        self._canvas.ellipse((x - radius, y - radius, x + radius, y + radius), day(colour), "#ffffff", 1)
        if text:
            look: dict[str, Any] = {"stroke_width": 2, "stroke_fill": "#202020", "font": self._font}
            place = (x - 2 * radius, y) if before else (x + 2 * radius, y)
            self._canvas.text(place, text, "#ffffff", anchor="rm" if before else "lm", **look)

    def frame(self, origin: np.ndarray, turn: np.ndarray, name: str) -> None:
        for axis, colour, letter in zip(turn.T, ("#d64a57", "#14968c"), "xy", strict=True):
            ends = self._photograph.in_pixels(np.array([origin, origin + 0.08 * axis]))
            self.curve(ends, colour, 2.0)
            self.dot(ends[1], colour, letter)
        self.dot(self._photograph.in_pixels(origin[None])[0], "#202020", name)

    def _at(self, pixels: np.ndarray) -> list[tuple[float, float]]:
        return [(float(x), float(y)) for x, y in (pixels + 0.5 - self._low) * self._factor]


def draw_located(located: Located) -> Image.Image:
    """Draw a located garment: the photograph with the found outline, the fitted outline, the corners and the frames."""
    overlay = Overlay(located.photograph)
    fit, photograph = located.fit, located.photograph
    overlay.curve(located.edge, OUTLINE, 2.0, closed=True)
    laid = photograph.in_pixels(fit.place(fit.shape.points), fit.shape.height)
    overlay.curve(laid, FITTED, 0.5, closed=True)
    for name, corner in fit.shape.corners.items():
        overlay.dot(photograph.in_pixels(fit.place(corner[None]), fit.shape.height)[0], OUTLINE, name)
    for paper in photograph.papers:
        overlay.curve(photograph.in_pixels(paper), FITTED, 0.5, closed=True)
    overlay.frame(np.zeros(2), np.eye(2), "board")
    overlay.frame(np.array([fit.pose.x, fit.pose.y]), fit.pose.rotation, "garment")
    return overlay.image


def draw_reading(reading: FoldReading, expected: np.ndarray | None = None) -> Image.Image:
    """Draw what was read after a fold: the outline, the corners of the hems, and where the moved corners should be.

    `expected` is another outline to draw [pixels], shape (n, 2).
    """
    overlay = Overlay(reading.photograph, reading.outline)
    overlay.curve(reading.outline, OUTLINE, 1.0, closed=True)
    if expected is not None:
        overlay.curve(expected, FITTED, 1.0, closed=True)
    for target in reading.targets.values():
        overlay.dot(target, "target")
    for name, corner in reading.corners.items():
        if name in reading.targets:
            overlay.curve(np.array([reading.targets[name], corner]), "target", 1.0)
        overlay.dot(corner, "left" if "left" in name else "right", name, before=name in reading.targets)
    return overlay.image


def from_above(photograph: Photograph, places: np.ndarray) -> Image.Image:
    """Return a picture of the table around positions [m], shape (n, 2), from above, with the board's x to the right."""
    low, high = places.min(axis=0) - 0.05, places.max(axis=0) + 0.05
    pixel = max(0.0005, photograph.resolution(places), float((high - low).max()) / MAX_PIXELS)
    columns = np.arange(low[0], high[0], pixel)
    rows = np.arange(high[1], low[1], -pixel)
    x, y = np.meshgrid(columns, rows)
    maps = photograph.in_pixels(np.column_stack([x.ravel(), y.ravel()])).astype(np.float32).reshape(*x.shape, 2)
    cv2 = opencv()
    return Image.fromarray(cv2.remap(photograph.pixels, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR))


def write_picture(image: Image.Image, path: Path) -> None:
    """Write a picture as a PNG or JPEG file, depending on the name's ending."""
    check_picture(path, "picture")
    buffer = io.BytesIO()
    options: Mapping[str, Any] = {} if path.suffix.lower() == ".png" else {"quality": 90}
    image.save(buffer, FORMATS[path.suffix.lower()], **options)
    with replacing(path) as temporary:
        temporary.write_bytes(buffer.getvalue())


def check_picture(path: Path, option: str) -> None:
    """Refuse a file name that does not end in .png, .jpg or .jpeg."""
    if path.suffix.lower() not in FORMATS:
        raise InputError(f"{option}: must be a .png or .jpg file, given {path}")
