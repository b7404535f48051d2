"""Boxes around a robot's links over time, for the replay of a rehearsal. The boxes are in the fold's frame F."""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.robots.extras import needed
from tatamu.robots.model import TABLE
from tatamu.robots.planned import Planned
from tatamu.robots.pose import into, pose
from tatamu.robots.stage import Poser, load_stage

_SIDES = [(axis, sign) for axis in range(3) for sign in (-1.0, 1.0)]


def _side(axis: int, sign: float) -> list[list[float]]:
    """Return the four corners of a side of the cube of half size 1, anticlockwise as seen from outside."""
    corners = []
    for first, second in ((-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)):
        corner = [0.0, 0.0, 0.0]
        corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3] = sign, first, second
        corners.append(corner)
    return corners if sign > 0 else corners[::-1]


CORNERS = np.array([corner for side in _SIDES for corner in _side(*side)])
"""Corners of a cube of half size 1, four for each side, shape (24, 3)."""
FACES = np.array([[4 * k + i for i in triangle] for k in range(6) for triangle in ((0, 1, 2), (0, 2, 3))])
"""Triangles of the cube's sides, shape (12, 3)."""


def link_boxes(planned: Planned, angles: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of all boxes [m], shape (f, 24 b, 3), and their triangles, shape (12 b, 3).

    There are f frames and b boxes.

    Args:
        planned: The plan.
        angles: Angles of the plan's j joints at each frame [rad], shape (f, j).
        times: Times of the frames [s], shape (f,). They determine whether the fingers are open.
    """
    mujoco = needed("mujoco")
    model = load_stage(planned.folder).compile()
    poser = Poser(model, planned, angles, times)
    shown = [k for k in range(model.ngeom) if model.geom(k).name != TABLE and np.isfinite(model.geom_rbound[k])]
    shown = [k for k in shown if model.geom_type[k] != mujoco.mjtGeom.mjGEOM_PLANE]
    middle, half = model.geom_aabb[shown, :3], model.geom_aabb[shown, 3:]
    corners = middle[:, None] + half[:, None] * CORNERS  # in the own frame of each shape
    found = []
    for row in range(len(angles)):
        data = poser.pose(row)
        turned = np.einsum("bij,bkj->bki", data.geom_xmat[shown].reshape(-1, 3, 3), corners)
        found.append(_in_fold(planned, data, (turned + data.geom_xpos[shown][:, None]).reshape(-1, 3)))
    faces = (FACES + 24 * np.arange(len(shown))[:, None, None]).reshape(-1, 3)
    return np.array(found), faces


def _in_fold(planned: Planned, data: Any, points: np.ndarray) -> np.ndarray:
    """Convert points from MuJoCo's world frame to the fold's frame F [m], shape (n, 3)."""
    base = data.body(planned.plan.base_frame)
    return into(planned.plan.task_in_base.matrix, into(pose(base.xmat.reshape(3, 3), base.xpos), points))
