"""Compresses data inside a page and encodes them as text, which packing.js decodes.

The Plotly script and the data of the replay shrink to a third of their size.
"""

from __future__ import annotations

import base64
import zlib

import numpy as np


def packed(data: bytes) -> str:
    """Compress bytes (deflate) and encode them in base 64; packing.js decodes the result."""
    return base64.b64encode(zlib.compress(data, 9)).decode()


def motion(steps: np.ndarray) -> bytes:
    """Encode numbers that change smoothly from frame to frame as bytes that can be compressed well.

    Each number is predicted by a straight line through its values in the two frames before. Only the difference from
    the prediction is stored, modulo 65536. Differences are stored as codes, so that both a small positive and a small
    negative difference give a small number. All low bytes are stored first, and then all high bytes.

    Args:
        steps: Whole numbers from 0 to 65535 in f frames, shape (f, ..).
    """
    wide = np.zeros((len(steps) + 2, *steps.shape[1:]), dtype=np.int64)
    wide[2:] = steps
    off = (wide[2:] - 2 * wide[1:-1] + wide[:-2]).astype(np.int16)
    folded = ((off << 1) ^ (off >> 15)).view(np.uint16).ravel()
    return bytes((folded & 255).astype(np.uint8)) + bytes((folded >> 8).astype(np.uint8))
