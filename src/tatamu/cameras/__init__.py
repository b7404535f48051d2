"""Measures cloth on a table in photographs; a printed board next to the cloth gives the scale."""

from __future__ import annotations

from typing import Any

from tatamu.base.extras import require


def opencv() -> Any:
    """Return the module `cv2`; raise InputError if it is not installed."""
    require("cv2", "photo", "photographs", "opencv-python-headless")
    import cv2

    return cv2
