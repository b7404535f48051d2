"""The colours that carry meaning, the same in pictures, figures and the replay, by day and by night."""

from __future__ import annotations

import numpy as np

FRONT = "#3f66b0"
"""The side of the cloth that faces up before the fold."""
BACK = "#f0b774"
"""The other side."""
TARGET = "#9a78f2"
LEFT = "#d64a57"
"""The left hand."""
RIGHT = "#14968c"
"""The right hand."""
SCALE = ("#fdf3dc", "#f9c982", "#ef8a5b", "#c9475f", "#6b2a72")
"""Stops of the scale of e_i, from none to the largest; lightness falls evenly, so it reads in grey too."""
TABLE = "#e9e5dd"
ROBOT = "#8d939c"
"""A robot's links."""

NAMED = {
    "front": FRONT,
    "back": BACK,
    "target": TARGET,
    "left": LEFT,
    "right": RIGHT,
    "robot": ROBOT,
    **{f"scale-{number}": stop for number, stop in enumerate(SCALE)},
}
"""Names that the style sheet, the figures and the viewer use."""


def rgb(colour: str) -> np.ndarray:
    """Linear light of "#rrggbb", each 0 to 1, shape (3,)."""
    code = np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    return code**2.2


def css() -> str:
    """The colours as custom properties of a style sheet."""
    return "".join(f"--{name}:{colour};" for name, colour in NAMED.items())
