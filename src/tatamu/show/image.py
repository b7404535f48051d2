"""Converts pictures to PNG files and to data URIs, which store a picture inside a page."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import numpy as np
from PIL import Image

from tatamu.base.files import MIB, read_bytes, write_bytes


def encoded(image: Image.Image) -> bytes:
    """Return an image as the bytes of a PNG file."""
    buffer = io.BytesIO()
    image.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def png(pixels: np.ndarray) -> bytes:
    """Return pixels with straight alpha, uint8 of shape (h, w, 4), as the bytes of a PNG file."""
    return encoded(Image.fromarray(pixels))


def data_uri(pixels: np.ndarray) -> str:
    """Return a picture as a data URI."""
    return "data:image/png;base64," + base64.b64encode(png(pixels)).decode()


def jpeg_uri(path: Path) -> str:
    """Return the picture in a JPEG file as a data URI."""
    return "data:image/jpeg;base64," + base64.b64encode(read_bytes(path, largest=16 * MIB)).decode()


def save_png(pixels: np.ndarray, path: Path) -> None:
    """Write a picture to a PNG file, at once or not at all."""
    write_bytes(path, png(pixels))
