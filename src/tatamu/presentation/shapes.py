"""The shapes of a drawing. Places are in metres, widths in pixels; colours are names of `palette` or "#rrggbb"."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FONT = 13
"""Height of the letters [pixels]."""


@dataclass(frozen=True)
class Polyline:
    """A line through points, or a filled region."""

    points: np.ndarray
    """[m], shape (k, 2)."""
    colour: str = "ink"
    width: float = 1.0
    """[pixels]; 0: only filled."""
    dash: float = 0.0
    """Length of dashes and gaps [pixels]; 0: drawn through."""
    fill: str | None = None
    opacity: float = 1.0


@dataclass(frozen=True)
class Segments:
    """Many short lines of one kind, such as the edges of a mesh."""

    ends: np.ndarray
    """[m], shape (k, 2, 2)."""
    colour: str
    width: float = 0.5
    """[pixels]."""
    opacity: float = 1.0


@dataclass(frozen=True)
class Dot:
    """A filled circle."""

    place: np.ndarray
    colour: str
    radius: float = 4.0
    """[pixels]."""


@dataclass(frozen=True)
class Box:
    """A filled rectangle along the axes."""

    low: np.ndarray
    """A corner [m], shape (2,)."""
    high: np.ndarray
    """The corner across [m], shape (2,)."""
    fill: str
    edge: str | None = None
    """Colour of its outline."""


@dataclass(frozen=True)
class Label:
    """A word next to a place, on the side given by `towards`."""

    place: np.ndarray
    text: str
    towards: np.ndarray
    """Direction in the plane, shape (2,); zero: centred on the place."""
    colour: str = "ink"


@dataclass(frozen=True)
class Picture:
    """An image that fills the drawing, under all shapes."""

    source: str
    """Its address, such as `image.data_uri` makes."""


Shape = Polyline | Segments | Dot | Box | Label | Picture
