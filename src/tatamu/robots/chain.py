"""One arm as a chain of revolute joints: tool poses, Jacobians and inverse kinematics for many configurations at once.

The placement search asks for thousands of them, which numpy answers together. The plan itself is solved by mink.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tatamu.errors import InputError
from tatamu.robots.extras import needed
from tatamu.robots.model import Arm, Robot
from tatamu.robots.pose import from_quaternion, inverse, pose, rotation_vector

LENGTH = 0.25
"""Characteristic length that weighs rotations against translations, about wrist to elbow [m per rad]."""


@dataclass(frozen=True)
class Link:
    """A fixed pose, then a revolute joint."""

    X_PL: np.ndarray
    """Link frame in the parent's, at zero, shape (4, 4)."""
    axis: np.ndarray
    """Unit vector in the link's frame, shape (3,)."""
    moves: bool
    """Whether it is one of the arm's joints; else it stays at zero."""


@dataclass(frozen=True)
class Chain:
    """Base B to tool T of one arm with k joints."""

    links: tuple[Link, ...]
    X_LT: np.ndarray
    """Tool in the last link, shape (4, 4)."""
    limits: np.ndarray
    """Lower and upper joint limits [rad], shape (k, 2)."""

    @classmethod
    def of(cls, robot: Robot, arm: Arm) -> Chain:
        """Build the chain from the robot's model.

        Raises:
            InputError: A joint between base and tool is not revolute, or is not one of the arm's.
        """
        model, mujoco = robot.model, needed("mujoco")
        body, base = model.body(arm.link).id, model.body(robot.base).id
        links: list[Link] = []
        X = np.eye(4)  # from the frame of `body` out to the next link's frame
        tail: np.ndarray | None = None
        while body != base:
            if body == 0:
                raise InputError(f"robot {robot.name}: {arm.link} does not hang on {robot.base}")
            X_PB = pose(from_quaternion(model.body_quat[body]), model.body_pos[body])
            for number in reversed(range(model.body_jntnum[body])):
                joint = model.joint(int(model.body_jntadr[body]) + number)
                if joint.type[0] != mujoco.mjtJoint.mjJNT_HINGE:
                    raise InputError(f"robot {robot.name}: joint {joint.name} must be a hinge")
                shift = pose(np.eye(3), np.array(joint.pos))
                if tail is None:
                    tail = inverse(shift) @ X
                else:
                    links[-1] = Link(inverse(shift) @ X @ links[-1].X_PL, links[-1].axis, links[-1].moves)
                links.append(Link(np.eye(4), np.array(joint.axis), joint.name in arm.joints))
                X = shift
            X = X_PB @ X
            body = int(model.body_parentid[body])
        links[-1] = Link(X @ links[-1].X_PL, links[-1].axis, links[-1].moves)
        assert tail is not None
        return cls(tuple(reversed(links)), tail @ arm.tool_in_wrist, robot.limits(arm))

    @cached_property
    def _fixed(self) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, bool]]:
        skews = [np.cross(np.eye(3), link.axis) for link in self.links]
        return [(link.X_PL, K, K @ K, link.moves) for link, K in zip(self.links, skews, strict=True)]

    def trunk_pose(self, trunk: np.ndarray) -> np.ndarray:
        """X_BC for trunk angles [rad] (..), shape (.., 4, 4): C is B rotated by the trunk about its axis."""
        origin = self.links[0].X_PL[:3, 3] * [1, 1, 0] if not self.links[0].moves else np.zeros(3)
        cosine, sine, zero = np.cos(trunk), np.sin(trunk), np.zeros_like(trunk)
        R = np.stack([cosine, -sine, zero, sine, cosine, zero, zero, zero, zero + 1], axis=-1)
        R = R.reshape(*np.shape(trunk), 3, 3)
        return pose(R, origin - R @ origin)

    def before_trunk(self, X_BT: np.ndarray, trunk: np.ndarray) -> np.ndarray:
        """Tool poses with the trunk's rotation undone, shape (.., 4, 4): the targets of `solve`."""
        X_BC = self.trunk_pose(trunk)
        R = np.swapaxes(X_BC[..., :3, :3], -1, -2)
        p = (R @ (X_BT[..., :3, 3] - X_BC[..., :3, 3])[..., None])[..., 0]
        return pose(R @ X_BT[..., :3, :3], p)

    def tool(self, angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tool poses X_BT (n, 4, 4) and Jacobians (n, 6, k): velocity [m], then rotation [rad], in B, per rad.

        Args:
            angles: Joint angles [rad], shape (n, k).
        """
        count = len(angles)
        R, p = np.tile(np.eye(3), (count, 1, 1)), np.zeros((count, 3))
        axes, origins, column = [], [], 0
        for (X_PL, K, K2, moves), link in zip(self._fixed, self.links, strict=True):
            p = p + R @ X_PL[:3, 3]
            R = _times(R, X_PL[:3, :3])
            if not moves:
                continue
            axes.append(R @ link.axis)
            origins.append(p)
            angle = angles[:, column, None, None]
            R = R + np.sin(angle) * _times(R, K) + (1 - np.cos(angle)) * _times(R, K2)  # Rodrigues
            column += 1
        p = p + R @ self.X_LT[:3, 3]
        R = _times(R, self.X_LT[:3, :3])
        jacobian = np.empty((count, 6, len(axes)))
        for column, (axis, origin) in enumerate(zip(axes, origins, strict=True)):
            jacobian[:, :3, column] = _cross(axis, p - origin)
            jacobian[:, 3:, column] = axis
        return pose(R, p), jacobian

    def solve(
        self, targets: np.ndarray, start: np.ndarray, steps: int = 12, tolerance: float = 1e-3
    ) -> tuple[np.ndarray, np.ndarray]:
        """Damped least squares from `start`, kept inside the limits (Wampler 1986).

        Args:
            targets: X_BT, shape (n, 4, 4).
            start: Joint angles to begin from [rad], shape (n, k).
            steps: Iterations.
            tolerance: Largest error that counts as reached [m, and rad times LENGTH].

        Returns:
            Angles [rad] (n, k), and whether each reached its target (n,).
        """
        angles = np.clip(start, *self.limits.T)
        reached = np.zeros(len(angles), dtype=bool)
        for _ in range(steps):
            todo = np.flatnonzero(~reached)
            error, jacobian = self._error(angles[todo], targets[todo])
            reached[todo] = np.linalg.norm(error, axis=1) < tolerance
            todo, error, jacobian = (part[~reached[todo]] for part in (todo, error, jacobian))
            if not len(todo):
                break
            damped = jacobian @ jacobian.transpose(0, 2, 1) + 1e-5 * np.eye(6)
            step = np.linalg.solve(damped, error[:, :, None])
            step = (jacobian.transpose(0, 2, 1) @ step)[:, :, 0]
            step /= np.maximum(1.0, np.abs(step).max(axis=1, keepdims=True) / 0.4)
            angles[todo] = np.clip(angles[todo] + step, *self.limits.T)
        return angles, reached

    def _error(self, angles: np.ndarray, targets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Six errors [m] (rotations times LENGTH), shape (n, 6), and the Jacobian in the same units."""
        X_BT, jacobian = self.tool(angles)
        turn = rotation_vector(targets[:, :3, :3] @ X_BT[:, :3, :3].transpose(0, 2, 1))
        error = np.concatenate([targets[:, :3, 3] - X_BT[:, :3, 3], LENGTH * turn], axis=1)
        return error, jacobian * np.array([1, 1, 1, LENGTH, LENGTH, LENGTH])[:, None]

    @cached_property
    def shoulder(self) -> np.ndarray:
        """Position of the arm's first joint in B, the others at zero [m], shape (3,)."""
        X = np.eye(4)
        for link in self.links:
            X = X @ link.X_PL
            if link.moves:
                break
        return X[:3, 3]

    @cached_property
    def reach(self) -> float:
        """Upper bound on the distance from shoulder to tool [m]."""
        first = next(number for number, link in enumerate(self.links) if link.moves)
        offsets = [link.X_PL[:3, 3] for link in self.links[first + 1 :]] + [self.X_LT[:3, 3]]
        return float(sum(np.linalg.norm(offset) for offset in offsets))

    def near(self, positions: np.ndarray) -> np.ndarray:
        """Whether all of each row's positions (n, m, 3) [m] are within reach, shape (n,)."""
        return (np.linalg.norm(positions - self.shoulder, axis=2) <= self.reach).all(axis=1)

    def singularity(self, angles: np.ndarray) -> np.ndarray:
        """Distance from a singularity: least singular value of the Jacobian, metres over LENGTH, shape (n,)."""
        _, jacobian = self.tool(angles)
        jacobian = jacobian / np.array([LENGTH, LENGTH, LENGTH, 1, 1, 1])[:, None]
        least = np.linalg.eigvalsh(jacobian @ jacobian.transpose(0, 2, 1))[:, 0]
        return np.sqrt(np.maximum(least, 0.0))

    def margin(self, angles: np.ndarray) -> np.ndarray:
        """Distance to the nearest joint limit [rad], shape (n,)."""
        return np.minimum(angles - self.limits[:, 0], self.limits[:, 1] - angles).min(axis=1)


def _times(R: np.ndarray, constant: np.ndarray) -> np.ndarray:
    """Multiply rotations (n, 3, 3) by one matrix (3, 3), as one product."""
    return (R.reshape(-1, 3) @ constant).reshape(-1, 3, 3)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The cross product a x b, shapes (n, 3)."""
    (a0, a1, a2), (b0, b1, b2) = a.T, b.T
    return np.stack([a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0], axis=1)
