"""Defines every colour in light and dark mode. A colour has the same meaning in pictures, charts and the replay."""

from __future__ import annotations

import numpy as np

FRONT = "#3f66b0"
"""Colour of the side that faces up before the fold; of two layers, of the outside of the upper one."""
REAR = "#a9cbf0"
"""Colour of the outside of the lower layer, if the cloth has two layers."""
BACK = "#f0b774"
"""Colour of the side that faces down before the fold; of two layers, of their inside."""
SIDES = {
    1: (("front", "side up at the start"), ("back", "other side")),
    2: (("front", "outside of the front"), ("rear", "outside of the back"), ("back", "inside")),
}
"""Colours and names of the sides of cloth, by the number of layers."""
TARGET = "#9a78f2"
LEFT = "#d64a57"
"""Colour of the left hand."""
RIGHT = "#14968c"
"""Colour of the right hand."""
SCALE = ("#fdf3dc", "#f9c982", "#ef8a5b", "#c9475f", "#6b2a72")
"""Colours of the scale for vertex errors, from zero to the largest. Their lightness decreases evenly, so the scale can
also be read in grey."""
TABLE = "#e9e5dd"
SOLID = "#8a93a3"
"""Colour of rigid bodies."""

SERIES = 8
"""Number of the colours `series-0`, `series-1`, ..., which are for curves in charts without a special meaning."""

COLOURS = {
    "paper": ("#f6f4ef", "#15171c"),
    "card": ("#ffffff", "#1d2027"),
    "ink": ("#20242c", "#e9e7e2"),
    "muted": ("#666d7a", "#9aa1ae"),
    "line": ("#e7e3da", "#30353f"),
    "accent": ("#2b3f74", "#c9d4f5"),
    "warm": ("#d07a31", "#e59a55"),
    "plot": ("#3f66b0", "#7d9ee6"),
    "reading": ("#d64a57", "#f07f89"),
    "grip": ("#cbd2d9", "#4a515d"),
    "table": ("#ece8df", "#2b2f38"),
    "table-line": ("#d6d0c3", "#414755"),
    "cloth": ("#dfe6f4", "#2b3650"),
    "mesh": ("#b9c6e0", "#4a5a80"),
    "near-perfect": ("#1f8a5b", "#3fb27f"),
    "good": ("#4d9b3f", "#74b85f"),
    "fair": ("#c08a1e", "#dba941"),
    "failed": ("#bf3b3b", "#e06464"),
    "series-0": ("#d9480f", "#ff8a50"),
    "series-1": ("#1971c2", "#5aa9f0"),
    "series-2": ("#2f9e44", "#5cc972"),
    "series-3": ("#ae3ec9", "#d07be6"),
    "series-4": ("#f08c00", "#ffb84d"),
    "series-5": ("#0c8599", "#3fbfd2"),
    "series-6": ("#c2255c", "#f0709b"),
    "series-7": ("#5c940d", "#94cc3a"),
    "front": (FRONT, FRONT),
    "rear": (REAR, REAR),
    "back": (BACK, BACK),
    "target": (TARGET, TARGET),
    "left": (LEFT, LEFT),
    "right": (RIGHT, RIGHT),
    "robot": ("#8d939c", "#8d939c"),
    **{f"scale-{number}": (stop, stop) for number, stop in enumerate(SCALE)},
}
"""Colours by name, as "#rrggbb" in light mode and in dark mode."""


def rgb(colour: str) -> np.ndarray:
    """Return the linear light of a colour "#rrggbb", from 0 to 1, shape (3,)."""
    code = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    return code**2.2


def day(colour: str) -> str:
    """Return the light-mode colour as "#rrggbb" for the name of a colour. A colour "#rrggbb" is returned unchanged."""
    return COLOURS[colour][0] if colour in COLOURS else colour


def css() -> str:
    """Return all colours as custom properties of a style sheet, for light mode and for dark mode."""
    day = "".join(f"--{name}:{light};" for name, (light, _) in COLOURS.items())
    night = "".join(f"--{name}:{dark};" for name, (light, dark) in COLOURS.items() if dark != light)
    return f":root{{{day}}}\n@media (prefers-color-scheme: dark){{:root{{{night}}}}}\n"
