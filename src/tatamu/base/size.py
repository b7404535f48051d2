"""Sizes on the command line, such as 0.34x0.80."""

from __future__ import annotations

import math

from tatamu.base.errors import InputError


def parse_size(text: str, option: str = "size") -> tuple[float, float]:
    """Return width and length [m] from a text such as "0.34x0.80". Errors name the option."""
    try:
        width, length = (float(part) for part in text.lower().split("x"))
    except ValueError:
        raise InputError(f"{option}: must be WIDTHxLENGTH in metres, such as 0.34x0.80, given {text!r}") from None
    if not (0.0 < width < math.inf and 0.0 < length < math.inf):
        raise InputError(f"{option}: must have two sides longer than 0 m, given {text!r}")
    return width, length
