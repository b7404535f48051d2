"""Decide which pairs of a robot's collision shapes are compared when distances are computed.

- *between arms*: every shape of one arm with every shape of the other arm.
- *within an arm*: shapes with three or more of the arm's joints between them.
- *to the trunk*: the body that carries the arm, and bodies fixed to this body, with all links that at least three of
  the arm's joints move.
- *to obstacles*: every link with everything else that does not move: walls, floors, furniture, and the other arm's
  foot.
- *to the table*: the table of the plan with every link except the fingers.
- *of fingers to the table*: the table with the fingers, which go under the edge of cloth that lies on the table.

Shapes that are connected by one or two joints are not compared, nor a link and the obstacle on which an arm stands.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from tatamu.robots.arm import Arm
from tatamu.robots.extras import needed
from tatamu.robots.model import TABLE, Robot

ON_TABLE, FINGERS, OBSTACLES, CLOTH = "to the table", "of fingers to the table", "to obstacles", "to the cloth"


class Limits(NamedTuple):
    """Limits for one kind of distance [m]."""

    allowed: float
    """Minimum distance in a plan."""
    searched: float
    """Minimum distance in the search for placements, which tests few poses and therefore keeps a reserve."""
    comfortable: float
    """A larger distance does not improve the quality of a placement."""


DISTANCES = {
    "between arms": Limits(0.015, 0.018, 0.06),
    "to the trunk": Limits(0.005, 0.008, 0.04),
    "within an arm": Limits(0.005, 0.008, 0.04),
    OBSTACLES: Limits(0.005, 0.008, 0.04),
    ON_TABLE: Limits(0.002, 0.003, 0.012),
    FINGERS: Limits(0.0003, 0.0004, 0.0008),
    CLOTH: Limits(0.002, 0.003, 0.003),
}
"""Limits for each kind of distance. Links are represented by boxes that contain them.

That of fingers and table is smaller than `arm.GAP`, the planned distance of the lower finger above the table.
"""
KINDS = tuple(kind for kind in DISTANCES if kind != CLOTH)
"""Kinds of distances between shapes of the model."""
STANDS_ON = 0.005
"""Maximum gap between an obstacle and one of the first two links of an arm that stands on the obstacle [m]."""
JOINTS_BETWEEN = 3
"""Minimum number of joints between two shapes of an arm that are compared."""


class Pair(NamedTuple):
    """A pair of shapes that are compared."""

    kind: str
    first: int
    """Index of the arm's shape."""
    second: int


@dataclass(frozen=True)
class _Shape:
    """A collision shape, and the joints that move the shape."""

    geom: int
    arm: str
    """The arm that moves this shape; empty if no arm moves it."""
    depth: int
    """Number of joints of the arm that move this shape."""
    carries: frozenset[str]
    """The arms that are attached to the body of this shape."""
    still: bool
    """Whether no joint moves this shape."""


def pairs_of(robot: Robot, only: str | None = None) -> tuple[list[Pair], list[Pair]]:
    """Return the pairs of a robot's shapes that are compared, and those in which an arm stands on an obstacle.

    If `only` names an arm, return only the arm's pairs.
    """
    model = robot.model
    shapes = _shapes(robot)
    table = int(model.geom(TABLE).id)
    found: list[Pair] = []
    near: list[Pair] = []
    for number, a in enumerate(shapes):
        if a.depth >= 1 and only in (None, a.arm):
            found.append(Pair(FINGERS if link_name(model, a.geom) in robot.fingers else ON_TABLE, a.geom, table))
        for b in shapes[number + 1 :]:
            first, second = (a, b) if a.arm else (b, a)
            kind = _kind(first, second)
            if kind is not None and only in (None, a.arm, b.arm):
                asked = near if kind == OBSTACLES and first.depth < JOINTS_BETWEEN else found
                asked.append(Pair(kind, first.geom, second.geom))
    stands = _standing(robot, near)
    return found + [pair for pair in near if pair not in stands], stands


def link_name(model: Any, geom: int) -> str:
    """Return the name of a shape as text: the name of its link, or its own name if the shape is fixed to the world."""
    if model.geom(geom).name == TABLE:
        return "table"
    body = int(model.geom_bodyid[geom])
    return str(model.geom(geom).name if body == 0 else model.body(body).name)


def hand_shapes(robot: Robot, arm: Arm) -> list[int]:
    """Return the numbers of the shapes that all joints of an arm move: the hand with its fingers."""
    return [shape.geom for shape in _shapes(robot) if shape.arm == arm.name and shape.depth == len(arm.joints)]


def _kind(a: _Shape, b: _Shape) -> str | None:
    """Return the kind of a pair of shapes, such as "between arms"; None if the two shapes are not compared."""
    if not a.arm:
        return None
    if b.arm:
        if a.arm != b.arm:
            return "between arms"
        return "within an arm" if abs(a.depth - b.depth) >= JOINTS_BETWEEN else None
    if b.still and a.arm not in b.carries:
        return OBSTACLES
    return "to the trunk" if a.depth >= JOINTS_BETWEEN else None


def _shapes(robot: Robot) -> list[_Shape]:
    model = robot.model
    arm_of = {int(model.joint(name).id): arm.name for arm in robot.arms for name in arm.joints}
    roots = {arm.name: set(_ancestors(model, int(model.joint(arm.joints[0]).bodyid[0]))[1:]) for arm in robot.arms}
    found = []
    for geom in range(model.ngeom):
        if not (model.geom_contype[geom] or model.geom_conaffinity[geom]) or model.geom(geom).name == TABLE:
            continue
        body = int(model.geom_bodyid[geom])
        joints = joints_above(model, body)
        moved_by = [arm_of[number] for number in joints if number in arm_of]
        carries = frozenset(name for name, bodies in roots.items() if body in bodies)
        found.append(_Shape(geom, moved_by[-1] if moved_by else "", len(moved_by), carries, not joints))
    return found


def joints_above(model: Any, body: int) -> list[int]:
    """Return the numbers of the joints that move a body, from the base outwards."""
    firsts = [(int(model.body_jntadr[above]), above) for above in reversed(_ancestors(model, body))]
    return [number for first, above in firsts for number in range(first, first + int(model.body_jntnum[above]))]


def _ancestors(model: Any, body: int) -> list[int]:
    """Return a body and all bodies that carry it, without MuJoCo's `world` body."""
    found = []
    while body:
        found.append(body)
        body = int(model.body_parentid[body])
    return found


def _standing(robot: Robot, pairs: list[Pair]) -> list[Pair]:
    """Return those of the given pairs whose two shapes touch, or almost touch, in the robot's initial pose."""
    if not pairs:
        return []
    mujoco = needed("mujoco")
    data = robot.at_rest()
    data.qpos[:] = robot.initial
    mujoco.mj_kinematics(robot.model, data)

    def apart(pair: Pair) -> float:
        return float(mujoco.mj_geomDistance(robot.model, data, pair.first, pair.second, 2 * STANDS_ON, None))

    return [pair for pair in pairs if apart(pair) < STANDS_ON]
