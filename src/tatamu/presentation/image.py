"""Pictures as bytes of PNG files and as addresses inside a page."""

from __future__ import annotations

import base64
import io
from pathlib import Path

import numpy as np
from PIL import Image

from tatamu.files import MIB, read_bytes, replacing

LARGEST = 16 * MIB
"""Largest size of a picture in a page [bytes]."""


def png(pixels: np.ndarray) -> bytes:
    """A PNG file of pixels: uint8, shape (h, w, 4), RGBA with straight alpha, row 0 on top."""
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def data_uri(pixels: np.ndarray) -> str:
    """Return the picture as a data URI."""
    return "data:image/png;base64," + base64.b64encode(png(pixels)).decode()


def jpeg_uri(path: Path) -> str:
    """Return the picture in a JPEG file as a data URI.

    Raises:
        InputError: The file cannot be read.
    """
    return "data:image/jpeg;base64," + base64.b64encode(read_bytes(path, LARGEST)).decode()


def save_png(pixels: np.ndarray, path: Path) -> None:
    """Write a picture in one piece.

    Raises:
        InputError: If the file cannot be written.
    """
    data = png(pixels)
    with replacing(path) as temporary:
        temporary.write_bytes(data)
