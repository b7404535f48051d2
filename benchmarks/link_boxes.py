"""Boxes that contain the collision shapes of a model's links, in the links' frames, as rows for a preset's facts.

    python -m benchmarks.link_boxes MODEL.urdf [--slabs 3] [--packages NAME=FOLDER]

A link is cut across its longest side into slabs, and each slab is boxed: an elbow fills a fraction of one box round it.
"""

from __future__ import annotations

import argparse
from itertools import pairwise
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import trimesh

from tatamu.robots.modelfile import give, read_model


def boxes_of(mesh: trimesh.Trimesh, slabs: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Lower and upper corners of the boxes round a mesh, cut into slabs [m]."""
    low, high = mesh.bounds
    axis = int((high - low).argmax())
    normal = np.eye(3)[axis]
    cuts = np.linspace(low[axis], high[axis], slabs + 1)
    found = []
    for below, above in pairwise(cuts):
        part = mesh.slice_plane(below * normal, normal).slice_plane(above * normal, -normal)
        if len(part.vertices):
            corners = part.bounds.copy()
            corners[:, axis] = below, above
            found.append((corners[0], corners[1]))
    return found


def links_of(model: Any) -> dict[str, trimesh.Trimesh]:
    """The collision meshes of each body, joined, in its frame [m]."""
    found: dict[str, list[trimesh.Trimesh]] = {}
    for geom in range(model.ngeom):
        if not (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            continue
        turned = np.zeros(9)
        mujoco.mju_quat2Mat(turned, model.geom_quat[geom])
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = turned.reshape(3, 3), model.geom_pos[geom]
        shape = _mesh_of(model, geom)
        shape.apply_transform(pose)
        found.setdefault(model.body(model.geom_bodyid[geom]).name, []).append(shape)
    return {name: _joined(shapes) for name, shapes in found.items()}


def _joined(shapes: list[trimesh.Trimesh]) -> trimesh.Trimesh:
    joined = trimesh.util.concatenate(shapes)
    assert isinstance(joined, trimesh.Trimesh)
    return joined


def _mesh_of(model: Any, geom: int) -> trimesh.Trimesh:
    number = int(model.geom_dataid[geom])
    if model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
        middle, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        return trimesh.creation.box(bounds=np.array([middle - half, middle + half]))
    vertices = slice(model.mesh_vertadr[number], model.mesh_vertadr[number] + model.mesh_vertnum[number])
    faces = slice(model.mesh_faceadr[number], model.mesh_faceadr[number] + model.mesh_facenum[number])
    return trimesh.Trimesh(model.mesh_vert[vertices], model.mesh_face[faces], process=False)


def main() -> None:
    """Print the rows."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", type=Path)
    parser.add_argument("--slabs", type=int, default=3)
    parser.add_argument("--packages", nargs="*", default=[])
    options = parser.parse_args()
    read = read_model(options.model, {name: Path(at) for name, at in (pair.split("=") for pair in options.packages)})
    give(read.spec, read.contents)
    for name, mesh in links_of(read.spec.compile()).items():
        print(f'"{name}": (')
        for low, high in boxes_of(mesh, options.slabs):
            corners = (np.floor(1e3 * low) / 1e3 + 0.0, np.ceil(1e3 * high) / 1e3 + 0.0)
            print("    " + str(tuple(tuple(float(x) for x in corner.round(3)) for corner in corners)) + ",")
        print("),")


if __name__ == "__main__":
    main()
