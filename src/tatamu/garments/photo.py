"""The outline of a garment on a photo: what differs from the table around it.

The table's colour is modelled as a smooth surface over the photo, fitted to a frame along the photo's border; so uneven
light does no harm. What is farther from it than Otsu's threshold is the garment.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import shapely

from tatamu.errors import InputError

LONGEST = 1400
"""Photos are reduced to this many pixels at most, for speed."""
FRAME = 0.04
"""Part of the photo's width and height, on each side, that shows the table only."""
LIGHTNESS = 0.6
"""Weight of lightness against colour: a shadow darkens, it does not tint."""
FAINTEST = 6.0
"""A garment differs from its table by at least this much [CIELAB units]."""
SMALLEST, LARGEST = 0.02, 0.9
"""Part of the photo that a garment covers."""
EDGE = 4
"""A garment nearer than this to the photo's border touches it [pixels]."""
SIMPLER = 0.004
"""The outline may be simplified by this part of the garment's larger extent."""


@dataclass(frozen=True)
class Photo:
    """A photo and the outline found on it."""

    pixels: np.ndarray
    """8-bit RGB, shape (h, w, 3)."""
    outline: np.ndarray
    """Closed curve, without the closing point [pixels], x to the right, y down, shape (k, 2)."""


def find_outline(path: Path) -> Photo:
    """Read a photo and find the garment on it.

    Raises:
        InputError: scikit-image is missing, the file is not a picture, or no garment stands out from a plain table.
    """
    if find_spec("skimage") is None:
        raise InputError("photos need the package scikit-image, which is not installed: pip install 'tatamu[photo]'")
    pixels = _read(path)
    reduced = max(1, int(np.ceil(max(pixels.shape[:2]) / LONGEST)))
    away = _difference(_blocks(pixels, reduced))
    mask = _garment(away, path)
    outline = (_contour(mask) + 0.5) * reduced - 0.5
    extent = float(np.ptp(outline, axis=0).max())
    simple = shapely.Polygon(outline).simplify(SIMPLER * extent).exterior.coords[:-1]
    return Photo(pixels, np.array(simple))


def _read(path: Path) -> np.ndarray:
    from PIL import Image, ImageOps, UnidentifiedImageError

    try:
        with Image.open(path) as file:
            image = ImageOps.exif_transpose(file)
            if image.mode.startswith("I"):  # 16 bits of grey, which `convert` would cut off at 255
                image = Image.fromarray((np.asarray(image) >> 8).astype(np.uint8))
            return np.asarray(image.convert("RGB"))
    except UnidentifiedImageError:
        hint = "; save it as JPEG or PNG" if path.suffix.lower() in (".heic", ".heif") else ""
        raise InputError(f"{path}: is not a picture that can be read here{hint}") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    except (SyntaxError, Image.DecompressionBombError) as error:  # a broken file, one too large
        raise InputError(f"{path}: cannot be read ({error})") from None


def _blocks(pixels: np.ndarray, size: int) -> np.ndarray:
    """Means of blocks of size x size pixels, 0 to 1, shape (h, w, 3)."""
    height, width = (side // size for side in pixels.shape[:2])
    blocks = pixels[: height * size, : width * size].reshape(height, size, width, size, 3)
    return blocks.mean(axis=(1, 3)) / 255.0


def _difference(image: np.ndarray) -> np.ndarray:
    """How much each pixel differs from the table [CIELAB units], shape (h, w)."""
    from scipy.ndimage import gaussian_filter
    from skimage.color import rgb2lab

    lab = gaussian_filter(rgb2lab(image), (1.2, 1.2, 0)) * [LIGHTNESS, 1.0, 1.0]
    height, width = lab.shape[:2]
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    frame = (np.abs(x) > 1 - 2 * FRAME) | (np.abs(y) > 1 - 2 * FRAME)
    known = terms[frame]
    wanted = lab[frame]
    weight = np.ones(len(known))
    for _ in range(5):  # reweighted: a ruler or a shadow on the frame counts little
        root = np.sqrt(weight)[:, None]
        fit = np.linalg.lstsq(known * root, wanted * root, rcond=None)[0]
        off = np.linalg.norm(wanted - known @ fit, axis=1)
        weight = 1.0 / (1.0 + (off / (2.0 * np.median(off) + 1e-6)) ** 2)
    return np.asarray(np.linalg.norm(lab - terms @ fit, axis=-1))


def _garment(away: np.ndarray, path: Path) -> np.ndarray:
    """The largest region that stands out, its holes filled, shape (h, w)."""
    from scipy.ndimage import binary_closing, binary_fill_holes, binary_opening
    from skimage.filters import threshold_otsu
    from skimage.measure import label

    threshold = max(float(threshold_otsu(away)), 0.5 * FAINTEST)
    spot = np.hypot(*np.mgrid[-2:3, -2:3]) <= 2.3
    mask = binary_opening(binary_closing(away > threshold, spot), spot)
    regions = label(mask)
    sizes = np.bincount(regions.ravel())[1:]
    if not len(sizes) or not SMALLEST < sizes.max() / mask.size < LARGEST or np.median(away[mask]) < FAINTEST:
        raise InputError(
            f"{path}: photo: no garment stands out from a plain table; give more contrast or crop the photo"
        )
    garment = np.asarray(binary_fill_holes(regions == 1 + int(sizes.argmax())))
    if garment.sum() > garment[EDGE:-EDGE, EDGE:-EDGE].sum():
        raise InputError(f"{path}: photo: must show table all around the garment, which touches the photo's border")
    return garment


def _contour(mask: np.ndarray) -> np.ndarray:
    """The border of a region, between the pixels, x and y, shape (k, 2)."""
    from scipy.ndimage import gaussian_filter
    from skimage.measure import find_contours

    longest = max(find_contours(gaussian_filter(mask.astype(float), 1.0), 0.5), key=len)
    return np.asarray(longest[:-1, ::-1])


def homography(corners: np.ndarray, width: float, height: float) -> np.ndarray:
    """The matrix from pixels to metres, shape (3, 3), that makes four corners a rectangle.

    Args:
        corners: Top left, top right, bottom right, bottom left [pixels], shape (4, 2).
        width: Of the rectangle [m].
        height: Of the rectangle [m].

    Raises:
        InputError: The corners come in another order, or lie on a line.
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
    """An outline [pixels] on the table [m], shape (k, 2)."""
    moved = np.column_stack([outline, np.ones(len(outline))]) @ matrix.T
    return np.asarray(moved[:, :2] / moved[:, 2:])


def outline_svg(outline: np.ndarray) -> str:
    """An SVG file in millimetres of an outline [m], x to the right, y down, shape (k, 2)."""
    points = 1e3 * (outline - outline.min(axis=0))
    width, height = points.max(axis=0)
    corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.1f}mm" height="{height:.1f}mm" '
        f'viewBox="0 0 {width:.1f} {height:.1f}">\n'
        f'<polygon id="outline" points="{corners}" fill="#dfe6f4" stroke="#2b3f74"/>\n</svg>\n'
    )
