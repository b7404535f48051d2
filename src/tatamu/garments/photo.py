"""Finds the outline of a garment in a photo.

An alpha channel is an exact mask, as written by programs that cut a garment out of its background. In other photos, the
garment is found by its difference in colour from a plain table. The colour of the table is a smooth function of the
position, fitted to a frame along the border, so uneven light does no harm. Pixels that differ by more than Otsu's
threshold form regions, of which the largest is the garment.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from scipy.ndimage import binary_closing, binary_erosion, binary_fill_holes, binary_opening, gaussian_filter
from scipy.spatial import cKDTree

from tatamu.base.errors import InputError
from tatamu.base.extras import require
from tatamu.garments.picture import read_picture
from tatamu.garments.robust import robust_fit

FAINTEST = 6.0
"""Minimum difference in colour between garment and table [CIELAB units]."""
MIN_AREA = 0.02
"""Minimum fraction of the photo that a garment covers."""


def stand_out(
    image: np.ndarray, path: Path, join: bool, apart: np.ndarray, ignored: np.ndarray | None = None
) -> tuple[np.ndarray, tuple[float, ...]]:
    """Find the largest region of a photo whose colour differs from the table's colour.

    Args:
        image: Red, green and blue from 0 to 1, shape (h, w, 3).
        path: Path of the file, for messages.
        join: Whether all regions that differ from the table belong to the garment.
        apart: Points on things that do not belong to the garment, such as paper [pixels], shape (k, 2).
        ignored: Mask of pixels to ignore, shape (h, w).

    Returns:
        How much of each pixel the region covers, from 0 to 1, shape (h, w), with holes filled and a smooth border; and
        the areas of further regions that were left out, relative to the garment's, in falling order.

    Raises:
        InputError: If no region differs enough from the table, or the garment touches the border of the photo.
    """
    from skimage.filters import threshold_otsu
    from skimage.measure import label

    usable = np.ones(image.shape[:2], dtype=bool) if ignored is None else ~ignored
    away = _difference(image, usable)
    threshold = max(float(threshold_otsu(away[usable])), 0.5 * FAINTEST)
    spot = np.hypot(*np.mgrid[-2:3, -2:3]) <= 2.3
    mask = binary_opening(binary_closing((away > threshold) & usable, spot), spot)
    regions = label(mask)
    sizes = np.bincount(regions.ravel())[1:]
    if not len(sizes) or not MIN_AREA < sizes.max() / mask.size < 0.9 or np.median(away[mask]) < FAINTEST:
        raise InputError(
            f"{path}: photo: no garment stands out from the table; use a plain table of another colour, or crop the "
            "photo"
        )
    order = 1 + np.argsort(-sizes, kind="stable")
    # smaller regions are ignored
    filled = [np.asarray(binary_fill_holes(regions == k)) for k in order if sizes[k - 1] >= 0.05 * sizes.max()]
    largest, *others = filled
    others = [other for other in others if not (other & largest).any() and not _holds(other, apart)]
    beside = sum(float(other.sum() / largest.sum()) for other in others)
    if join:
        largest, others = _joined([largest, *others]), []
    elif beside > 0.4:
        helps = not _touches_border(_joined([largest, *others]))
        remedy = "give --join if all regions are one garment, such as a striped shirt, or " if helps else ""
        raise InputError(
            f"{path}: photo: {len(others) + 1} regions stand out from the table, and the largest has only "
            f"{100 / (1 + beside):.0f} % of their area; {remedy}crop the photo to one region"
        )
    if _touches_border(largest):
        raise InputError(
            f"{path}: photo: must show the table all around the garment, but the garment touches the border of the "
            "photo"
        )
    share = np.asarray(gaussian_filter(largest.astype(float), 1.0))
    return share, tuple(float(other.sum() / largest.sum()) for other in others)


def _touches_border(region: np.ndarray) -> bool:
    return bool(region.sum() > region[4:-4, 4:-4].sum())  # within 4 pixels


def _holds(region: np.ndarray, places: np.ndarray) -> bool:
    """Return whether a region contains at least one of the positions [pixels]."""
    x, y = np.round(places).astype(int).reshape(-1, 2).T
    inside = (x >= 0) & (y >= 0) & (x < region.shape[1]) & (y < region.shape[0])
    return bool(region[y[inside], x[inside]].any())


def _difference(image: np.ndarray, usable: np.ndarray) -> np.ndarray:
    """Return each pixel's difference in colour from the table [CIELAB units], shape (h, w)."""
    from skimage.color import rgb2lab

    # lightness counts less, because shadows change it, but not colour
    lab = gaussian_filter(rgb2lab(image), (1.2, 1.2, 0)) * [0.6, 1.0, 1.0]
    height, width = lab.shape[:2]
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    frame = np.maximum(np.abs(x), np.abs(y)) > 1 - 2 * 0.04  # of 4 %, which shows only the table
    known = frame & usable
    fit = robust_fit(terms[known], lab[known])  # a ruler or a shadow on the frame counts little
    return np.asarray(np.linalg.norm(lab - terms @ fit, axis=-1))


