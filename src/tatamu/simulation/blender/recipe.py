"""A recipe: a scene as plain data for the worker, in Blender's units and near Blender's origin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.simulation.blender.mapping import Mapping, mapped
from tatamu.simulation.blender.quads import joined
from tatamu.simulation.scene import Scene, Table
from tatamu.simulation.timeline import Segment, segments

MAX_FRAME = 1.0 / 50.0
"""Maximum length of a frame in Blender [s]; longer frames of a scene are divided."""


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
    pieces = segments(scene, MAX_FRAME if scene.material.blender is None else np.inf)
    longest = max((piece.duration for piece in pieces), default=MAX_FRAME)
    mapping = mapped(scene, longest)
    origin = np.asarray(0.5 * (scene.cloth.vertices.min(0) + scene.cloth.vertices.max(0)))
    request = {
        "gravity": [0.0, 0.0, -scene.gravity * mapping.scale],
        "vertices": _scaled(scene.cloth.vertices, origin, mapping),
        "faces": _faces(scene, mapping),
        "rest": None if scene.cloth.rest_vertices is None else _scaled(scene.cloth.rest, origin, mapping),
        "bends": _bending(scene),
        "grippers": _grippers(scene),
        "settings": mapping.settings,
        "collision": mapping.collision,
        "collider": _collider(scene, origin, mapping),
        "segments": [_segment(scene, piece, mapping) for piece in pieces],
    }
    if len(scene.cloth.seams):
        mapping.warn("edges that end at a seam are half as stiff in bending, because Blender sets stiffness per vertex")
        mapping.settings["bending_stiffness_max"] = mapping.settings["bending_stiffness"]
        mapping.settings["bending_stiffness"] = 0.0
    return Recipe(request, mapping.scale, origin, mapping.settings["quality"] * len(pieces), mapping.warnings)


def _scaled(points: np.ndarray, origin: np.ndarray, mapping: Mapping) -> list[list[float]]:
    scaled: list[list[float]] = ((points - origin) * mapping.scale).tolist()
    return scaled


def _faces(scene: Scene, mapping: Mapping) -> list[list[int]]:
    linear = mapping.settings.get("bending_model") == "LINEAR"
    triangles: list[list[int]] = scene.cloth.faces.tolist()
    return joined(scene.cloth.rest, scene.cloth.faces) if linear else triangles


def _bending(scene: Scene) -> list[int] | None:
    """Return the vertices on no seam, which alone get a bending stiffness; None if the cloth has no seams."""
    if not len(scene.cloth.seams):
        return None
    bends: list[int] = np.setdiff1d(np.arange(len(scene.cloth.vertices)), scene.cloth.seams).tolist()
    return bends


def _grippers(scene: Scene) -> list[dict[str, Any]]:
    return [{"vertices": gripper.vertices, "late": gripper.closes > 0.0} for gripper in scene.grippers]


def _segment(scene: Scene, piece: Segment, mapping: Mapping) -> dict[str, Any]:
    moved = [
        _displacement(gripper.displacement(piece.end), mapping) if held else None
        for gripper, held in zip(scene.grippers, piece.held, strict=True)
    ]
    return {
        "time_scale": mapping.time_scale(piece.duration, scene.frame_rate),
        "wanted": piece.frame,
        "displacements": moved,
    }


def _displacement(displacement: np.ndarray, mapping: Mapping) -> list[float]:
    scaled: list[float] = (displacement * mapping.scale).tolist()
    return scaled


def _collider(scene: Scene, origin: np.ndarray, mapping: Mapping) -> dict[str, Any] | None:
    if scene.table is None:
        return None
    corners = _table_corners(scene, scene.table, mapping.standoff - 0.5 * scene.material.thickness)
    return {"vertices": _scaled(corners, origin, mapping), "settings": mapping.collider}


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
