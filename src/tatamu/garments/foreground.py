"""Finds a garment in a photo, by its difference in colour from a plain table.

The colour of the table is a smooth function of the position, fitted to a frame along the border, so uneven light does
no harm. Pixels that differ by more than Otsu's threshold form regions, of which the largest is the garment.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely

from tatamu.base.errors import InputError

FRAME = 0.04
"""Width of the frame that shows only the table, as a fraction of the photo's extent."""
FAINTEST = 6.0
"""Minimum difference in colour between garment and table [CIELAB units]."""
MIN_AREA, MAX_AREA = 0.02, 0.9
"""Minimum and maximum fraction of the photo that a garment covers."""
EDGE = 4
"""Distance from the border of the photo [pixels] below which a garment touches it."""


@dataclass(frozen=True)
class Foreground:
    """The garment in a photo, separated from the table."""

    mask: np.ndarray
    """Whether each pixel shows the garment, with holes filled, shape (h, w)."""
    others: tuple[float, ...]
    """Areas of further regions that were left out, relative to the garment's, in falling order."""


def stand_out(
    image: np.ndarray, path: Path, join: bool, apart: np.ndarray, ignored: np.ndarray | None = None
) -> Foreground:
    """Find the largest region of a photo whose colour differs from the table's colour.

    Args:
        image: Red, green and blue from 0 to 1, shape (h, w, 3).
        path: Path of the file, for messages.
        join: Whether all regions that differ from the table belong to the garment.
        apart: Points on things that do not belong to the garment, such as paper [pixels], shape (k, 2).
        ignored: Mask of pixels to ignore, shape (h, w).

    Raises:
        InputError: If no region differs enough from the table, or the garment touches the border of the photo.
    """
    from scipy.ndimage import binary_closing, binary_fill_holes, binary_opening
    from skimage.filters import threshold_otsu
    from skimage.measure import label

    usable = np.ones(image.shape[:2], dtype=bool) if ignored is None else ~ignored
    away = _difference(image, usable)
    threshold = max(float(threshold_otsu(away[usable])), 0.5 * FAINTEST)
    spot = np.hypot(*np.mgrid[-2:3, -2:3]) <= 2.3
    mask = binary_opening(binary_closing((away > threshold) & usable, spot), spot)
    regions = label(mask)
    sizes = np.bincount(regions.ravel())[1:]
    if not len(sizes) or not MIN_AREA < sizes.max() / mask.size < MAX_AREA or np.median(away[mask]) < FAINTEST:
        raise InputError(
            f"{path}: photo: no garment stands out from a plain table; give more contrast or crop the photo"
        )
    order = 1 + np.argsort(-sizes, kind="stable")
    # smaller regions are ignored
    filled = [np.asarray(binary_fill_holes(regions == k)) for k in order if sizes[k - 1] >= 0.05 * sizes.max()]
    largest, *others = filled
    others = [other for other in others if not (other & largest).any() and not _holds(other, apart)]
    share = sum(float(other.sum() / largest.sum()) for other in others)
    if join:
        largest, others = _joined([largest, *others]), []
    elif share > 0.4:
        whole = _joined([largest, *others])
        helps = whole.sum() == whole[EDGE:-EDGE, EDGE:-EDGE].sum()
        remedy = "give --join if all regions are one garment, such as a striped shirt, or " if helps else ""
        raise InputError(
            f"{path}: photo: {len(others) + 1} regions stand out, of which the largest covers {100 / (1 + share):.0f} "
            f"%; {remedy}crop the photo to one region"
        )
    if largest.sum() > largest[EDGE:-EDGE, EDGE:-EDGE].sum():
        raise InputError(
            f"{path}: photo: must show table all around the garment, given a garment that touches the border"
        )
    return Foreground(largest, tuple(float(other.sum() / largest.sum()) for other in others))


def _holds(region: np.ndarray, places: np.ndarray) -> bool:
    """Return whether a region contains at least one of the positions [pixels]."""
    x, y = np.round(places).astype(int).reshape(-1, 2).T
    inside = (x >= 0) & (y >= 0) & (x < region.shape[1]) & (y < region.shape[0])
    return bool(region[y[inside], x[inside]].any())


def _difference(image: np.ndarray, usable: np.ndarray) -> np.ndarray:
    """Return each pixel's difference in colour from the table [CIELAB units], shape (h, w)."""
    from scipy.ndimage import gaussian_filter
    from skimage.color import rgb2lab

    # lightness counts less, because shadows change it, but not colour
    lab = gaussian_filter(rgb2lab(image), (1.2, 1.2, 0)) * [0.6, 1.0, 1.0]
    height, width = lab.shape[:2]
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    frame = (np.abs(x) > 1 - 2 * FRAME) | (np.abs(y) > 1 - 2 * FRAME)
    known = terms[frame & usable]
    wanted = lab[frame & usable]
    weight = np.ones(len(known))
    for _ in range(5):  # reweighted, so that a ruler or a shadow on the frame counts little
        root = np.sqrt(weight)[:, None]
        fit = np.linalg.lstsq(known * root, wanted * root, rcond=None)[0]
        off = np.linalg.norm(wanted - known @ fit, axis=1)
        weight = 1.0 / (1.0 + (off / (2.0 * np.median(off) + 1e-6)) ** 2)
    return np.asarray(np.linalg.norm(lab - terms @ fit, axis=-1))


def _joined(regions: list[np.ndarray]) -> np.ndarray:
    """Return one region with several regions, and the convex hull of the border points that face each other."""
    from scipy.ndimage import binary_fill_holes

    whole = regions[0]
    rest = list(regions[1:])
    while rest:
        gaps = [_facing(whole, other) for other in rest]
        nearest = int(np.argmin([gap for gap, _ in gaps]))
        whole = whole | rest.pop(nearest) | _drawn(gaps[nearest][1], whole.shape)
    return np.asarray(binary_fill_holes(whole))


def _facing(one: np.ndarray, other: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the distance between two regions, and their border points that face each other, shape (k, 2) [pixels]."""
    from scipy.spatial import cKDTree

    borders = [_border(one), _border(other)]
    distances = [cKDTree(borders[1 - k]).query(borders[k])[0] for k in (0, 1)]
    gap = float(distances[0].min())
    near = max(1.1 * gap, gap + 3.0)
    return gap, np.concatenate([border[away <= near] for border, away in zip(borders, distances, strict=True)])


def _border(region: np.ndarray) -> np.ndarray:
    """Return a region's border pixels as x and y, shape (k, 2)."""
    from scipy.ndimage import binary_erosion

    return np.argwhere(region & ~binary_erosion(region))[:, ::-1]


def _drawn(points: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return the pixels in the convex hull of points, shape (h, w)."""
    from skimage.draw import polygon2mask

    hull = shapely.MultiPoint(points).convex_hull.buffer(0.5)
    return np.asarray(polygon2mask(shape, np.array(hull.exterior.coords)[:, ::-1]))
