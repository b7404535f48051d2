"""Finds the rotation that lays the mesh of a garment on its back.

The directions of the garment are found from its shape:

- Front to back: the direction in which the mesh is thinnest.
- Width: the direction, perpendicular to the thinnest direction, in which the garment is symmetric. Mirrored in this
  direction, the garment does not change.
- Hem: the end with the longest opening in the middle of the width. For trousers, which have only one opening in the
  middle, the hem is the end with two openings beside the middle.
- Front: the side with the lower neckline.

If the shape is ambiguous, usual axes of files are assumed. If the mesh is thinnest along y, then z points up and the
front faces -y. Otherwise y points up and the front faces +z.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from tatamu.base.errors import InputError
from tatamu.garments.frame import direction
from tatamu.garments.meshfile import border_loops

ALIGNED = np.cos(np.radians(30.0))
"""Cosine of the limit for the angle between a direction of the garment and a coordinate axis (x, y or z) of its file.

If the angle is below this limit, the axis is used instead of the direction. A direction that is computed from the mesh
is less exact, and garments in files usually lie along the axes.
"""
CLEAR = 0.6
"""Limit for the ratio of two errors of symmetry, with which the direction of a garment's width is chosen.

The first error is for the best direction. The second error, by which the first is divided, is for the direction that is
usual in files.

If the ratio is at least this limit, the best direction is not clear, and the usual direction is used.
"""
MIDDLE = 0.12
"""Largest distance between an opening in the middle of a garment and the middle plane, as a fraction of the width."""
LONGER = 1.1
"""Least ratio of the hem's length to the length of every other opening in the middle of a garment."""
TILTED = 0.08
"""Least height difference between the front and the back of a neckline, as a fraction of the garment's length.

If the difference is smaller, the neckline does not show which side is the front.
"""


@dataclass(frozen=True)
class Posture:
    """A rotation from a file's frame to the frame of a garment that lies on its back."""

    turn: np.ndarray
    """Rotation matrix, shape (3, 3)."""
    up: str
    """Direction in the file that points away from the hem, as text."""
    front: str
    """Direction in the file that points out of the garment's front, as text."""

    @property
    def words(self) -> str:
        """Directions in the file of the garment's hem and front, in a few words."""
        return f"up from its hem is {self.up} of the file, its front faces {self.front}"


def posture(vertices: np.ndarray, faces: np.ndarray, up: str | None = None) -> Posture:
    """Return the rotation with which a mesh lies on its back with its hem at -x.

    Args:
        vertices: Positions in the file's frame, shape (n, 3).
        faces: Triangles of consistent orientation, shape (m, 3).
        up: Axis of the file that points away from the hem, if the user gave it; None to find it from the shape.
    """
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    points = vertices - middle
    loops = _openings(points, faces)
    if up is not None:
        ahead = direction(up)
        through = _thinnest(points, faces, ahead)
    else:
        through = _thinnest(points, faces)
        ahead = _length(points, through)
        ahead = ahead * _sense(ahead, np.cross(through, ahead), points, loops)
    front = through * _forward(ahead, through, points, loops)
    turn = np.array([ahead, np.cross(front, ahead), front])
    return Posture(turn, _axis(ahead), _axis(front))


def _openings(points: np.ndarray, faces: np.ndarray) -> list[np.ndarray]:
    try:
        return [points[loop] for loop in border_loops(faces)]
    except InputError:  # a border that is no loop is reported later, if it matters
        return []


