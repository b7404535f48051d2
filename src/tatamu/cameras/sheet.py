"""Finds a plain white sheet of paper that lies next to the cloth and gives the scale of a photo.

Its frame has its origin in the middle, and x along the long side to the right in the photo.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import shapely

from tatamu.base.errors import InputError
from tatamu.cameras import opencv
from tatamu.cameras.board import PAPERS
from tatamu.cameras.camera import View, estimate
from tatamu.cameras.edges import Line, step_edges
from tatamu.cameras.lens import Lens

SEARCH_PIXELS = 1400
"""Number of pixels along the longer side to which photos are reduced for the search for a sheet of paper."""


@dataclass(frozen=True)
class Sheet:
    """A plain sheet of paper, which gives a photograph its scale."""

    name: str
    size: tuple[float, float]
    """Lengths of the sheet's long side and of its short side [m]."""

    @property
    def corners(self) -> np.ndarray:
        """Corners of the sheet in its frame [m], shape (4, 2), in counter-clockwise order from the corner at -x, -y."""
        long, short = self.size
        return 0.5 * np.array([[-long, -short], [long, -short], [long, short], [-long, short]])

    @property
    def marks(self) -> np.ndarray:
        """Corners of the sheet at (-x, -y), (+x, -y) and (-x, +y), in its frame [m], shape (3, 2)."""
        return self.corners[[0, 1, 3]]


SHEETS = {name: Sheet(name, (size[1], size[0])) for name, size in PAPERS.items()}


def find_sheet(pixels: np.ndarray, sheet: Sheet, lens: Lens | None, focal: float | None) -> View:
    """Find the camera of a photo from a sheet of paper; raise InputError if no quadrangle can be this sheet."""
    size = (pixels.shape[1], pixels.shape[0])
    good = []
    for quad in _quadrangles(pixels):
        corners = _sharp(pixels, quad)
        if corners is None:
            continue
        for shift in (0, 1):
            ordered = np.roll(corners, shift, axis=0)
            along = 0.5 * (ordered[1] + ordered[2] - ordered[0] - ordered[3])
            ordered = ordered if along[0] > 0 else np.roll(ordered, 2, axis=0)
            with suppress(InputError):
                view = estimate([(sheet.corners, ordered)], size, lens, focal)
                good += [view] if view.rms < 3.0 else []
    if not good:
        raise InputError(
            f"sheet: a white {sheet.name} sheet must be visible in the photo; lay the whole sheet flat on a darker "
            "table, beside the cloth"
        )
    return min(good, key=lambda view: view.penalty)


def _quadrangles(pixels: np.ndarray) -> list[np.ndarray]:
    """Return bright convex quadrangles [pixels], shape (4, 2) each, counter-clockwise as seen from above the table."""
    cv2 = opencv()
    factor = max(1.0, max(pixels.shape[:2]) / SEARCH_PIXELS)
    small = cv2.resize(pixels, None, fx=1 / factor, fy=1 / factor, interpolation=cv2.INTER_AREA)
    dark = cv2.GaussianBlur(small.min(axis=2), (0, 0), 1.5)
    top = float(np.percentile(dark, 99.5))
    found: list[np.ndarray] = []
    for level in (0.6, 0.7, 0.8, 0.88):
        outlines, _ = cv2.findContours((dark > level * top).astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        for outline in outlines:
            share = cv2.contourArea(outline) / dark.size
            quad = cv2.approxPolyDP(outline, 0.03 * cv2.arcLength(outline, True), True)[:, 0]
            if not 0.002 < share < 0.4 or len(quad) != 4 or not cv2.isContourConvex(quad) or not _is_plain(dark, quad):
                continue
            corners = (quad.astype(float) + 0.5) * factor - 0.5
            if shapely.is_ccw(shapely.LinearRing(corners)):  # y points down in pixels
                corners = corners[::-1]
            if not any(np.abs(corners.mean(axis=0) - other.mean(axis=0)).max() < 5 * factor for other in found):
                found.append(corners)
    return found


def _is_plain(dark: np.ndarray, quad: np.ndarray) -> bool:
    """Return whether a quadrangle has the same brightness everywhere, unlike a printed page."""
    middle = quad.mean(axis=0)
    inner = np.round(middle + 0.85 * (quad - middle)).astype(np.int32)
    there = np.zeros(dark.shape, dtype=np.uint8)
    opencv().fillPoly(there, [inner], 1)
    inside = dark[there > 0]
    return len(inside) > 0 and float((inside < 0.75 * np.median(inside)).mean()) < 0.02


def _sharp(pixels: np.ndarray, corners: np.ndarray) -> np.ndarray | None:
    """Return the intersections of a quadrangle's fitted sides [pixels], shape (4, 2); None if a side is unclear."""
    reach = 3.0 + max(pixels.shape[:2]) / SEARCH_PIXELS * 2.0
    lines = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        at = np.linspace(0.08, 0.92, 60)[:, None]
        points = start + at * (end - start)
        across = np.array([-(end - start)[1], (end - start)[0]]) / np.linalg.norm(end - start)
        edges = step_edges(pixels, points, np.tile(across, (len(points), 1)), reach)
        if edges.found.mean() < 0.5:
            return None
        lines.append(Line.through(edges.points[edges.found]))
    return np.array([lines[k - 1].meets(lines[k]) for k in range(4)])
