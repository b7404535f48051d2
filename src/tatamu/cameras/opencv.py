"""Imports OpenCV, which `pip install tatamu[photo]` installs."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

from tatamu.base.errors import InputError


def opencv() -> Any:
    """Return the module `cv2`; raise InputError if it is not installed."""
    if find_spec("cv2") is None:
        raise InputError("photographs need the package opencv-python-headless: pip install 'tatamu[photo]'")
    import cv2

    return cv2
