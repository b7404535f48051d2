"""Compresses data inside a page and encodes them as text, which packing.js decodes."""

from __future__ import annotations

import base64
import zlib

import numpy as np


def packed(data: bytes) -> str:
    """Compress bytes (deflate) and encode them in base 64; packing.js decodes the result."""
    return base64.b64encode(zlib.compress(data, 9)).decode()


def motion(steps: np.ndarray) -> bytes:
    """Return numbers that change smoothly from frame to frame as bytes that can be compressed well.

    The numbers are whole, from 0 to 65535, shape (f, ..) for f frames. Stored is the difference from a straight line
    through the two frames before, modulo 65536 and zigzag coded: first all low bytes, then all high bytes.
    """
    wide = np.zeros((len(steps) + 2, *steps.shape[1:]), dtype=np.int64)
    wide[2:] = steps
    off = (wide[2:] - 2 * wide[1:-1] + wide[:-2]).astype(np.int16)
    folded = ((off << 1) ^ (off >> 15)).view(np.uint16).ravel()
    return bytes((folded & 255).astype(np.uint8)) + bytes((folded >> 8).astype(np.uint8))
