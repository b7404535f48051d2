"""The cloth from above, as in Fig. 5 of the paper: target, learned fold, and one on the other."""

from __future__ import annotations

import base64
import html
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_dilation

from tatamu.report import png
from tatamu.report.fold import LearnedFold
from tatamu.report.palette import LEFT, RIGHT, TARGET, rgb
from tatamu.report.raster import View
from tatamu.report.shading import Mesh, cloth, occlusion, see, shade, shrink, to_pixels

WIDE = 720
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


def draw(points: np.ndarray, faces: np.ndarray, area: Extent, outline: np.ndarray | None = None) -> bytes:
    """A PNG of the cloth from above, with the silhouette of another shape (n, 3) drawn over it."""
    view = area.view(WIDE * FINER)
    mesh = cloth(points, faces)
    visible, depth = see(view, mesh)
    image = np.zeros((*view.shape, 4))
    lower = occlusion(depth, float(points[:, 2].min()), 0.004 * view.scale, 0.002)
    image[..., 3] = 0.35 * lower
    image[visible.mask, :3] = shade(view, mesh, visible) * (1.0 - 0.55 * lower[visible.mask])[:, None]
    image[visible.mask, 3] = 1.0
    if outline is not None:
        _stroke(image, see(view, Mesh(outline, faces, mesh.front, mesh.back))[0].mask)
    return png.encode(to_pixels(shrink(image, FINER)))


def _stroke(image: np.ndarray, mask: np.ndarray) -> None:
    """Draw the border of a mask, three fine pixels wide on either side."""
    border = binary_dilation(mask, iterations=3) & ~(~binary_dilation(~mask, iterations=3))
    image[border, :3], image[border, 3] = rgb(TARGET), 1.0


def figures(fold: LearnedFold) -> str:
    """Three pictures side by side, as HTML."""
    area = extent(fold.target, fold.final)
    ways = {arm.name: fold.hand(arm) for arm in fold.manipulation.arms}
    pictures = [
        ("Target", "the wanted shape", draw(fold.target, fold.faces, area), {}),
        ("Learned fold", "where the cloth came to rest", draw(fold.final, fold.faces, area), ways),
        ("Both", "the fold, with the target's outline", draw(fold.final, fold.faces, area, fold.target), {}),
    ]
    return "".join(_figure(title, note, data, area, lines) for title, note, data, lines in pictures)


def _figure(title: str, note: str, data: bytes, area: Extent, ways: dict[str, np.ndarray]) -> str:
    width, height = (1000 * area.size).round(2)
    source = "data:image/png;base64," + base64.b64encode(data).decode()
    return (
        f'<figure><svg viewBox="0 0 {width} {height}" role="img" aria-label="{html.escape(title)}, from above">'
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
