"""What is inside a page: its charts and its replay, read back."""

from __future__ import annotations

import base64
import json
import re
import zlib
from typing import Any

import numpy as np


def charts(page: str) -> dict[str, Any]:
    """The plots of a page by their places."""
    found: dict[str, Any] = _json(page, "chart-data")
    return found


def replay(page: str) -> dict[str, Any]:
    """What the viewer of a page is given."""
    found: dict[str, Any] = _json(page, "replay-data")
    return found


def shown(data: dict[str, Any]) -> np.ndarray:
    """All frames of a replay and its target [m], shape (f + 1, n, 3)."""
    steps = zlib.decompress(base64.b64decode(data["positions"]))
    whole = unpacked(steps, (len(data["times"]) + 1, data["count"], 3))
    places: np.ndarray = np.array(data["low"]) + data["step"] * whole
    return places


def unpacked(data: bytes, shape: tuple[int, ...]) -> np.ndarray:
    """What packing.js does."""
    low, high = np.frombuffer(data, np.uint8).reshape(2, -1).astype(np.int64)
    folded = (low | high << 8).reshape(shape)
    off = (folded >> 1) ^ -(folded & 1)
    out = np.zeros((shape[0] + 2, *shape[1:]), dtype=np.int64)
    for frame in range(shape[0]):
        out[frame + 2] = (off[frame] + 2 * out[frame + 1] - out[frame]) % 65536
    return out[2:]


def _json(page: str, name: str) -> Any:
    found = re.search(rf'id="{name}">(.*?)</script>', page, re.DOTALL)
    assert found, f"the page has no {name}"
    return json.loads(found[1])
