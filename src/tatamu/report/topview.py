"""Draws the cloth from above, as in Fig. 5 of the paper: the target, the learned fold, and both in one picture."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup
from scipy.ndimage import binary_dilation

from tatamu.show.drawing import Drawing
from tatamu.show.image import data_uri
from tatamu.show.palette import TARGET, rgb
from tatamu.show.raster import View, rasterise
from tatamu.show.replay import HAND_COLOURS
from tatamu.show.shading import PaintedMesh, cloth, occlusion, see, shade, shrink, to_pixels
from tatamu.show.shapes import Dot, Picture
from tatamu.simulation.side_by_side import processors
from tatamu.study.result import Result

WIDE = 600
"""Usual width of the images that are stored in the page [pixels]."""
FINER = 2
"""Factor by which images are first drawn larger. Then they are reduced by averaging, which makes outlines smooth."""


@dataclass(frozen=True)
class Extent:
    """The rectangular part of the table that pictures show."""

    low: np.ndarray
    """Smallest x and y [m], shape (2,)."""
    high: np.ndarray
    """Largest x and y [m], shape (2,)."""
    wide: int
    """Width of its images in the file [pixels]."""

    @property
    def size(self) -> np.ndarray:
        """Width and height [m], shape (2,)."""
        return self.high - self.low

    def view(self, width: int) -> View:
        """Return the view of this part of the table from straight above, with x to the right.

        The picture is `width` pixels wide.
        """
        scale = width / self.size[0]
        centre = np.append((self.low + self.high) / 2, 0.0)
        return View(centre, np.eye(3), scale, (round(self.size[1] * scale), width))


def extent(*shapes: np.ndarray, margin: float = 0.03, wide: int | None = None) -> Extent:
    """Return the rectangle of the table around several shapes of cloth, with a margin [m].

    A shape has n points, shape (n, 3). Images of the rectangle are `wide` pixels wide, or `WIDE`.
    """
    points = np.vstack(shapes)[:, :2]
    return Extent(points.min(axis=0) - margin, points.max(axis=0) + margin, wide or WIDE)


def painted(fold: Result, points: np.ndarray) -> PaintedMesh:
    """Return the mesh of a fold's cloth at the positions `points` [m], shape (n, 3)."""
    return cloth(points, fold.faces, fold.start, fold.lower)


def draw(mesh: PaintedMesh, area: Extent) -> tuple[np.ndarray, np.ndarray]:
    """Draw cloth from above, `FINER` times larger than the final picture.

    The result is an image in linear light, shape (h, w, 4), and the mask of the cloth, shape (h, w).
    """
    view = area.view(area.wide * FINER)
    visible, depth = see(view, mesh)
    image = np.zeros((*view.shape, 4))
    lower = occlusion(depth, float(mesh.points[:, 2].min()), 0.004 * view.scale, 0.002)
    image[..., 3] = 0.35 * lower
    image[visible.mask, :3] = shade(view, mesh, visible) * (1.0 - 0.55 * lower[visible.mask])[:, None]
    image[visible.mask, 3] = 1.0
    return image, visible.mask


def mask(mesh: PaintedMesh, area: Extent) -> np.ndarray:
    """Return the mask of those pixels that cloth covers as seen from above, shape (h, w).

    The mask has the size of the image that `draw` returns.
    """
    view = area.view(area.wide * FINER)
    return rasterise(view.project(mesh.points), mesh.faces, view.shape).mask


def outlined(image: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """Return an image with the border of a mask drawn over it.

    The line covers three pixels on each side of the border.
    """
    border = binary_dilation(mask, iterations=3) & binary_dilation(~mask, iterations=3)
    copy = image.copy()
    copy[border, :3] = rgb(TARGET)
    copy[border, 3] = 1.0
    return copy


@dataclass(frozen=True)
class TopView:
    """A picture of cloth from above with its title."""

    title: str
    note: str
    """Short text after the title."""
    svg: Markup


def beside(fold: Result, goal: np.ndarray, name: str = "Learned fold") -> list[TopView]:
    """Return three pictures from above: the target `goal`, the final shape of the cloth, and both in one picture.

    The picture of the final shape has the title `name`.
    """
    area = extent(goal, fold.final)
    (target, wanted), (final, _) = drawn(fold, (goal, fold.final), area)
    return [
        view("Target", "the target shape", target, area),
        view(name, "the cloth at rest", final, area, paths(fold)),
        view("Both", "the fold with the target’s outline", outlined(final, wanted), area),
    ]


def failures(fold: Result) -> list[TopView]:
    """Return a picture from above for each cause of failure that was simulated, with the target's outline."""
    shown = fold.failures
    area = extent(fold.target, *shown.values())
    wanted = mask(painted(fold, fold.target), area)
    images = drawn(fold, shown.values(), area)
    return [view(cause, "", outlined(image, wanted), area) for cause, (image, _) in zip(shown, images, strict=True)]


def drawn(fold: Result, shapes: Iterable[np.ndarray], area: Extent) -> list[tuple[np.ndarray, np.ndarray]]:
    """Draw several shapes of a fold's cloth side by side, because each takes half a second."""
    with ThreadPoolExecutor(processors()) as threads:
        return list(threads.map(lambda points: draw(painted(fold, points), area), shapes))


def paths(fold: Result) -> list[np.ndarray]:
    """Return the positions of each hand in all f frames [m]: an array of shape (f, 3) for each hand."""
    return [fold.hand(arm) for arm in fold.arms]


def view(title: str, note: str, image: np.ndarray, area: Extent, hands: Sequence[np.ndarray] = ()) -> TopView:
    """Return a picture with a title, a ruler and the hands' paths.

    A path has the shape (f, 3) for f frames [m].
    """
    drawing = Drawing(area.low, area.high, 1000.0, background=None, words=f"{title}, from above")
    drawing.add(Picture(data_uri(to_pixels(shrink(image, FINER)))))
    for colour, path in zip(HAND_COLOURS, hands, strict=False):
        drawing.line(path[:, :2], colour, 3.5)
        drawing.add(Dot(path[-1, :2], colour, 5.0))
    drawing.ruler([area.high[0] - 0.012, area.low[1] + 0.010])
    return TopView(title, note, Markup(drawing.svg()))
