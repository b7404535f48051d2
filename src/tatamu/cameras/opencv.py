"""Imports OpenCV, which `pip install tatamu[photo]` installs."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

from tatamu.base.extras import lacking


def opencv() -> Any:
    """Return the module `cv2`; raise InputError if it is not installed."""
    if find_spec("cv2") is None:
        raise lacking("opencv-python-headless", "photo", "photographs")
    import cv2

    return cv2
