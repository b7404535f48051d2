"""Shapes of a drawing; positions in metres, widths in pixels, colours as names of `palette` or "#rrggbb"."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FONT = 13
"""Height of the letters [pixels]."""


@dataclass(frozen=True)
class Polyline:
    """A line through points, or a filled region."""

    points: np.ndarray
    """Positions of the points [m], shape (k, 2)."""
    colour: str = "ink"
    width: float = 1.0
    """Width of the line [pixels]; 0 for a region without a line."""
    dash: float = 0.0
    """Length of dashes and gaps [pixels]; 0 for a solid line."""
    fill: str | None = None
    opacity: float = 1.0


@dataclass(frozen=True)
class Segments:
    """Many separate, short lines that look the same, such as the edges of a mesh."""

    ends: np.ndarray
    """Both ends of each line [m], shape (k, 2, 2)."""
    colour: str
    width: float = 0.5
    """Width of the lines [pixels]."""
    opacity: float = 1.0


@dataclass(frozen=True)
class Dot:
    """A filled circle."""

    place: np.ndarray
    colour: str
    radius: float = 4.0
    """Radius of the circle [pixels]."""


@dataclass(frozen=True)
class Box:
    """A filled rectangle whose sides are parallel to the axes."""

    low: np.ndarray
    """A corner of the rectangle [m], shape (2,)."""
    high: np.ndarray
    """The opposite corner [m], shape (2,)."""
    fill: str
    edge: str | None = None
    """Colour of the outline; None for a rectangle without an outline."""


@dataclass(frozen=True)
class Label:
    """A word next to a position, on the side given by `towards`."""

    place: np.ndarray
    text: str
    towards: np.ndarray
    """Direction from the position to the word, shape (2,); zero to centre the word."""
    colour: str = "ink"


@dataclass(frozen=True)
class Picture:
    """An image that fills the drawing below all other shapes."""

    source: str
    """Address of the image, such as a data URI from `image.data_uri`."""


Shape = Polyline | Segments | Dot | Box | Label | Picture
