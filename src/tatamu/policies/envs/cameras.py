"""Small pictures of cloth and hands by named cameras, from which a policy learns."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from tatamu.show.palette import BACK, FRONT, LEFT, REAR, RIGHT, TABLE, rgb
from tatamu.show.raster import View
from tatamu.show.shading import PaintedMesh, see, shade, to_pixels
from tatamu.simulation.mesh.topology import facing_down
from tatamu.simulation.mesh.zbuffer import z_buffer

Camera = Literal["top", "front", "left", "right"]
CAMERAS: tuple[Camera, ...] = get_args(Camera)
"""`top` looks straight down, the others from three sides at 45 degrees."""
FROM = {"top": (180.0, 90.0), "front": (180.0, 45.0), "left": (90.0, 45.0), "right": (-90.0, 45.0)}
"""Direction to each camera: angle about z from +x, and above the table [degrees]. The hands start on the side of -x."""
HAND = 0.02
"""Half the length of a hand, which is shown as an octahedron [m]."""
CORNERS = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)
FACES = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4], [1, 0, 5], [2, 1, 5], [3, 2, 5], [0, 3, 5]])


class Studio:
    """Cameras around one garment."""

    def __init__(self, start: np.ndarray, faces: np.ndarray, pixels: int = 96) -> None:
        """Set up the cameras.

        Args:
            start: Positions of the cloth before the fold [m], shape (n, 3).
            faces: Triangles of the cloth, shape (m, 3).
            pixels: Height and width of a picture.
        """
        self.middle = (start.min(axis=0) + start.max(axis=0)) / 2
        self.radius = 1.1 * float(np.linalg.norm(start - self.middle, axis=1).max())
        self.pixels = pixels
        self._start = start
        self._faces = faces
        outside = np.where(facing_down(start, faces)[:, None], rgb(REAR), rgb(FRONT))
        self._colours = [outside, *(np.tile(rgb(colour), (len(FACES), 1)) for colour in (LEFT, RIGHT))]
        self._table = to_pixels(np.append(rgb(TABLE), 1.0)[None, None])[0, 0, :3]

    def picture(self, camera: Camera, points: np.ndarray, hands: np.ndarray | None = None) -> np.ndarray:
        """Return a picture: RGB, uint8, shape (h, w, 3).

        Args:
            camera: Name of the camera.
            points: Positions of the cloth [m], shape (n, 3).
            hands: Positions of the hands [m], shape (k, 3); None to draw none.
        """
        mesh = self._mesh(points, np.empty((0, 3)) if hands is None else hands)
        view = self._view(*np.radians(FROM[camera]))
        visible, _ = see(view, mesh)
        picture = np.broadcast_to(self._table, (*view.shape, 3)).copy()
        light = np.append(shade(view, mesh, visible), np.ones((len(visible.covered[0]), 1)), axis=1)
        picture[visible.mask] = to_pixels(light)[:, :3]
        return picture

    def heights(self, points: np.ndarray) -> np.ndarray:
        """Return the height of the cloth at each pixel of `top` [m], 0 beside it: float32, shape (h, w)."""
        scale = self.pixels / (2.0 * self.radius)
        across = (points[:, :2] - self.middle[:2]) * scale
        grid = np.column_stack([self.pixels / 2 - across, points[:, 2]])  # +x is up, +y to the left
        found = z_buffer(grid, self._faces, (self.pixels, self.pixels)).heights
        return np.where(np.isfinite(found), found, 0.0).astype(np.float32)

    def _mesh(self, points: np.ndarray, hands: np.ndarray) -> PaintedMesh:
        """Return cloth and hands as one mesh."""
        count = len(points)
        faces = [self._faces, *(FACES + count + len(CORNERS) * number for number in range(len(hands)))]
        shapes = [points, *(hand + HAND * CORNERS for hand in hands)]
        unmarked = np.full((len(CORNERS) * len(hands), 2), 0.025)  # between two lines of the grid on the cloth
        return PaintedMesh(
            np.concatenate(shapes),
            np.concatenate(faces),
            np.concatenate(self._colours[: 1 + len(hands)]),
            rgb(BACK),
            np.concatenate([self._start[:, :2], unmarked]),
        )

    def _view(self, turn: float, rise: float) -> View:
        """Return the view from a direction [rad], which shows a ball around the cloth."""
        near = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
        right = np.array([-np.sin(turn), np.cos(turn), 0.0])
        rotation = np.vstack([right, np.cross(near, right), near])
        distance = np.inf if rise == np.radians(90.0) else 3.0 * self.radius
        return View(self.middle, rotation, self.pixels / (2.0 * self.radius), (self.pixels, self.pixels), distance)
