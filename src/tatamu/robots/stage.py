"""The robot with its tools and the table as one independent MuJoCo model: a file, and a folder with its meshes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import write_bytes, write_text
from tatamu.robots.clearance import Clearance, Distance
from tatamu.robots.extras import needed, one_line
from tatamu.robots.model import TABLE, Robot, with_tools
from tatamu.robots.modelfile import read_stage
from tatamu.robots.pairs import DISTANCES, link_name
from tatamu.robots.planfile import Planned
from tatamu.robots.pose import frame_pose, into

MODEL = "robot.xml"
ASSETS = "assets"
"""Folder of meshes and height fields, next to the model."""
_SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def _side(axis: int, sign: int) -> np.ndarray:
    """Return the corners of a side of the cube, anticlockwise as seen from outside, shape (4, 3)."""
    corners = np.roll([(sign, *at) for at in _SQUARE], axis, axis=1)
    return corners if sign > 0 else corners[::-1]


CORNERS = np.concatenate([_side(axis, sign) for axis in range(3) for sign in (-1, 1)])
"""Corners of a cube of half size 1, anticlockwise as seen from outside, four for each side, shape (24, 3)."""
FACES = np.array([[4 * k + i for i in triangle] for k in range(6) for triangle in ((0, 1, 2), (0, 2, 3))])
"""Triangles of the cube's sides, shape (12, 3)."""


def stage(robot: Robot, table_height: float, margins: Mapping[str, float] | None = None) -> Any:
    """Build the model with the table top at a height in the base B [m].

    In this model, two shapes can touch only if the checks of a plan compare these two shapes.

    Args:
        robot: The robot.
        table_height: Height of the table top in the base B [m].
        margins: Limit for the distance of each kind of pair [m]; 0 by default. Pairs below their limit count as
            touching.

    Returns:
        The model, a mujoco.MjSpec.
    """
    spec = with_tools(robot.spec, robot.arms)
    table = spec.geom(TABLE)
    table.pos = [0, 0, robot.at_rest().body(robot.base).xpos[2] + table_height - table.size[2]]
    for geom in spec.geoms:
        geom.contype = geom.conaffinity = 0
    for pair in list(spec.pairs):
        spec.delete(pair)
    for kind, first, second in Clearance(robot, table=table_height).pairs:
        spec.add_pair(geomname1=first, geomname2=second, margin=(margins or {}).get(kind, 0.0))
    spec.add_key(name="start", qpos=robot.initial)
    return spec


def touches(robot: Robot, table_height: float, configurations: np.ndarray) -> dict[str, Distance]:
    """Return the smallest distance of each kind of pair of shapes, if it is below the limit in `DISTANCES`.

    This is a second check in addition to `Clearance`, and shares only the list of pairs with it: MuJoCo's collision
    detection finds the pairs that are near, in every one of n configurations of the robot.

    Args:
        robot: The robot.
        table_height: Height of the table top in the base B [m].
        configurations: Angles of all nq joints in n configurations [rad], shape (n, nq).
    """
    mujoco = needed("mujoco")
    limits = {kind: limit.allowed for kind, limit in DISTANCES.items()}
    model = stage(robot, table_height, limits).compile()
    pairs = {}  # the kind and the two links of each pair of shapes that is tested
    for kind, *names in Clearance(robot, table=table_height).pairs:
        first, second = (int(model.geom(name).id) for name in names)
        pairs[frozenset((first, second))] = (kind, (link_name(model, first), link_name(model, second)))
    data = mujoco.MjData(model)
    found: dict[str, Distance] = {}
    for row, q in enumerate(configurations):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_collision(model, data)
        for contact in contacts(data):
            kind, links = pairs[frozenset(contact.geom.tolist())]
            if contact.dist < limits[kind] and (kind not in found or contact.dist < found[kind].value):
                found[kind] = Distance(float(contact.dist), row, links)
    return found


def contacts(data: Any) -> Iterator[Any]:
    """Yield MuJoCo's contacts. To iterate over `data.contact` takes half a millisecond, even if it is empty."""
    return (data.contact[number] for number in range(data.ncon))


