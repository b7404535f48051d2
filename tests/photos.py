"""Photos of flat garments, rendered: uneven light, noise, creases, a shadow, a ruler, and the camera a little askew."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import shapely
from PIL import Image, ImageDraw
from scipy.ndimage import gaussian_filter, map_coordinates

SIZE = (600, 800)
"""Height and width [pixels]."""
SHIRT = np.array(
    [220, 0, 320, 0, 400, 30, 540, 110, 500, 190, 430, 150, 430, 460, 110, 460, 110, 150, 40, 190, 0, 110, 140, 30]
).reshape(-1, 2)
"""A T-shirt [mm], x to the right, y down."""
SCALE = 1.1
"""Pixels per millimetre."""
PLACE = np.array([103.0, 47.0])
"""Where the shirt's corner is [pixels]."""
TILT = np.array([[1.02, 0.03, -12.0], [-0.02, 1.01, 6.0], [2e-5, -4e-5, 1.0]])
"""The camera askew: from pixels straight from above to pixels of the photo."""


def photograph(
    path: Path,
    cloth: tuple[int, int, int],
    table: tuple[int, int, int],
    *,
    seed: int = 0,
    askew: bool = False,
) -> np.ndarray:
    """Render a photo of SHIRT into a file; its true outline [pixels], shape (k, 2)."""
    random = np.random.default_rng(seed)
    truth = SHIRT * SCALE + PLACE
    mask = Image.new("L", (3 * SIZE[1], 3 * SIZE[0]))
    ImageDraw.Draw(mask).polygon([tuple(3 * p) for p in truth], fill=255)
    share = np.asarray(mask.resize(SIZE[::-1], Image.Resampling.BOX))[..., None] / 255.0
    y, x = np.mgrid[-1 : 1 : SIZE[0] * 1j, -1 : 1 : SIZE[1] * 1j]
    creases = gaussian_filter(random.normal(size=SIZE), 12)
    grain = gaussian_filter(random.normal(size=SIZE), (1, 25))
    shadow = gaussian_filter(share[..., 0], 5)
    lying = np.array(table) * (1 + 0.15 * grain / np.abs(grain).max() - 0.10 * np.roll(shadow, 4, 0))[..., None]
    worn = np.array(cloth) * (1 + 0.12 * creases / np.abs(creases).max())[..., None]
    light = 1.0 - 0.18 * x - 0.10 * y + 0.05 * x * y
    picture = (share * worn + (1 - share) * lying) * light[..., None] + random.normal(0, 4, (*SIZE, 3))
    picture[8:20, 300:520] = [250, 240, 120]  # a ruler near the border
    if askew:
        picture, truth = _askew(picture), moved(truth, TILT)
    Image.fromarray(np.clip(picture, 0, 255).astype(np.uint8)).save(path)
    return truth


def moved(points: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    homogeneous = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return np.asarray(homogeneous[:, :2] / homogeneous[:, 2:])


def _askew(picture: np.ndarray) -> np.ndarray:
    y, x = np.mgrid[0 : SIZE[0], 0 : SIZE[1]]
    source = moved(np.column_stack([x.ravel(), y.ravel()]), np.linalg.inv(TILT))
    channels = [map_coordinates(picture[..., k], source.T[::-1], order=1, mode="nearest") for k in range(3)]
    return np.stack(channels, axis=-1).reshape(*SIZE, 3)


def overlap(one: np.ndarray, other: np.ndarray) -> float:
    """Intersection over union of two outlines."""
    a, b = shapely.Polygon(one), shapely.Polygon(other)
    return float(a.intersection(b).area / a.union(b).area)


if __name__ == "__main__":
    photograph(Path(sys.argv[1]), (60, 90, 170), (150, 110, 75), askew=True)
