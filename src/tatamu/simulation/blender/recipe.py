"""A recipe: a scene as plain data for the worker, in Blender's units and near Blender's origin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.simulation.blender.mapping import Mapping, mapped
from tatamu.simulation.mesh.topology import Topology
from tatamu.simulation.scene import Scene, Segment, Table, segments


@dataclass(frozen=True)
class Recipe:
    """The data for the worker, and the numbers that convert its positions back to the scene."""

    request: dict[str, Any]
    scale: float
    origin: np.ndarray
    """Point of the scene that is Blender's origin [m], shape (3,)."""
    steps: int
    """Number of substeps of the whole simulation."""
    warnings: list[str]

    def in_scene(self, positions: np.ndarray) -> np.ndarray:
        """Return Blender's positions in the coordinates of the scene [m]."""
        return np.asarray(positions / self.scale + self.origin)


def written(scene: Scene) -> Recipe:
    """Write the recipe of a scene, or raise InputError if its `blender` table contains an error."""
    frame = 1.0 / 50.0  # maximum length of a frame in Blender [s]; longer frames of a scene are divided
    pieces = segments(scene, frame if scene.material.blender is None else np.inf)
    mapping = mapped(scene, longest=max((piece.duration for piece in pieces), default=frame))
    cloth, settings = scene.cloth, mapping.settings
    origin = np.asarray(0.5 * (cloth.vertices.min(0) + cloth.vertices.max(0)))

    def scaled(points: np.ndarray) -> list[list[float]]:
        moved: list[list[float]] = ((points - origin) * mapping.scale).tolist()
        return moved

    linear = settings.get("bending_model") == "LINEAR"
    request: dict[str, Any] = {
        "gravity": [0.0, 0.0, -scene.gravity * mapping.scale],
        "vertices": scaled(cloth.vertices),
        "faces": joined(cloth.rest, cloth.faces) if linear else cloth.faces.tolist(),
        "rest": None if cloth.rest_vertices is None else scaled(cloth.rest),
        "bends": None,
        "grippers": [{"vertices": gripper.vertices, "late": gripper.closes > 0.0} for gripper in scene.grippers],
        "settings": settings,
        "collision": mapping.collision,
        "collider": None,
        "segments": [_segment(scene, piece, mapping) for piece in pieces],
    }
    if scene.table is not None:
        corners = _table_corners(scene, scene.table, mapping.standoff - 0.5 * scene.material.thickness)
        request["collider"] = {"vertices": scaled(corners), "settings": mapping.collider}
    if len(cloth.seams):  # vertices on no seam alone get a bending stiffness
        request["bends"] = np.setdiff1d(np.arange(len(cloth.vertices)), cloth.seams).tolist()
        mapping.warn("edges that end at a seam are half as stiff in bending, because Blender sets stiffness per vertex")
        settings["bending_stiffness_max"] = settings["bending_stiffness"]
        settings["bending_stiffness"] = 0.0
    return Recipe(request, mapping.scale, origin, settings["quality"] * len(pieces), mapping.warnings)


def joined(points: np.ndarray, faces: np.ndarray) -> list[list[int]]:
    """Return the faces of a mesh, with pairs of triangles joined to quadrilaterals, the most nearly rectangular first.

    Among equally rectangular pairs, those with sides along y come first, because garments have rows along y.
    Quadrilaterals are for the linear bending model that Blender had at the time of the ICMA 2019 paper. On triangles, a
    strip that hangs over an edge droops as if it had no bending stiffness, and it is stretched up to ten times as much
    (measured with Blender 5.0.1).
    """
    topology = Topology(faces)
    corners = topology.hinges[:, [0, 3, 1, 2]]  # in order around the quadrilateral
    across = points[topology.hinges[:, 1]] - points[topology.hinges[:, 0]]
    along_y = np.abs(across[:, 1]) / np.linalg.norm(across, axis=1)
    rows = 0.2  # penalty on the skewness of pairs with a shared edge along y [-], among equally rectangular pairs
    taken = np.zeros(len(faces), dtype=bool)
    quads: list[list[int]] = []
    for number in np.argsort(_skewness(points[corners]) + rows * along_y, kind="stable"):
        pair = topology.neighbours[number]
        if not taken[pair].any():
            taken[pair] = True
            quads.append(corners[number].tolist())
    return quads + faces[~taken].tolist()


def _skewness(corners: np.ndarray) -> np.ndarray:
    """Return the maximum cosine at a corner of each quadrilateral, shape (k,), from corners of the shape (k, 4, 3)."""
    ahead = np.roll(corners, -1, axis=1) - corners
    ahead /= np.linalg.norm(ahead, axis=2, keepdims=True)
    return np.asarray(np.abs(np.einsum("kij,kij->ki", ahead, np.roll(ahead, 1, axis=1))).max(axis=1))


def _segment(scene: Scene, piece: Segment, mapping: Mapping) -> dict[str, Any]:
    moved = [
        (gripper.displacement(piece.end) * mapping.scale).tolist() if held else None
        for gripper, held in zip(scene.grippers, piece.held, strict=True)
    ]
    return {
        "time_scale": mapping.time_scale(piece.duration, scene.frame_rate),
        "wanted": piece.frame,
        "displacements": moved,
    }


def _table_corners(scene: Scene, table: Table, drop: float) -> np.ndarray:
    """Return a triangle `drop` [m] under the table's plane, shape (3, 3), so large that cloth cannot leave it.

    One triangle is faster than two, because Blender tests every triangle of the cloth against each of them.
    """
    points = scene.cloth.vertices
    reach = (
        1.0 + np.linalg.norm(np.ptp(points, axis=0)) + 0.5 * scene.gravity * np.sin(abs(table.tilt)) * scene.duration**2
    )
    for gripper in scene.grippers:
        reach += np.abs(gripper.displacements).max()
    reach = min(float(reach), 500.0)
    low, high = points[:, :2].min(0) - reach, points[:, :2].max(0) + reach
    flat = np.array([low, [2.0 * high[0] - low[0], low[1]], [low[0], 2.0 * high[1] - low[1]]])
    heights = table.height - flat[:, 0] * np.tan(table.tilt)
    normal = np.array([np.sin(table.tilt), 0.0, np.cos(table.tilt)])
    return np.asarray(np.column_stack([flat, heights]) - drop * normal)