def save_stage(robot: Robot, table_height: float, folder: Path) -> None:
    """Write the model as an MJCF file, together with every file that the model names."""
    spec = stage(robot, table_height)
    spec.compile()
    used = {asset.file for asset in (*spec.meshes, *spec.hfields)}
    for name, content in spec.assets.items():
        if name in used:
            write_bytes(folder / ASSETS / name, content)
    spec.meshdir = spec.texturedir = ASSETS
    write_text(folder / MODEL, str(spec.to_xml()))


def load_stage(folder: Path) -> Any:
    """Read the model of a plan's folder as a mujoco.MjSpec.

    Raises:
        InputError: If the model does not exist, or MuJoCo cannot read it.
    """
    path = folder / MODEL
    if not path.is_file():
        raise InputError(f"{path}: must exist; run `tatamu plan` again")
    try:
        return read_stage(path)
    except ValueError as error:
        raise InputError(
            f"{path}: is not a model that MuJoCo can read ({one_line(error)}); run `tatamu plan` again"
        ) from None


def data_of(model: Any) -> Any:
    """Return a new mujoco.MjData of a compiled stage in the robot's start pose.

    A stage is the model of the robot and the table.
    """
    mujoco = needed("mujoco")
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    return data


class Poser:
    """Moves a compiled stage, which contains the robot and the table, to the poses of a plan's joints and fingers."""

    def __init__(self, model: Any, planned: Planned, angles: np.ndarray, times: np.ndarray) -> None:
        """Prepare the poses at n times [s], where the plan's j joints have these angles [rad], shape (n, j).

        Raises:
            InputError: If the model lacks a joint.
        """
        fingers = planned.fingers(times)
        try:
            columns = [int(model.joint(name).qposadr[0]) for name in (*planned.plan.joints, *fingers)]
        except KeyError as error:
            text = f"must have the joints of the plan ({one_line(error)}); run `tatamu plan` again"
            raise InputError(f"{planned.folder / MODEL}: {text}") from None
        self.poses = len(angles)
        self.data = data_of(model)
        self._model, self._columns = model, columns
        self._positions = np.column_stack([angles, *fingers.values()])

    def pose(self, row: int) -> Any:
        """Return the mujoco.MjData in one of the prepared poses, with computed kinematics."""
        self.data.qpos[self._columns] = self._positions[row]
        needed("mujoco").mj_kinematics(self._model, self.data)
        return self.data


def link_boxes(planned: Planned, angles: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return boxes around a robot's links over time, in the fold's frame F, for the replay of a rehearsal.

    The boxes are the corners of b boxes in f frames [m], shape (f, 24 b, 3), and their triangles, shape (12 b, 3).

    Args:
        planned: The plan.
        angles: Angles of the plan's j joints at each frame [rad], shape (f, j).
        times: Times of the frames [s], shape (f,). They determine whether the fingers are open.
    """
    model = load_stage(planned.folder).compile()
    poser = Poser(model, planned, angles, times)
    shown = [k for k in link_shapes(model) if np.isfinite(model.geom_rbound[k])]
    middle, half = model.geom_aabb[shown, :3], model.geom_aabb[shown, 3:]
    corners = middle[:, None] + half[:, None] * CORNERS  # in the own frame of each shape
    found = []
    for row in range(len(angles)):
        data = poser.pose(row)
        turned = np.einsum("bij,bkj->bki", data.geom_xmat[shown].reshape(-1, 3, 3), corners)
        base = data.body(planned.plan.base_frame)
        in_base = into(frame_pose(base), (turned + data.geom_xpos[shown][:, None]).reshape(-1, 3))
        found.append(into(planned.plan.task_in_base.matrix, in_base))
    faces = (FACES + 24 * np.arange(len(shown))[:, None, None]).reshape(-1, 3)
    return np.array(found), faces


def link_shapes(model: Any) -> list[int]:
    """Return the numbers of a model's shapes, except the table and planes."""
    plane = needed("mujoco").mjtGeom.mjGEOM_PLANE
    return [k for k in range(model.ngeom) if model.geom(k).name != TABLE and model.geom_type[k] != plane]
