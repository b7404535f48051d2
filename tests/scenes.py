"""Small scenes that several tests use."""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
from tests.physics.scenes import joined

CLOTH = Material(
    areal_density=0.2,
    stretch_stiffness=300.0,
    poisson_ratio=0.25,
    bending_rigidity=1.5e-5,
    thickness=0.001,
    friction_table=0.5,
    friction_cloth=0.5,
)


def sheet(width: float = 0.1, length: float = 0.2, spacing: float = 0.02, height: float = 0.0) -> Cloth:
    """A flat sheet centred at the origin at some height."""
    vertices, faces = staggered_rectangle(width, length, spacing)
    vertices[:, 2] = height
    return Cloth(vertices=vertices, faces=faces)


def together(*sheets: Cloth) -> Cloth:
    """Sheets that share nothing, as one cloth."""
    vertices, faces, _ = joined([(each.vertices, each.faces) for each in sheets])
    return Cloth(vertices=vertices, faces=faces)


def seamed() -> Cloth:
    """A strip that hinges on a seam across its middle."""
    strip = sheet(0.1, 0.24)
    line = np.flatnonzero(np.abs(strip.vertices[:, 0]) < 1e-6)
    line = line[np.argsort(strip.vertices[line, 1])]
    return Cloth(vertices=strip.vertices, faces=strip.faces, seams=np.column_stack([line[:-1], line[1:]]))


def scene(**changes: Any) -> Scene:
    """A sheet over a table; anything may be changed."""
    parts: dict[str, Any] = {
        "cloth": sheet(height=CLOTH.thickness / 2),
        "material": CLOTH,
        "table": Table(),
        "duration": 0.5,
    }
    return Scene(**{**parts, **changes})


def held(vertices: np.ndarray, **changes: Any) -> Gripper:
    """A hand that holds vertices still from the start."""
    parts: dict[str, Any] = {"vertices": vertices.tolist(), "times": [0.0], "displacements": [[0.0, 0.0, 0.0]]}
    return Gripper(**{**parts, **changes})
