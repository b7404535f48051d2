"""Reads pixels from options of `tatamu outline` and `tatamu measure`, and draws outlines on photos.

The options give a length in metres, and pixels of the photo that are this length apart. They determine the scale.
"""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.size import parse_size
from tatamu.garments.photo import Photo, homography

MAX_PIXEL = 1e6
"""Largest coordinate of a pixel that is accepted in an option."""


def to_metres(photo: Photo, width: float | None, ruler: str | None, sheet: str | None) -> np.ndarray:
    """Return the matrix that converts pixels of a photo to metres, shape (3, 3), from the options that give a scale."""
    if sheet is not None:
        return homography(corners_of(sheet), *parse_size(sheet.split()[-1], "--sheet"))
    if ruler is not None:
        *ends, length = ruler.split() or [""]
        if len(ends) != 2:
            raise InputError(f"--ruler: must be two pixels X,Y and a length in metres, given {ruler!r}")
        start, end = (_pixel("--ruler", pixel) for pixel in ends)
        apart, metres = float(np.linalg.norm(end - start)), _number("--ruler", length)
    else:
        apart, metres = float(np.ptp(photo.outline[:, 0])), width or 0.0
    if not apart > 0.0:
        raise InputError("--ruler: must be two different pixels and a length, given one pixel twice")
    if not 0.0 < metres < np.inf:
        raise InputError(f"{'--width' if ruler is None else '--ruler'}: must be a length above 0 m, given {metres:g} m")
    return np.diag([metres / apart, metres / apart, 1.0])


def corners_of(sheet: str) -> np.ndarray:
    """Read the corners of a sheet of paper from the option `--sheet` [pixels], shape (4, 2)."""
    corners = sheet.split()[:-1]
    if len(corners) != 4:
        raise InputError(f"--sheet: must be four corners X,Y and a size WxH, given {sheet!r}")
    return np.array([_pixel("--sheet", corner) for corner in corners])


def _pixel(option: str, text: str) -> np.ndarray:
    parts = text.split(",")
    if len(parts) != 2:
        raise InputError(f"{option}: must be a pixel X,Y, given {text!r}")
    place = np.array([_number(option, part) for part in parts])
    if not (np.abs(place) <= MAX_PIXEL).all():
        raise InputError(f"{option}: must be pixels X,Y from {-MAX_PIXEL:g} to {MAX_PIXEL:g}, given {text!r}")
    return place


def _number(option: str, text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InputError(f"{option}: must be a number, given {text!r}")
    return value


def drawn_over(photo: Photo, openings: Mapping[str, np.ndarray]) -> bytes:
    """Draw the outline of a garment and its openings on the photo, and return the bytes of a JPEG file."""
    from PIL import Image, ImageDraw

    image = Image.fromarray(photo.pixels)
    points = [tuple(p) for p in np.vstack([photo.outline, photo.outline[:2]])]
    wide = max(2, round(max(image.size) / 300))
    canvas = ImageDraw.Draw(image)
    canvas.line(points, "#ffffff", 2 * wide, joint="curve")
    canvas.line(points, "#d02090", wide, joint="curve")
    for name, numbers in openings.items():
        along = photo.outline[numbers]
        canvas.line([tuple(p) for p in along], "#ffffff", 4 * wide, joint="curve")
        canvas.line([tuple(p) for p in along], "#1f6fd0", 3 * wide, joint="curve")
        middle = tuple(along[[0, -1]].mean(axis=0))
        canvas.text(middle, name, "#1f6fd0", anchor="mm", font_size=8 * wide, stroke_width=wide, stroke_fill="#ffffff")
    buffer = io.BytesIO()
    image.save(buffer, "JPEG", quality=88)
    return buffer.getvalue()
