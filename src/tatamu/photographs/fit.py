"""Fit of a garment's outline to one that was found: its position, its angle and its scales.

The parameters x, y, yaw and the scales along and across minimise the distances from the found points to the outline.
Small distances count as squares. Large ones, such as those of a corner that is turned in, count less.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import shapely
from scipy.optimize import least_squares

from tatamu.photographs.pose import Pose, wrapped
from tatamu.photographs.shape import Shape

TOLERANCE = 0.002
"""Distance beyond which errors count less than their squares [m]."""
GIVEN = 0.001
"""Deviation of a corner that the user gives [m]."""
LARGEST = 1.5
"""Logarithm of the largest scale."""
TIE = 0.001
"""Largest difference of scores at which two poses count as equally good [m]."""
STRETCH = 0.02
"""Score of a unit of the logarithm of length over width [m]: the way that keeps proportions is the likelier."""
CORRELATED = 0.05
"""Length of an outline over which its errors are correlated [m]."""


@dataclass(frozen=True)
class Fit:
    """The fitted pose and size of an outline."""

    shape: Shape
    parameters: np.ndarray
    """x, y [m], yaw [rad], logarithms of the scales along and across, shape (5,)."""
    off: np.ndarray
    """Signed distance of each found point from the outline, outwards [m], shape (n,)."""
    covariance: np.ndarray
    """Covariance of the parameters because of the outline, shape (5, 5)."""

    @property
    def pose(self) -> Pose:
        """Pose of the garment's frame."""
        x, y, yaw = self.parameters[:3].tolist()
        return Pose(x, y, wrapped(yaw))

    @property
    def scale(self) -> np.ndarray:
        """Scales along (x) and across (y), shape (2,)."""
        return np.exp(self.parameters[3:])

    def place(self, points: np.ndarray) -> np.ndarray:
        """Return points of the garment's frame (n, 2) as they lie."""
        return self.pose.place(points * self.scale)

    @property
    def rms(self) -> float:
        """Usual distance of the outlines, without the worst tenth [m]."""
        best = np.sort(np.abs(self.off))[: max(1, int(0.9 * len(self.off)))]
        return float(np.sqrt(np.mean(best**2)))


def lay(shape: Shape, found: np.ndarray, given: Mapping[str, np.ndarray], outward: Pose | None = None) -> Fit:
    """Lay a shape over a found outline.

    Args:
        shape: The garment's outline.
        found: Points of the outline that was found [m], shape (n, 2).
        given: Corners of the shape that the user gives, by name [m], shape (2,).
        outward: Pose of the frame of `found` in the robot's; of poses that fit equally well, the one with the least yaw
            in this frame is chosen. None for the frame of `found` itself.
    """
    box = np.array(shapely.Polygon(found).minimum_rotated_rectangle.exterior.coords)
    first, second = box[1] - box[0], box[2] - box[1]
    turn = float(np.arctan2(first[1], first[0]))
    middle = box[:4].mean(axis=0)
    low_x, low_y, high_x, high_y = shape.polygon.bounds
    fits = []
    for quarter in range(4):
        yaw = turn + 0.5 * np.pi * quarter
        sides = np.array([np.linalg.norm(first), np.linalg.norm(second)])
        scale = np.clip(np.log((sides if quarter % 2 == 0 else sides[::-1]) / shape.size), -LARGEST, LARGEST)
        centre = np.array([low_x + high_x, low_y + high_y]) / 2 * np.exp(scale)
        start = middle - Pose(yaw=yaw).place(centre[None])[0]
        fits.append(again(shape, found, given, np.array([*start, yaw, *scale])))
    best = min(map(_score, fits))
    base = 0.0 if outward is None else outward.yaw
    likely = [fit for fit in fits if _score(fit) < best + TIE]
    return min(likely, key=lambda fit: abs(wrapped(fit.pose.yaw + base)))


def _score(fit: Fit) -> float:
    return fit.rms + STRETCH * abs(float(fit.parameters[3] - fit.parameters[4]))


def again(shape: Shape, found: np.ndarray, given: Mapping[str, np.ndarray], start: np.ndarray) -> Fit:
    """Lay a shape over an outline from near its place."""
    names = list(given)
    own = np.array([shape.corners[name] for name in names]).reshape(-1, 2)
    wanted = np.array([given[name] for name in names]).reshape(-1, 2)

    def off(parameters: np.ndarray) -> np.ndarray:
        x, y, yaw = parameters[:3].tolist()
        scale = np.exp(parameters[3:])
        flat = Pose(x, y, yaw).seen_from(found) / scale
        _, nearest = shape.tree.query(flat)
        return np.asarray((((flat - shape.points[nearest]) * scale) * shape.normals[nearest]).sum(axis=1))

    def residuals(parameters: np.ndarray) -> np.ndarray:
        x, y, yaw = parameters[:3].tolist()
        wrong = Pose(x, y, yaw).place(own * np.exp(parameters[3:])) - wanted
        return np.concatenate([off(parameters) / TOLERANCE, wrong.ravel() / GIVEN])

    bound = np.array([np.inf, np.inf, np.inf, LARGEST + 0.1, LARGEST + 0.1])
    solved = least_squares(residuals, start, loss="soft_l1", bounds=(-bound, bound), x_scale=0.01)
    away = off(solved.x)
    length = float(shapely.LinearRing(found).length)
    few = max(1.0, len(found) * CORRELATED / length)
    scale = float(np.median(np.abs(away))) * 1.4826 / TOLERANCE
    covariance = np.linalg.pinv(solved.jac.T @ solved.jac, hermitian=True) * max(scale, 0.1) ** 2 * few
    return Fit(shape, solved.x, away, covariance)
