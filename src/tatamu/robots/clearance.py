"""Clearance of the robot from itself, its surroundings and the table: MuJoCo's distances between collision shapes.

Pairs of shapes whose bounding spheres are farther apart than the smallest distance so far are skipped. Shapes for which
no sphere is known are never skipped.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.robots.extras import needed
from tatamu.robots.model import TABLE, Robot
from tatamu.robots.pairs import FINGERS, KINDS, OBSTACLES, ON_TABLE, link_name, pairs_of

FAR = 0.15
"""Maximum distance between shapes that is computed [m]. Larger distances count as this value."""


@dataclass(frozen=True)
class Distance:
    """The smallest distance of one kind, such as "between arms", over many configurations of the robot."""

    value: float
    """Distance [m]; `FAR` if all shapes were farther apart."""
    row: int
    """Index of the robot's configuration with the smallest distance."""
    pair: tuple[str, str]
    """Names of the two links with the smallest distance."""


class Clearance:
    """Computes distances between the collision shapes of a robot, its surroundings and the table."""

    def __init__(
        self, robot: Robot, kinds: tuple[str, ...] = KINDS, arm: str | None = None, table: float = -10.0
    ) -> None:
        """Prepare the computation for pairs of shapes.

        Args:
            robot: The robot.
            kinds: Kinds of pairs that are compared, such as "between arms".
            arm: Name of the arm whose pairs are compared; None for both arms.
            table: Height of the table top in B [m], which `set_table` changes; by default far below the robot.
        """
        mujoco = needed("mujoco")
        self._mujoco, self.model = mujoco, robot.model
        self._data = robot.at_rest()
        self._table = self.model.geom(TABLE).id
        self._table_position = self._data.geom_xpos[self._table]  # a view, which is set after each computation of poses
        self._base = float(self._data.body(robot.base).xpos[2])
        self._kinds = kinds
        # Each pair has a kind, and another one if the second shape is completely below the table.
        pairs = sorted(pairs_of(robot, arm)[0], key=lambda pair: pair.kind == OBSTACLES)
        self._all = np.array([(pair.first, pair.second) for pair in pairs], dtype=int).reshape(-1, 2)
        self._above = np.array([pair.kind for pair in pairs], dtype=str)
        is_finger = [pair.kind == OBSTACLES and link_name(self.model, pair.first) in robot.fingers for pair in pairs]
        self._below = np.where(np.array(is_finger, bool), FINGERS, ON_TABLE)
        self._tops = np.array(
            [_top(self.model, self._data, pair.second) if pair.kind == OBSTACLES else np.inf for pair in pairs]
        )
        radius = np.array(self.model.geom_rbound)
        self._radius = np.where(np.isfinite(radius) & (radius > 0), radius, np.inf)
        self._thickness = np.where(self.model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE, 0.0, np.nan)
        self._thickness[self._table] = self.model.geom_size[self._table][2]
        self.set_table(table)

    @property
    def pairs(self) -> list[tuple[str, str, str]]:
        """The pairs of shapes whose distance is computed: the kind of the pair, and the names of its two shapes."""
        return [
            (kind, str(self.model.geom(first).name), str(self.model.geom(second).name))
            for kind, rows in self._pairs.items()
            for first, second in rows.tolist()
        ]

    def set_table(self, height: float) -> None:
        """Move the table top to a height in B [m]. An obstacle completely below it counts as a part of the table."""
        self._top = self._base + height
        kinds = np.where(self._tops <= self._top + 1e-9, self._below, self._above)
        found = {kind: self._all[kinds == kind] for kind in self._kinds}
        self._pairs = {kind: pairs for kind, pairs in found.items() if len(pairs)}
        self._first, self._second = np.concatenate([np.empty((0, 2), int), *self._pairs.values()]).T
        self._counts = np.cumsum([len(pairs) for pairs in self._pairs.values()])
        self._flat = np.flatnonzero(~np.isnan(self._thickness[self._second]))

    def lowest(self, configuration: np.ndarray) -> float:
        """Return the height of the arms' lowest point above the origin of the robot's base in a configuration [m]."""
        probe = -5.0
        self.set_table(probe)
        self._move(configuration)
        arms = self._all[self._all[:, 1] == self._table, 0]
        return probe + min(self._distance(int(geom), self._table, 20.0) for geom in arms)

    def least(self, configurations: np.ndarray) -> dict[str, Distance]:
        """Return the smallest distance of each kind in any of n configurations [rad], shape (n, nq)."""
        best: dict[str, Distance] = {}
        for row, q in enumerate(configurations):
            self._move(q)
            bounds = np.split(self._bounds(), self._counts[:-1])
            for (kind, pairs), bound in zip(self._pairs.items(), bounds, strict=True):
                limit = best[kind].value if kind in best else FAR
                found = self._nearest(pairs, bound, limit)
                if kind not in best or found[0] < limit:
                    best[kind] = Distance(found[0], row, found[1])
        return best

    def _move(self, configuration: np.ndarray) -> None:
        self._data.qpos[:] = configuration
        self._mujoco.mj_kinematics(self.model, self._data)
        self._table_position[2] = self._top - self._thickness[self._table]

    def _nearest(self, pairs: np.ndarray, bound: np.ndarray, limit: float) -> tuple[float, tuple[str, str]]:
        """Return the smallest distance of the given pairs of shapes [m], and the names of the two links."""
        value, names = limit, ("", "")
        near = np.flatnonzero(bound < limit)
        for number in near[np.argsort(bound[near])]:
            if bound[number] >= value:
                break
            first, second = (int(geom) for geom in pairs[number])
            distance = self._distance(first, second, value)
            if distance < value:
                value, names = distance, (link_name(self.model, first), link_name(self.model, second))
        return value, names

    def _bounds(self) -> np.ndarray:
        """Return a lower bound on the distance between the two shapes of each of n pairs [m], shape (n,)."""
        first, second = self._first, self._second
        between = self._data.geom_xpos[first] - self._data.geom_xpos[second]
        apart = np.sqrt((between * between).sum(axis=1)) - self._radius[second]
        flat, shape = self._flat, second[self._flat]  # of the table and of planes, only the upper side counts
        height = (between[flat] * self._data.geom_xmat[shape, 2::3]).sum(axis=1)
        apart[flat] = height - self._thickness[shape]
        return apart - self._radius[first]

    def _distance(self, first: int, second: int, limit: float) -> float:
        return float(self._mujoco.mj_geomDistance(self.model, self._data, first, second, limit, None))


def _top(model: Any, data: Any, geom: int) -> float:
    """Return the height of the highest point of a shape that does not move [m]."""
    R, p = data.geom_xmat[geom].reshape(3, 3), data.geom_xpos[geom]
    if model.geom_type[geom] == needed("mujoco").mjtGeom.mjGEOM_PLANE:
        return float(p[2]) if R[2, 2] > 1 - 1e-9 else np.inf
    middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    return float((p + R @ middle)[2] + np.abs(R[2]) @ half)