def _joined(regions: list[np.ndarray]) -> np.ndarray:
    """Return one region with several regions, and the convex hull of the border points that face each other."""
    whole = regions[0]
    rest = list(regions[1:])
    while rest:
        gaps = [_facing(whole, other) for other in rest]
        nearest = int(np.argmin([gap for gap, _ in gaps]))
        whole = whole | rest.pop(nearest) | _drawn(gaps[nearest][1], whole.shape)
    return np.asarray(binary_fill_holes(whole))


def _facing(one: np.ndarray, other: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the distance between two regions, and their border points that face each other, shape (k, 2) [pixels]."""
    borders = [_border(one), _border(other)]
    distances = [cKDTree(borders[1 - k]).query(borders[k])[0] for k in (0, 1)]
    gap = float(distances[0].min())
    near = max(1.1 * gap, gap + 3.0)
    return gap, np.concatenate([border[away <= near] for border, away in zip(borders, distances, strict=True)])


def _border(region: np.ndarray) -> np.ndarray:
    """Return a region's border pixels as x and y, shape (k, 2)."""
    return np.argwhere(region & ~binary_erosion(region))[:, ::-1]


def _drawn(points: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return the pixels in the convex hull of points, shape (h, w)."""
    from skimage.draw import polygon2mask

    hull = shapely.MultiPoint(points).convex_hull.buffer(0.5)
    return np.asarray(polygon2mask(shape, np.array(hull.exterior.coords)[:, ::-1]))


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
    require("skimage", "photo", "photos", "scikit-image")
    picture = read_picture(path)
    pixels = picture.pixels
    reduced = reduction(pixels)
    if picture.alpha is not None:
        share = _kept(blocks(picture.alpha[..., None], reduced)[..., 0], path)
        notes: tuple[str, ...] = (
            "the outline is that of the picture's alpha channel, in which the garment is cut out",
        )
    else:
        places = np.empty((0, 2)) if apart is None else apart / reduced
        share, others = stand_out(blocks(pixels, reduced), path, join, places)
        notes = ()
        if others:
            shares = ", ".join(f"{100 * other:.0f} %" for other in others[:5])
            what = "1 other region stands" if len(others) == 1 else f"{len(others)} other regions stand"
            hint = "give --join if all regions are one garment of several colours"
            notes = (f"{what} out from the table ({shares} of the garment's area); {hint}",)
    outline = contour(share, reduced)
    extent = float(np.ptp(outline, axis=0).max())
    simple = shapely.Polygon(outline).simplify(0.004 * extent).exterior.coords[:-1]
    return Photo(pixels, np.array(simple), notes)


def reduction(pixels: np.ndarray) -> int:
    """Return the width of the blocks of pixels that are averaged to reduce a picture before the search [pixels]."""
    return max(1, int(np.ceil(max(pixels.shape[:2]) / 1400)))


def _kept(share: np.ndarray, path: Path) -> np.ndarray:
    """Return how much of each pixel the largest region of an alpha channel covers, with holes filled."""
    from skimage.measure import label

    regions = label(share > 0.5)
    sizes = np.bincount(regions.ravel())[1:]
    if not len(sizes) or sizes.max() < MIN_AREA * share.size:
        raise InputError(f"{path}: photo: the alpha channel must show a garment, but is almost empty")
    garment = np.asarray(binary_fill_holes(regions == 1 + int(sizes.argmax())))
    if garment.mean() > 0.97:
        raise InputError(
            f"{path}: photo: the alpha channel must hide everything around the garment, but shows the picture's border"
        )
    beside = np.asarray((regions > 0) & ~garment)
    return np.where(beside, 0.0, np.where(garment, np.maximum(share, 0.51), share))


def blocks(pixels: np.ndarray, size: int) -> np.ndarray:
    """Return the mean of blocks of `size` x `size` pixels, from 0 to 1, shape (h, w, channels)."""
    height, width = (side // size for side in pixels.shape[:2])
    blocks = pixels[: height * size, : width * size].reshape(height, size, width, size, -1)
    return blocks.mean(axis=(1, 3)) / 255.0


def contour(share: np.ndarray, reduced: int) -> np.ndarray:
    """Return the border of a mask's region to a fraction of a pixel, as x and y [pixels], shape (k, 2).

    `reduced` is the width of the blocks of the photo's pixels that the mask's pixels are.
    """
    from skimage.measure import find_contours

    longest = max(find_contours(np.pad(share, 1), 0.5), key=len)
    # without the padding, and from corners of pixels to their middles
    return (np.asarray(longest[:-1, ::-1]) - 1.0 + 0.5) * reduced - 0.5


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
        raise InputError("sheet: must have corners that do not lie on one line") from None
    sides = np.roll(corners, -1, axis=0) - corners
    turns = sides[:, 0] * np.roll(sides[:, 1], -1) - sides[:, 1] * np.roll(sides[:, 0], -1)
    if not (turns > 0.0).all():
        raise InputError("sheet: must have the corners in the order top left, top right, bottom right, bottom left")
    return matrix


def straightened(outline: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Convert an outline from pixels of a photo to positions on the table [m], shape (k, 2).

    Raises:
        InputError: If a part of the outline lies behind the horizon of the table.
    """
    moved = np.column_stack([outline, np.ones(len(outline))]) @ matrix.T
    if not (moved[:, 2] > 1e-9 * np.abs(moved).max()).all():
        raise InputError(
            "sheet: with these corners, the camera could not see all of the garment from above the table; correct the "
            "corners"
        )
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
