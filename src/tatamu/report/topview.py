"""The cloth from above, as in Fig. 5 of the paper: target, learned fold, and one on the other."""

from __future__ import annotations

import base64
import html
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation

from tatamu.report import png
from tatamu.report.palette import LEFT, RIGHT, TARGET, rgb
from tatamu.report.raster import View
from tatamu.report.shading import cloth, occlusion, see, shade, shrink, to_pixels
from tatamu.results import LearnedFold

WIDE = 600
"""Width of the images [pixels], before the screen scales them."""
FINER = 2
"""The images are drawn this much larger and averaged, for smooth outlines."""


@dataclass(frozen=True)
class Extent:
    """The rectangle of the table that the pictures show."""

    low: np.ndarray
    """Smallest x, y [m], shape (2,)."""
    high: np.ndarray
    """Largest x, y [m], shape (2,)."""

    @property
    def size(self) -> np.ndarray:
        """Width and height [m], shape (2,)."""
        return self.high - self.low

    def view(self, width: int) -> View:
        """From straight above, x to the right, `width` pixels wide."""
        scale = width / self.size[0]
        centre = np.append((self.low + self.high) / 2, 0.0)
        return View(centre, np.eye(3), scale, (round(self.size[1] * scale), width))


def extent(*shapes: np.ndarray, margin: float = 0.03) -> Extent:
    """The rectangle around shapes (n, 3), with a margin [m]."""
    points = np.vstack(shapes)[:, :2]
    return Extent(points.min(axis=0) - margin, points.max(axis=0) + margin)


def draw(fold: LearnedFold, points: np.ndarray, area: Extent) -> tuple[np.ndarray, np.ndarray]:
    """The cloth (n, 3) from above, FINER than it will be: linear light (h, w, 4), and where it is (h, w)."""
    view = area.view(WIDE * FINER)
    mesh = cloth(points, fold.faces, fold.start)
    visible, depth = see(view, mesh)
    image = np.zeros((*view.shape, 4))
    lower = occlusion(depth, float(points[:, 2].min()), 0.004 * view.scale, 0.002)
    image[..., 3] = 0.35 * lower
    image[visible.mask, :3] = shade(view, mesh, visible) * (1.0 - 0.55 * lower[visible.mask])[:, None]
    image[visible.mask, 3] = 1.0
    return image, visible.mask


def outlined(image: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """A copy of an image with the border of a mask drawn over it, three fine pixels to either side."""
    border = binary_dilation(mask, iterations=3) & binary_dilation(~mask, iterations=3)
    copy = image.copy()
    copy[border, :3], copy[border, 3] = rgb(TARGET), 1.0
    return copy


def figures(fold: LearnedFold) -> str:
    """Three pictures side by side, as HTML."""
    return beside(fold, fold.target)


def beside(fold: LearnedFold, goal: np.ndarray, name: str = "Learned fold") -> str:
    """A goal (n, 3), where the cloth came to rest under a name, and one on the other."""
    area = extent(goal, fold.final)
    ways = {arm.name: fold.hand(arm) for arm in fold.manipulation.arms}
    target, wanted = draw(fold, goal, area)
    final, _ = draw(fold, fold.final, area)
    pictures: list[tuple[str, str, np.ndarray, dict[str, np.ndarray]]] = [
        ("Target", "the wanted shape", target, {}),
        (name, "where the cloth came to rest", final, ways),
        ("Both", "the fold with the target’s outline", outlined(final, wanted), {}),
    ]
    return "".join(figure(title, note, image, area, lines) for title, note, image, lines in pictures)


def figure(title: str, note: str, image: np.ndarray, area: Extent, ways: dict[str, np.ndarray]) -> str:
    """One picture with its title, a ruler and the hands' paths (f, 3), as HTML."""
    data = png.encode(to_pixels(shrink(image, FINER)))
    width, height = (1000 * area.size).round(2)
    source = "data:image/png;base64," + base64.b64encode(data).decode()
    label = html.escape(f"{title}, from above")
    return (
        f'<figure><svg viewBox="0 0 {width} {height}" role="img" aria-label="{label}">'
        f'<image href="{source}" width="{width}" height="{height}"/>'
        f"{_ways(ways, area)}{_ruler(width, height)}</svg>"
        f"<figcaption><b>{html.escape(title)}</b> {html.escape(note)}</figcaption></figure>"
    )


def _ways(ways: dict[str, np.ndarray], area: Extent) -> str:
    """The hands' paths from above, clipped by the picture."""
    drawn = []
    for colour, way in zip((LEFT, RIGHT), ways.values(), strict=False):
        corner = np.array([area.low[0], area.high[1]])
        points = (way[:, :2] - corner) * [1000, -1000]
        text = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        x, y = points[-1]
        drawn.append(f'<polyline points="{text}" class="way" stroke="{colour}"/>')
        drawn.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5" fill="{colour}"/>')
    return "".join(drawn)


def _ruler(width: float, height: float) -> str:
    """A bar of 10 cm in the corner (the drawing's unit is a millimetre)."""
    x, y = width - 112, height - 10
    return (
        f'<path class="ruler" d="M{x:.1f} {y - 4:.1f}v4h100v-4"/>'
        f'<text class="ruler" x="{x + 50:.1f}" y="{y - 6:.1f}">10 cm</text>'
    )
