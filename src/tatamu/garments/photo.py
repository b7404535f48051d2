"""Finds the outline of a garment in a photo.

An alpha channel is an exact mask, as written by programs that cut a garment out of its background. In other photos, the
garment is found by its difference in colour from the table.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import shapely

from tatamu.base.errors import InputError
from tatamu.garments.foreground import MIN_AREA, stand_out
from tatamu.garments.picture import read_picture


@dataclass(frozen=True)
class Photo:
    """A photo and the outline of the garment in it."""

    pixels: np.ndarray
    """Pixels of the photo in 8-bit RGB, shape (h, w, 3)."""
    outline: np.ndarray
    """Points of the closed outline, x to the right and y down, the first not repeated [pixels], shape (k, 2)."""
    notes: tuple[str, ...] = ()
    """Notes on choices that the user should check."""


def find_outline(path: Path, join: bool = False, apart: np.ndarray | None = None) -> Photo:
    """Read a photo and find the garment in it.

    Args:
        path: Path of the photo.
        join: Whether all regions that differ from the table belong to the garment, such as one of several colours.
        apart: Positions on other things, such as a sheet of paper [pixels], shape (k, 2).

    Raises:
        InputError: If scikit-image is missing, the file is not a picture, or no garment differs from a plain table.
    """
    if find_spec("skimage") is None:
        raise InputError("photos need the package scikit-image, which is not installed: pip install 'tatamu[photo]'")
    picture = read_picture(path)
    pixels = picture.pixels
    reduced = reduction(pixels)
    if picture.alpha is not None:
        share, notes = _kept(blocks(picture.alpha[..., None], reduced)[..., 0], path)
    else:
        places = np.empty((0, 2)) if apart is None else apart / reduced
        found = stand_out(blocks(pixels, reduced), path, join, places)
        share = softened(found.mask)
        notes = _others_note(found.others)
    outline = (contour(share) + 0.5) * reduced - 0.5
    extent = float(np.ptp(outline, axis=0).max())
    simple = shapely.Polygon(outline).simplify(0.004 * extent).exterior.coords[:-1]
    return Photo(pixels, np.array(simple), notes)


def _others_note(others: tuple[float, ...]) -> tuple[str, ...]:
    if not others:
        return ()
    shares = ", ".join(f"{100 * share:.0f} %" for share in others[:5])
    what = "1 other region stands" if len(others) == 1 else f"{len(others)} other regions stand"
    return (
        f"{what} out ({shares} of the garment's area); give --join if all regions are one garment of several colours",
    )


def reduction(pixels: np.ndarray) -> int:
    """Return the width of the blocks of pixels that are averaged to reduce a picture before the search [pixels]."""
    return max(1, int(np.ceil(max(pixels.shape[:2]) / 1400)))


def _kept(share: np.ndarray, path: Path) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return how much of each pixel the largest region of an alpha channel covers, with holes filled, and notes."""
    from scipy.ndimage import binary_fill_holes
    from skimage.measure import label

    regions = label(share > 0.5)
    sizes = np.bincount(regions.ravel())[1:]
    if not len(sizes) or sizes.max() < MIN_AREA * share.size:
        raise InputError(f"{path}: photo: its alpha channel must show a garment, given an almost empty channel")
    garment = np.asarray(binary_fill_holes(regions == 1 + int(sizes.argmax())))
    beside = np.asarray((regions > 0) & ~garment)
    return np.where(beside, 0.0, np.where(garment, np.maximum(share, 0.51), share)), (
        "outlined by the picture's alpha channel, which cuts the garment out",
    )


def blocks(pixels: np.ndarray, size: int) -> np.ndarray:
    """Return the mean of blocks of `size` x `size` pixels, from 0 to 1, shape (h, w, channels)."""
    height, width = (side // size for side in pixels.shape[:2])
    blocks = pixels[: height * size, : width * size].reshape(height, size, width, size, -1)
    return blocks.mean(axis=(1, 3)) / 255.0


def softened(mask: np.ndarray) -> np.ndarray:
    """Return a mask whose border is smoothed to values between 0 and 1, shape (h, w)."""
    from scipy.ndimage import gaussian_filter

    return np.asarray(gaussian_filter(mask.astype(float), 1.0))


def contour(share: np.ndarray) -> np.ndarray:
    """Return the border of a mask's region to a fraction of a pixel, as x and y [pixels], shape (k, 2)."""
    from skimage.measure import find_contours

    longest = max(find_contours(np.pad(share, 1), 0.5), key=len)
    return np.asarray(longest[:-1, ::-1]) - 1.0


def homography(corners: np.ndarray, width: float, height: float) -> np.ndarray:
    """Return the matrix from pixels to metres that maps four corners in a photo to a rectangle [m], shape (3, 3).

    The corners are top left, top right, bottom right and bottom left [pixels], shape (4, 2).

    Raises:
        InputError: If the corners are in another order or lie on a line.
    """
    wanted = np.array([[0, 0], [width, 0], [width, height], [0, height]])
    rows = []
    for (x, y), (u, v) in zip(corners, wanted, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y]]
    try:
        matrix = np.append(np.linalg.solve(np.array(rows), wanted.ravel()), 1.0).reshape(3, 3)
    except np.linalg.LinAlgError:
        raise InputError("sheet: its four corners must not lie on a line") from None
    sides = np.roll(corners, -1, axis=0) - corners
    turns = sides[:, 0] * np.roll(sides[:, 1], -1) - sides[:, 1] * np.roll(sides[:, 0], -1)
    if not (turns > 0.0).all():
        raise InputError("sheet: its corners must be top left, top right, bottom right, bottom left")
    return matrix


def straightened(outline: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Convert an outline from pixels of a photo to positions on the table [m], shape (k, 2).

    Raises:
        InputError: If a part of the outline lies behind the horizon of the table.
    """
    moved = np.column_stack([outline, np.ones(len(outline))]) @ matrix.T
    if not (moved[:, 2] > 1e-9 * np.abs(moved).max()).all():
        raise InputError("sheet: its corners must give a plane on which the whole garment lies; give other corners")
    return np.asarray(moved[:, :2] / moved[:, 2:])


def outline_svg(outline: np.ndarray, openings: Mapping[str, np.ndarray] | None = None) -> str:
    """Return an SVG file in millimetres of an outline and its openings.

    Args:
        outline: Points of the closed outline [m], x to the right and y down, shape (k, 2).
        openings: Indices of the outline's points along each opening, by name.
    """
    points = 1e3 * (outline - outline.min(axis=0))
    lines = "".join(
        f'<polyline id="{name}" points="{_places(points[numbers])}" fill="none" stroke="#d02090" stroke-width="3"/>\n'
        for name, numbers in (openings or {}).items()
    )
    width, height = points.max(axis=0)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.1f}mm" height="{height:.1f}mm" '
        f'viewBox="0 0 {width:.1f} {height:.1f}">\n'
        f'<polygon id="outline" points="{_places(points)}" fill="#dfe6f4" stroke="#2b3f74"/>\n{lines}</svg>\n'
    )


def _places(points: np.ndarray) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