def _thinnest(points: np.ndarray, faces: np.ndarray, across: np.ndarray | None = None) -> np.ndarray:
    """Return the direction, perpendicular to `across`, in which a garment's mesh is thinnest.

    If this direction is near an axis of the file, the axis is returned.
    """
    corners = points[faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    centres = corners.mean(axis=1)
    away = centres - np.average(centres, axis=0, weights=area)
    spread = (away * area[:, None]).T @ away / area.sum()
    if across is not None:
        spread = spread + 1e6 * np.trace(spread) * np.outer(across, across)
    return _snapped(np.linalg.eigh(spread)[1][:, 0])


def _snapped(way: np.ndarray) -> np.ndarray:
    """Return the axis of the file that is near the direction `way`, or `way` itself if no axis is near.

    The sign of the direction is chosen so that its largest component is positive.
    """
    largest = int(np.abs(way).argmax())
    way = way * np.sign(way[largest])
    return np.eye(3)[largest] if way[largest] > ALIGNED else way


def _length(points: np.ndarray, through: np.ndarray) -> np.ndarray:
    """Return the direction along a garment, which is perpendicular to its width.

    The width is the direction in which the garment is symmetric: mirrored in this direction, it does not change.
    """
    usual = np.array([0.0, 0.0, 1.0]) if abs(through[1]) > ALIGNED else np.array([0.0, 1.0, 0.0])
    along = usual - (usual @ through) * through
    along /= np.linalg.norm(along)
    axes = [along, np.cross(through, along), *_principal(points, through)]
    misfit = [_asymmetry(points, np.cross(through, axis)) for axis in axes]
    best = int(np.argmin(misfit))
    if misfit[0] <= misfit[best] / CLEAR:
        return along  # the usual axis in files
    return axes[best] * (1.0 if axes[best] @ along > -1e-9 else -1.0)


def _principal(points: np.ndarray, through: np.ndarray) -> list[np.ndarray]:
    """Return the directions in which points have the largest and the smallest spread.

    Both directions are perpendicular to `through`.
    """
    inside = points - np.outer(points @ through, through)
    axes = np.linalg.eigh(np.cov(inside.T))[1]
    return [axes[:, 2], axes[:, 1]]


def _asymmetry(points: np.ndarray, axis: np.ndarray) -> float:
    """Return how much points differ from their mirror images along `axis`.

    The result is the mean distance from each mirror image to the nearest point.
    """
    heights = points @ axis
    image = points - 2.0 * np.outer(heights - 0.5 * (heights.min() + heights.max()), axis)
    return float(cKDTree(points).query(image)[0].mean())


def _sense(ahead: np.ndarray, aside: np.ndarray, points: np.ndarray, loops: list[np.ndarray]) -> float:
    """Return 1 if the direction `ahead` points from the hem to the other end of the garment, otherwise -1."""
    width, length = (float(np.ptp(points @ axis)) for axis in (aside, ahead))
    central = [loop for loop in loops if abs(float((loop @ aside).mean())) < MIDDLE * width]
    outer = [loop for loop in loops if not any(loop is other for other in central)]
    heights = [float((loop @ ahead).mean()) for loop in central]
    if len(central) >= 2:
        around = [_around(loop) for loop in central]
        hem = int(np.argmax(around))
        if around[hem] < LONGER * sorted(around)[-2]:
            return 1.0
        difference = max(heights[:hem] + heights[hem + 1 :], key=lambda h: abs(h - heights[hem])) - heights[hem]
    elif len(central) == 1 and len(outer) >= 2:
        difference = heights[0] - float(np.mean([(loop @ ahead).mean() for loop in outer]))
    else:
        return 1.0
    return -1.0 if difference < -0.1 * length else 1.0


def _around(loop: np.ndarray) -> float:
    closed = np.vstack([loop, loop[:1]])
    return float(sum(np.linalg.norm(b - a) for a, b in pairwise(closed)))


def _forward(ahead: np.ndarray, through: np.ndarray, points: np.ndarray, loops: list[np.ndarray]) -> float:
    """Return 1 if the direction `through` points out of the garment's front, and -1 if it points out of its back."""
    usual = 1.0 if through[int(np.abs(through).argmax())] > 0.0 and abs(through[1]) < ALIGNED else -1.0
    if not loops:
        return usual
    neck = max(loops, key=lambda loop: float((loop @ ahead).mean()))
    depth, height = neck @ through, neck @ ahead
    depth = depth - depth.mean()
    spread = float(depth @ depth)
    fall = -float(depth @ (height - height.mean())) / spread * float(np.ptp(depth)) if spread > 0.0 else 0.0
    return float(np.sign(fall)) if abs(fall) > TILTED * float(np.ptp(points @ ahead)) else usual


def _axis(way: np.ndarray) -> str:
    largest = int(np.abs(way).argmax())
    sign = "-" if way[largest] < 0.0 else ""
    exact = abs(way[largest]) > 0.999
    return f"{sign}{'xyz'[largest]}" if exact else "({:.2f}, {:.2f}, {:.2f})".format(*way)
