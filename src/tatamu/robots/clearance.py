"""Clearance of the robot from itself and from the table: MuJoCo's distances between its collision shapes.

The robot's own controller does not check itself, so this must. Pairs are the left arm with the right, each arm with
the trunk, parts of one arm that are two or more links apart, and each arm with the table. Links that a joint connects,
and the roots of both arms with the trunk, are not checked: the joints' ranges keep them apart.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.robots.extras import needed
from tatamu.robots.model import TABLE, Robot

FAR = 0.15
"""Cut-off beyond which distances are not computed [m]."""
KINDS = ("between arms", "to the trunk", "within an arm", "to the table")


@dataclass(frozen=True)
class Distance:
    """The least distance of one kind over many configurations."""

    value: float
    """Distance [m]; FAR where everything was farther away."""
    row: int
    """Index of the configuration."""
    pair: tuple[str, str]
    """Names of the two links."""


class Clearance:
    """Distance queries on one robot."""

    def __init__(self, robot: Robot, kinds: tuple[str, ...] = KINDS, arm: str | None = None) -> None:
        """Restrict to some kinds of pairs, and to one arm, where they are given."""
        mujoco = needed("mujoco")
        self._mujoco, self.model = mujoco, robot.model
        self._data = mujoco.MjData(self.model)
        self._table = self.model.geom(TABLE).id
        self._base = self.model.body(robot.base).id
        self.set_table(-10.0)
        groups = {geom: _group(self.model, robot, geom) for geom in self._solid()}
        pairs = self._pairs_of(groups, arm)
        self._pairs = {kind: pairs[kind] for kind in kinds if kind in pairs}
        self._radius = np.array(self.model.geom_rbound)

    @property
    def kinds(self) -> tuple[str, ...]:
        """The kinds of distances that the model has shapes for."""
        return tuple(self._pairs)

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Names of the shapes whose distances are taken."""
        rows = np.concatenate(list(self._pairs.values()))
        return [(str(self.model.geom(a).name), str(self.model.geom(b).name)) for a, b in rows.tolist()]

    def set_table(self, height: float) -> None:
        """Move the table top to a height in B [m]."""
        self._mujoco.mj_kinematics(self.model, self._data)
        top = self._data.xpos[self._base][2] + height
        self.model.geom_pos[self._table][2] = top - self.model.geom_size[self._table][2]

    def lowest(self, configuration: np.ndarray) -> float:
        """Height of the arms' lowest point above the base's origin at a configuration (nq,) [m]."""
        probe = -5.0
        self.set_table(probe)
        self._data.qpos[:] = configuration
        self._mujoco.mj_kinematics(self.model, self._data)
        arms = self._pairs["to the table"][:, 0]
        return probe + min(self._distance(int(geom), self._table, 20.0) for geom in arms)

    def least(self, configurations: np.ndarray) -> dict[str, Distance]:
        """The least distance of each kind over configurations (n, nq) [rad]."""
        best: dict[str, Distance] = {}
        for row, q in enumerate(configurations):
            self._data.qpos[:] = q
            self._mujoco.mj_kinematics(self.model, self._data)
            for kind, pairs in self._pairs.items():
                limit = best[kind].value if kind in best else FAR
                found = self._nearest(pairs, limit)
                if kind not in best or found[0] < limit:
                    best[kind] = Distance(found[0], row, found[1])
        return best

    def nearest(self, configurations: np.ndarray) -> float:
        """The least distance of any kind over configurations (n, nq) [rad], at most FAR [m]."""
        return min((found.value for found in self.least(configurations).values()), default=FAR)

    def _nearest(self, pairs: np.ndarray, limit: float) -> tuple[float, tuple[str, str]]:
        """The nearest pair closer than `limit`, if any; bounding spheres rule most out (broad phase)."""
        value, names = limit, ("", "")
        first, second = pairs.T
        apart = np.linalg.norm(self._data.geom_xpos[first] - self._data.geom_xpos[second], axis=1)
        bound = np.where(
            second == self._table,
            self._data.geom_xpos[first, 2] - self._top - self._radius[first],
            apart - self._radius[first] - self._radius[second],
        )
        for number in np.argsort(bound):
            if bound[number] >= value:
                break
            distance = self._distance(int(first[number]), int(second[number]), value)
            if distance < value:
                value = distance
                names = (self._link(first[number]), self._link(second[number]))
        return value, names

    @property
    def _top(self) -> float:
        return float(self.model.geom_pos[self._table][2] + self.model.geom_size[self._table][2])

    def _distance(self, first: int, second: int, limit: float) -> float:
        return float(self._mujoco.mj_geomDistance(self.model, self._data, first, second, limit, None))

    def _link(self, geom: np.integer[Any]) -> str:
        return "table" if geom == self._table else str(self.model.body(self.model.geom_bodyid[geom]).name)

    def _solid(self) -> list[int]:
        model = self.model
        return [
            g for g in range(model.ngeom) if g != self._table and (model.geom_contype[g] or model.geom_conaffinity[g])
        ]

    def _pairs_of(self, groups: dict[int, tuple[str, int]], only: str | None) -> dict[str, np.ndarray]:
        pairs: dict[str, list[tuple[int, int]]] = {kind: [] for kind in KINDS}
        geoms = sorted(groups)
        for i, a in enumerate(geoms):
            arm, depth = groups[a]
            if depth >= 1 and only in (None, arm):
                pairs["to the table"].append((a, self._table))
            for b in geoms[i + 1 :]:
                kind = _kind(groups[a], groups[b])
                if kind and only in (None, groups[a][0], groups[b][0]):
                    pairs[kind].append((a, b))
        return {kind: np.array(rows) for kind, rows in pairs.items() if rows}


def _group(model: Any, robot: Robot, geom: int) -> tuple[str, int]:
    """The arm that a shape belongs to (empty: the trunk), and how many of the arm's joints carry it."""
    body = int(model.geom_bodyid[geom])
    arms, depth = "", 0
    while body:
        for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body]):
            for arm in robot.arms:
                if model.joint(joint).name in arm.joints:
                    arms, depth = arm.name, depth + 1
        body = int(model.body_parentid[body])
    return arms, depth


def _kind(a: tuple[str, int], b: tuple[str, int]) -> str | None:
    """Kind of pair that two shapes make; None: not one to check."""
    if a[0] and b[0]:
        if a[0] != b[0]:
            return "between arms"
        return "within an arm" if abs(a[1] - b[1]) >= 3 else None
    moving = a if a[0] else b
    return "to the trunk" if moving[0] and moving[1] >= 3 else None
