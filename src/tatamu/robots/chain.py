"""One arm as a chain of revolute joints: tool poses, Jacobians and inverse kinematics of many configurations."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tatamu.robots.arm import Arm
from tatamu.robots.model import Robot
from tatamu.robots.pose import frame_pose, inverse, out_of, pose, rotation_vector

FULL_JOINTS = 6
"""Minimum number of joints with which an arm can keep its tool's whole orientation."""
LENGTH = 0.25
"""Characteristic length that converts rotations to distances [m per rad]: about the distance from wrist to elbow."""


@dataclass(frozen=True)
class Chain:
    """The chain of one arm with k joints from the base B to the tool T, as a product of exponentials.

        X_BT(q) = exp(w_1, o_1, q_1 - r_1) .. exp(w_k, o_k, q_k - r_k) X_BT(r)

    exp(w, o, a) is the rotation by the angle a about the axis w through the point o, and r are the angles at rest. All
    are read from MuJoCo's kinematics, so fixed bodies, sliding joints at rest and `ref` of a joint are included.

    An arm with five joints keeps the position of T and the direction of the axis along which the jaws open, but not the
    rotation about this axis. The jaws then stay across the edge of the cloth at their tilt.
    """

    offsets: np.ndarray
    """Offset of each joint from the one before, of the first from the origin of B, at rest [m], shape (k, 3)."""
    axes: np.ndarray
    """Unit vectors of the joint axes at rest in B, shape (k, 3)."""
    rest: np.ndarray
    """Angles r [rad], shape (k,)."""
    X_LT: np.ndarray
    """Pose of T in a frame at the last joint that is parallel to B at rest, shape (4, 4)."""
    limits: np.ndarray
    """Lower and upper limit of each of the k joints [rad], shape (k, 2)."""
    trunk_origin: np.ndarray
    """A point on the trunk's axis, in the base B [m], shape (3,)."""

    @classmethod
    def of(cls, robot: Robot, arm: Arm) -> Chain:
        """Read the chain from the robot's model."""
        data = robot.at_rest()
        X_BW = inverse(frame_pose(data.body(robot.base)))
        joints = [data.joint(name) for name in arm.joints]
        origins = out_of(X_BW, np.array([joint.xanchor for joint in joints]))
        axes = np.array([joint.xaxis for joint in joints]) @ X_BW[:3, :3].T
        X_BT = X_BW @ frame_pose(data.site(arm.site))
        trunk = np.zeros(3) if robot.trunk is None else out_of(X_BW, data.joint(robot.trunk).xanchor)
        return cls(
            offsets=np.diff(origins, axis=0, prepend=0.0),
            axes=axes,
            rest=robot.rest[robot.arm_columns(arm)],
            X_LT=pose(X_BT[:3, :3], X_BT[:3, 3] - origins[-1]),
            limits=robot.limits(arm),
            trunk_origin=trunk * [1, 1, 0],
        )

    @cached_property
    def _skews(self) -> list[tuple[np.ndarray, np.ndarray]]:
        return [(K, K @ K) for K in (np.cross(np.eye(3), axis) for axis in self.axes)]

    def trunk_pose(self, trunk: np.ndarray) -> np.ndarray:
        """Return the pose of the base as turned by the trunk, for each trunk angle [rad], shape (.., 4, 4)."""
        cosine, sine, zero = np.cos(trunk), np.sin(trunk), np.zeros_like(trunk)
        R = np.stack([cosine, -sine, zero, sine, cosine, zero, zero, zero, zero + 1], axis=-1)
        R = R.reshape(*np.shape(trunk), 3, 3)
        return pose(R, self.trunk_origin - R @ self.trunk_origin)

    def before_trunk(self, X_BT: np.ndarray, trunk: np.ndarray) -> np.ndarray:
        """Return the poses that the tool would have if the trunk were not turned: the targets of `solve`."""
        X_BC = self.trunk_pose(trunk)
        R = np.swapaxes(X_BC[..., :3, :3], -1, -2)
        p = (R @ (X_BT[..., :3, 3] - X_BC[..., :3, 3])[..., None])[..., 0]
        return pose(R @ X_BT[..., :3, :3], p)

    def tool(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the poses X_BT, shape (n, 4, 4), and the Jacobians [m and rad per rad], shape (n, 6, k)."""
        count = len(angles)
        R, p = np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3))
        turned = angles - self.rest
        axes, origins = [], []
        for column, (K, K2) in enumerate(self._skews):
            p = p + R @ self.offsets[column]
            axes.append(R @ self.axes[column])
            origins.append(p)
            angle = turned[:, column, None, None]
            R = R + np.sin(angle) * _times(R, K) + (1 - np.cos(angle)) * _times(R, K2)  # Rodrigues' formula
        p = p + R @ self.X_LT[:3, 3]
        R = _times(R, self.X_LT[:3, :3])
        jacobian = np.empty((count, 6, len(axes)))
        for column, (axis, origin) in enumerate(zip(axes, origins, strict=True)):
            jacobian[:, :3, column] = _cross(axis, p - origin)
            jacobian[:, 3:, column] = axis
        return pose(R, p), jacobian

    def solve(
        self,
        targets: np.ndarray,
        start: np.ndarray,
        steps: int = 12,
        tolerance: float = 1e-3,
        damping: float = 1e-5,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Solve for joint angles by damped least squares from `start`, inside the joint limits (Wampler 1986).

        Args:
            targets: Poses X_BT, shape (n, 4, 4).
            start: Initial angles for each target [rad], shape (n, k).
            steps: Number of iterations.
            tolerance: Maximum error of a reached target [m], rotations multiplied by LENGTH.
            damping: Damping of the least squares [m^2]. Less damping is more accurate, and slower near singular poses.

        Returns:
            The joint angles [rad], shape (n, k), and whether they reach their target, shape (n,).
        """
        angles = np.clip(start, *self.limits.T)
        reached = np.zeros(len(angles), dtype=bool)
        for _ in range(steps):
            todo = np.flatnonzero(~reached)
            error, jacobian = self.error(angles[todo], targets[todo])
            reached[todo] = np.linalg.norm(error, axis=1) < tolerance
            todo, error, jacobian = (part[~reached[todo]] for part in (todo, error, jacobian))
            if not len(todo):
                break
            step = _least_squares(jacobian, error, damping)
            low, high = self.limits.T
            blocked = ((angles[todo] <= low) & (step < 0)) | ((angles[todo] >= high) & (step > 0))
            rows = blocked.any(axis=1)  # the other joints make the motion
            free = np.where(blocked[rows, None], 0.0, jacobian[rows])
            step[rows] = _least_squares(free, error[rows], damping)
            step /= np.maximum(1.0, np.abs(step).max(axis=1, keepdims=True) / 0.4)
            angles[todo] = np.clip(angles[todo] + step, *self.limits.T)
        return angles, reached

    def error(self, angles: np.ndarray, targets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the errors of position and rotation [m, m per LENGTH], shape (n, 6), and the Jacobians alike."""
        X_BT, jacobian = self.tool(angles)
        turn = rotation_vector(targets[:, :3, :3] @ X_BT[:, :3, :3].transpose(0, 2, 1))
        error = np.concatenate([targets[:, :3, 3] - X_BT[:, :3, 3], LENGTH * turn], axis=1)
        jacobian = jacobian * np.array([1, 1, 1, LENGTH, LENGTH, LENGTH])[:, None]
        if self.turns_freely:
            R_TB = targets[:, :3, :3].transpose(0, 2, 1) * self.turn_weights[:, None]
            error[:, 3:] = (R_TB @ error[:, 3:, None])[:, :, 0]
            jacobian[:, 3:] = R_TB @ jacobian[:, 3:]
        return error, jacobian

    @property
    def turns_freely(self) -> bool:
        """Whether the arm has too few joints to control the rotation of the tool about the jaw's opening axis y."""
        return len(self.axes) < FULL_JOINTS

    @property
    def turn_weights(self) -> np.ndarray:
        """1 for each axis of T whose rotation the arm controls, otherwise 0, shape (3,)."""
        return np.array([1.0, 0.0 if self.turns_freely else 1.0, 1.0])

    @property
    def shoulder(self) -> np.ndarray:
        """Position of the first joint in B at rest [m], shape (3,)."""
        return self.offsets[0]

    @cached_property
    def reach(self) -> float:
        """Upper bound on the distance from the first joint to the tool [m]."""
        between = [*self.offsets[1:], self.X_LT[:3, 3]]
        return float(sum(np.linalg.norm(offset) for offset in between))

    def near(self, positions: np.ndarray) -> np.ndarray:
        """Return whether each path of positions [m], shape (n, m, 3), is within the arm's reach, shape (n,)."""
        return (np.linalg.norm(positions - self.shoulder, axis=2) <= self.reach).all(axis=1)

    def singularity(self, angles: np.ndarray) -> np.ndarray:
        """Return the smallest singular value of the Jacobian, lengths divided by LENGTH, shape (n,).

        Only the directions of motion that the arm controls count.
        """
        X_BT, jacobian = self.tool(angles)
        jacobian = jacobian / np.array([LENGTH, LENGTH, LENGTH, 1, 1, 1])[:, None]
        if self.turns_freely:
            kept = np.flatnonzero(self.turn_weights)
            turns = (X_BT[:, :3, :3].transpose(0, 2, 1) @ jacobian[:, 3:])[:, kept]
            jacobian = np.concatenate([jacobian[:, :3], turns], axis=1)
        least = np.linalg.eigvalsh(jacobian @ jacobian.transpose(0, 2, 1))[:, 0]
        return np.sqrt(np.maximum(least, 0.0))

    def margin(self, angles: np.ndarray) -> np.ndarray:
        """Return the distance from the nearest joint limit in each of n configurations [rad], shape (n,)."""
        return np.minimum(angles - self.limits[:, 0], self.limits[:, 1] - angles).min(axis=1)


def _least_squares(jacobian: np.ndarray, error: np.ndarray, damping: float) -> np.ndarray:
    """Return the damped least-squares steps of n arms with k joints, shape (n, k)."""
    transposed = jacobian.transpose(0, 2, 1)
    damped = np.linalg.solve(jacobian @ transposed + damping * np.eye(6), error[:, :, None])
    return (transposed @ damped)[:, :, 0]


def _times(R: np.ndarray, constant: np.ndarray) -> np.ndarray:
    """Return the products of n rotations and one matrix (3, 3), shape (n, 3, 3)."""
    return (R.reshape(-1, 3) @ constant).reshape(-1, 3, 3)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the cross products a x b of rows, shape (n, 3)."""
    (a0, a1, a2), (b0, b1, b2) = a.T, b.T
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=1)
