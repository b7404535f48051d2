"""Finds the rotation that lays the mesh of a garment on its back.

The garment is thinnest from front to back, and symmetric across its width. The hem is the end with the longest opening
in the middle, or, for trousers, the end with two openings beside the middle. The side with the lower neckline is the
front. If the shape is ambiguous, usual axes of files are assumed: of a mesh that is thinnest along y, z points up and
the front faces -y; of others, y points up and the front faces +z.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from tatamu.base.curves import length
from tatamu.base.errors import InputError
from tatamu.garments.meshfile import border_loops
from tatamu.garments.units import direction
from tatamu.simulation.mesh.topology import areas

ALIGNED = np.cos(np.radians(30.0))
"""Cosine of the angle from an axis of the file below which the axis is used instead of a direction of the mesh, which
is less exact."""


@dataclass(frozen=True)
class Posture:
    """The rotation from a file's frame to that of a garment on its back."""

    turn: np.ndarray
    """Rotation matrix, shape (3, 3)."""
    up: str
    """Direction in the file away from the hem."""
    front: str
    """Direction in the file out of the front."""

    @property
    def words(self) -> str:
        return f"the axis from hem to top is {self.up} in the file, and the front faces {self.front}"


def posture(vertices: np.ndarray, faces: np.ndarray, up: str | None = None) -> Posture:
    """Return the rotation with which a mesh lies on its back with its hem at -x.

    Args:
        vertices: Positions in the file's frame, shape (n, 3).
        faces: Triangles of consistent orientation, shape (m, 3).
        up: Axis of the file that points away from the hem, if the user gave it.
    """
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    points = vertices - middle
    loops: list[np.ndarray] = []
    with suppress(InputError):  # a border that is no loop is reported later, if it matters
        loops = [points[loop] for loop in border_loops(faces)]
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


def _thinnest(points: np.ndarray, faces: np.ndarray, across: np.ndarray | None = None) -> np.ndarray:
    """Return the direction, perpendicular to `across`, in which a mesh is thinnest, or a close axis of the file."""
    area = areas(points, faces)
    centres = points[faces].mean(axis=1)
    away = centres - np.average(centres, axis=0, weights=area)
    spread = (away * area[:, None]).T @ away / area.sum()
    if across is not None:
        spread = spread + 1e6 * np.trace(spread) * np.outer(across, across)
    return _snapped(np.linalg.eigh(spread)[1][:, 0])


def _snapped(way: np.ndarray) -> np.ndarray:
    """Return the axis of the file close to a direction, or the direction itself, with a positive largest component."""
    largest = int(np.abs(way).argmax())
    way = way * np.sign(way[largest])
    return np.eye(3)[largest] if way[largest] > ALIGNED else way


def _length(points: np.ndarray, through: np.ndarray) -> np.ndarray:
    """Return the direction along a garment, perpendicular to the width, across which the garment is symmetric."""
    usual = np.array([0.0, 0.0, 1.0]) if abs(through[1]) > ALIGNED else np.array([0.0, 1.0, 0.0])
    along = usual - (usual @ through) * through
    along /= np.linalg.norm(along)
    # perpendicular to `through`, the directions with the largest and the smallest spread
    spread = np.linalg.eigh(np.cov((points - np.outer(points @ through, through)).T))[1]
    axes = [along, np.cross(through, along), spread[:, 2], spread[:, 1]]
    misfit = [_asymmetry(points, np.cross(through, axis)) for axis in axes]
    best = int(np.argmin(misfit))
    if misfit[0] <= misfit[best] / 0.6:
        return along  # the usual axis in files
    return axes[best] * (1.0 if axes[best] @ along > -1e-9 else -1.0)


def _asymmetry(points: np.ndarray, axis: np.ndarray) -> float:
    """Return the mean distance from each point's mirror image along `axis` to the nearest point."""
    heights = points @ axis
    image = points - 2.0 * np.outer(heights - 0.5 * (heights.min() + heights.max()), axis)
    return float(cKDTree(points).query(image)[0].mean())


def _sense(ahead: np.ndarray, aside: np.ndarray, points: np.ndarray, loops: list[np.ndarray]) -> float:
    """Return 1 if `ahead` points away from the hem, otherwise -1."""
    wide, long = (float(np.ptp(points @ axis)) for axis in (aside, ahead))
    central = [loop for loop in loops if abs(float((loop @ aside).mean())) < 0.12 * wide]
    outer = [loop for loop in loops if not any(loop is other for other in central)]
    heights = [float((loop @ ahead).mean()) for loop in central]
    if len(central) >= 2:
        around = [length(np.vstack([loop, loop[:1]])) for loop in central]
        hem = int(np.argmax(around))
        if around[hem] < 1.1 * sorted(around)[-2]:
            return 1.0
        difference = max(heights[:hem] + heights[hem + 1 :], key=lambda h: abs(h - heights[hem])) - heights[hem]
    elif len(central) == 1 and len(outer) >= 2:
        difference = heights[0] - float(np.mean([(loop @ ahead).mean() for loop in outer]))
    else:
        return 1.0
    return -1.0 if difference < -0.1 * long else 1.0


def _forward(ahead: np.ndarray, through: np.ndarray, points: np.ndarray, loops: list[np.ndarray]) -> float:
    """Return 1 if `through` points out of the garment's front, otherwise -1."""
    usual = 1.0 if through[int(np.abs(through).argmax())] > 0.0 and abs(through[1]) < ALIGNED else -1.0
    if not loops:
        return usual
    neck = max(loops, key=lambda loop: float((loop @ ahead).mean()))
    depth, height = neck @ through, neck @ ahead
    depth = depth - depth.mean()
    spread = float(depth @ depth)
    fall = -float(depth @ (height - height.mean())) / spread * float(np.ptp(depth)) if spread > 0.0 else 0.0
    return float(np.sign(fall)) if abs(fall) > 0.08 * float(np.ptp(points @ ahead)) else usual


def _axis(way: np.ndarray) -> str:
    largest = int(np.abs(way).argmax())
    sign = "-" if way[largest] < 0.0 else ""
    exact = abs(way[largest]) > 0.999
    return f"{sign}{'xyz'[largest]}" if exact else "({:.2f}, {:.2f}, {:.2f})".format(*way)
