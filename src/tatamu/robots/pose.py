"""Poses as 4 x 4 matrices. X_AB is the pose of frame B in frame A, so X_AC = X_AB @ X_BC."""

from __future__ import annotations

from typing import Any

import numpy as np


def turn(axis: int, angle: float) -> np.ndarray:
    """Return the rotation about the x, y or z axis (0, 1, 2) by an angle [rad], shape (3, 3)."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    rotation = np.eye(3)
    rotation[i, i] = rotation[j, j] = np.cos(angle)
    rotation[j, i] = np.sin(angle)
    rotation[i, j] = -rotation[j, i]
    return rotation


def from_rpy(roll: float, pitch: float, yaw: float) -> np.ndarray:
    """Return the rotation about fixed x, then y, then z by these angles [rad], as in URDF, shape (3, 3)."""
    return turn(2, yaw) @ turn(1, pitch) @ turn(0, roll)


def pose(rotation: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return the poses X_AB of rotations R_AB (.., 3, 3) and positions p_AB (.., 3) [m], shape (.., 4, 4)."""
    leading = np.broadcast_shapes(rotation.shape[:-2], position.shape[:-1])
    matrix = np.broadcast_to(np.eye(4), (*leading, 4, 4)).copy()
    matrix[..., :3, :3] = rotation
    matrix[..., :3, 3] = position
    return matrix


def frame_pose(frame: Any) -> np.ndarray:
    """Return the pose X_WA of a body, site or shape A of MuJoCo's data in the world frame W, shape (4, 4)."""
    return pose(frame.xmat.reshape(3, 3), frame.xpos)


def inverse(matrix: np.ndarray) -> np.ndarray:
    """Return the inverse of a pose: X_BA from X_AB, shape (4, 4)."""
    rotation = matrix[:3, :3].T
    return pose(rotation, -rotation @ matrix[:3, 3])


def into(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Transform points from frame A to frame B, given the pose X_AB. Points have the shape (.., 3) [m]."""
    return np.asarray((points - matrix[:3, 3]) @ matrix[:3, :3])


def out_of(matrix: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Transform points from frame B to frame A, given the pose X_AB. Points have the shape (.., 3) [m]."""
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])


def to_quaternion(rotation: np.ndarray) -> np.ndarray:
    """Return the unit quaternion w, x, y, z of a rotation (3, 3), with w >= 0.

    The quaternion is the eigenvector that belongs to the largest eigenvalue of a matrix (Bar-Itzhack 2000).
    """
    (a, b, c), (d, e, f), (g, h, i) = rotation
    symmetric = np.array(
        [
            [a + e + i, h - f, c - g, d - b],
            [h - f, a - e - i, b + d, c + g],
            [c - g, b + d, e - a - i, f + h],
            [d - b, c + g, f + h, i - a - e],
        ]
    )
    quaternion = np.linalg.eigh(symmetric)[1][:, -1]
    return -quaternion if quaternion[0] < 0 else quaternion


def rotation_vector(rotation: np.ndarray) -> np.ndarray:
    """Return the rotation vectors of n rotations, shape (n, 3): the axis times the angle [rad].

    The result is accurate for small angles, and safe for angles up to pi.
    """
    twice = rotation - rotation.transpose(0, 2, 1)
    skew = np.stack([twice[:, 2, 1], twice[:, 0, 2], twice[:, 1, 0]], axis=1)
    sine = np.linalg.norm(skew, axis=1) / 2  # |sin angle|
    cosine = (np.trace(rotation, axis1=1, axis2=2) - 1) / 2
    angle = np.arctan2(sine, cosine)
    scale = np.where(sine > 1e-9, angle / np.maximum(2 * sine, 1e-12), 0.5)
    return scale[:, None] * skew
