"""Reads a photograph, finds its scale and its camera, and finds the outline of the cloth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import shapely
from scipy.ndimage import gaussian_filter1d

from tatamu.base.errors import InputError
from tatamu.cameras import opencv
from tatamu.cameras.board import Board, load_board
from tatamu.cameras.camera import Seen, View, estimate
from tatamu.cameras.edges import Edges, curve_normals, step_edges
from tatamu.cameras.lens import Lens, possible_lenses, stated_focal
from tatamu.cameras.markers import find_pages
from tatamu.cameras.sheet import SHEETS, Sheet, find_sheet
from tatamu.garments.outline import even
from tatamu.garments.photo import blocks, contour, reduction, stand_out
from tatamu.garments.picture import Picture, read_picture

Scale = Board | Sheet
"""What gives a photograph its scale."""


def load_scale(name: Path | str) -> Scale:
    """Return the plain sheet of this name, or the board of this file."""
    return SHEETS[str(name)] if str(name) in SHEETS else load_board(Path(name))


@dataclass(frozen=True)
class Photograph:
    """A photograph whose camera is known."""

    path: Path
    picture: Picture
    view: View
    papers: tuple[np.ndarray, ...]
    """Corners of each sheet of paper in the photograph, in the board's frame [m], shape (4, 2) each."""
    scale: Scale

    @property
    def pixels(self) -> np.ndarray:
        """Pixels of the photograph as 8-bit RGB, shape (h, w, 3)."""
        return self.picture.pixels

    def in_pixels(self, table: np.ndarray, height: float = 0.0) -> np.ndarray:
        """Return the pixels of positions on the table at a height [m], shape (n, 2) each."""
        return self.view.camera.project(np.column_stack([table, np.full(len(table), height)]))

    def resolution(self, table: np.ndarray) -> float:
        """Return the length on the table that a pixel shows [m], near the middle of the given positions (n, 2)."""
        middle = table.mean(axis=0)
        around = self.in_pixels(middle + 0.01 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1]]))
        lengths = np.linalg.norm(around[[0, 2]] - around[[1, 3]], axis=1)
        return float(0.02 / lengths.min())


def read_photograph(path: Path, scale: Scale, lens: Lens | None = None) -> Photograph:
    """Read a photograph and find its camera from the board or sheet that it shows."""
    picture = read_picture(path)
    tall, wide = picture.pixels.shape[:2]
    least = 400
    if min(tall, wide) < least:
        raise InputError(f"{path}: photo: must have at least {least} pixels on each side, given {wide} x {tall}")
    focal = stated_focal(picture.film, (wide, tall))
    try:
        _check_focal(lens, focal, (wide, tall))
        known = [None] if lens is None else possible_lenses(lens, (wide, tall), picture.orientation)
        views = [_view(picture.pixels, scale, each, focal) for each in known]
        view = min(views, key=lambda each: each.penalty)
        papers = tuple(pose.place(scale.rim) for pose in view.pages) if isinstance(scale, Board) else (scale.corners,)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    return Photograph(path, picture, view, papers, scale)


def without_lens(photograph: Photograph) -> Photograph:
    """Return the photograph with a camera that is found without the lens file."""
    size = photograph.pixels.shape[1::-1]
    focal = stated_focal(photograph.picture.film, size)
    return replace(photograph, view=_view(photograph.pixels, photograph.scale, None, focal))


def _check_focal(lens: Lens | None, focal: float | None, size: tuple[int, int]) -> None:
    """Refuse a lens whose focal length is far from the one that a photo's file states [pixels]."""
    if lens is None or focal is None:
        return
    own = lens.focal * max(size) / max(lens.width, lens.height)
    if not 1.0 / 1.25 < own / focal < 1.25:
        raise InputError(
            f"lens: must have about the focal length that the photo states ({focal:.0f} pixels), given {own:.0f}; "
            "leave --lens out, or give the lens file of this camera and zoom"
        )


def _view(pixels: np.ndarray, scale: Scale, lens: Lens | None, focal: float | None) -> View:
    """Find the camera from the board or the sheet that a photograph shows."""
    if isinstance(scale, Board):
        return estimate(find_pages(_grey(pixels), scale), (pixels.shape[1], pixels.shape[0]), lens, focal)
    return find_sheet(pixels, scale, lens, focal)


def find_cloth(photograph: Photograph, join: bool = False) -> Edges:
    """Find the outline of the cloth in a photograph [pixels], clockwise on the screen.

    Raises:
        InputError: If no cloth differs from the table, it is cut off, or the photograph is blurred.
    """
    pixels = photograph.pixels
    reduced = reduction(pixels)
    image = blocks(pixels, reduced)
    ignored = _drawn(photograph, reduced, image.shape[:2])
    share, _ = stand_out(image, photograph.path, join, np.empty((0, 2)), ignored)
    curve = contour(share, reduced)
    curve = curve if shapely.is_ccw(shapely.LinearRing(curve)) else curve[::-1]
    curve = even(np.vstack([curve, curve[:1]]), 2.0 * reduced, 8)[:-1]
    across = curve_normals(gaussian_filter1d(curve, 2.0, axis=0, mode="wrap"))
    edges = step_edges(pixels, curve, across, 2.5 * reduced + 3.0)
    wide = float(np.median(edges.width[edges.found])) if edges.found.any() else 0.0
    width = wide * photograph.resolution(photograph.view.camera.on_table(edges.points))
    # JPEG alone blurs colours over 4 pixels
    if width > 0.006 and wide > 10.0:
        most = f"must be sharp to within 6 mm at the edges of the cloth, given {1e3 * width:.0f} mm"
        raise InputError(f"{photograph.path}: photo: {most}; focus the camera on the cloth")
    return edges


def _grey(pixels: np.ndarray) -> np.ndarray:
    cv2 = opencv()
    return np.asarray(cv2.cvtColor(np.ascontiguousarray(pixels), cv2.COLOR_RGB2GRAY))


def _drawn(photograph: Photograph, reduced: int, shape: tuple[int, int]) -> np.ndarray:
    """Return whether each pixel of a reduced copy of the photograph, shape (h, w), shows a sheet of paper."""
    covered = np.zeros(shape, dtype=np.uint8)
    for corners in photograph.papers:
        middle = corners.mean(axis=0)
        out = corners + 0.004 * np.sign(corners - middle)
        pixels = (photograph.in_pixels(out) + 0.5) / reduced - 0.5
        opencv().fillPoly(covered, [np.round(pixels).astype(np.int32)], 1)
    return covered.astype(bool)


def board_corners(photos: Sequence[Path], board: Board) -> tuple[list[Seen], tuple[int, int]]:
    """Return the corners of a board's first page in several photos, and the common size of the photos [pixels].

    The pixels are those of the sensor, because a lens does not turn with the orientation tag of a photo.
    """
    seen: list[Seen] = []
    sizes: dict[tuple[int, int], Path] = {}
    for path in photos:
        pixels = read_picture(path).sensor
        sizes.setdefault((pixels.shape[1], pixels.shape[0]), path)
        if len(sizes) > 1:
            first, other = (f"{wide} x {tall}" for wide, tall in sizes)
            raise InputError(f"{path}: photo: must have {first} pixels like the other photos, given {other}")
        try:
            seen.append(find_pages(_grey(pixels), board)[0])
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
    if not sizes:
        raise InputError("photos: must contain at least one photo, given none")
    return seen, next(iter(sizes))
