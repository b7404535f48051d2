"""Reads the meshes of garments from files, and finds faults in a mesh."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from tatamu.base.errors import InputError
from tatamu.base.files import MIB, foreign, read_bytes
from tatamu.garments.glbfile import parse_glb
from tatamu.garments.objfile import MAX_TRIANGLES, TriangleMesh, parse_obj
from tatamu.garments.plyfile import parse_ply
from tatamu.simulation.mesh.topology import Topology, areas, connected, longest_sides

MAX_COORDINATE = 1e9
"""Largest allowed coordinate in a mesh file, in the file's unit."""


def read_mesh(path: Path) -> TriangleMesh:
    """Read the mesh of a file, in the file's unit and axes.

    Raises:
        InputError: If the file cannot be read, or contains no triangles or too many.
    """
    kind = path.suffix.lower()
    if kind not in READERS:
        raise InputError(f"mesh: must be a file of type {', '.join(READERS)}")
    data = read_bytes(path, 64 * MIB)
    with foreign(path, "a GLB file" if kind == ".glb" else "a mesh file"):
        mesh = READERS[kind](data)
    if not len(mesh.faces):
        raise InputError("mesh: must contain triangles, given none")
    if len(mesh.faces) > MAX_TRIANGLES:
        raise InputError(f"mesh: must have at most {MAX_TRIANGLES} triangles, given {len(mesh.faces)}")
    mesh = mesh.kept(np.ones(len(mesh.faces), dtype=bool))
    if not (np.abs(mesh.vertices) < MAX_COORDINATE).all():
        raise InputError(f"mesh: vertices must be finite and lie within {MAX_COORDINATE:g} of the origin")
    return mesh if mesh.uv is None or (np.abs(mesh.uv) < MAX_COORDINATE).all() else replace(mesh, uv=None)


def _parse_stl(data: bytes) -> TriangleMesh:
    import trimesh

    if len(data) != 84 + 50 * int.from_bytes(data[80:84], "little"):  # text, in which names may be in any encoding
        data = bytes(byte if byte < 128 else ord("?") for byte in data)
    loaded: Any = trimesh.load(io.BytesIO(data), file_type="stl", force="mesh", process=False)
    return TriangleMesh(np.array(loaded.vertices, dtype=float), np.array(loaded.faces, dtype=np.int64))


READERS = {".obj": parse_obj, ".ply": parse_ply, ".stl": _parse_stl, ".glb": parse_glb}
"""Function that reads the bytes of each mesh format, by the file name's ending."""


def welded(mesh: TriangleMesh) -> TriangleMesh:
    """Join vertices at the same position, and leave out triangles that then have no area."""
    number = _places(mesh.vertices)
    first = np.unique(number, return_index=True)[1]
    faces = number[mesh.faces]
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return TriangleMesh(mesh.vertices[first], faces, mesh.uv, mesh.parts).kept(proper)


def _places(vertices: np.ndarray) -> np.ndarray:
    """Return an index of each vertex's position, shape (n,), which vertices at the same position share.

    Positions are rounded first, so that fewer are compared; then those that are close but rounded apart are joined.
    """
    near = max(1e-5 * float(np.ptp(vertices, axis=0).max()), 1e-12)
    _, first, cell = np.unique(np.round(vertices / near), axis=0, return_index=True, return_inverse=True)
    return connected(cKDTree(vertices[first]).query_pairs(near, output_type="ndarray"), len(first))[cell.ravel()]


def faults(vertices: np.ndarray, faces: np.ndarray) -> list[str]:
    """Return the faults of a mesh that cannot be used as cloth, each in a few words."""
    topology, found = Topology(faces), []
    flat = areas(vertices, faces) < 1e-3 * longest_sides(vertices, faces) ** 2
    if flat.any():
        found.append(f"{flat.sum()} triangles without area, the first at index {flat.argmax()}")
    double = len(vertices) - len(np.unique(_places(vertices)))
    if double:
        found.append(f"{double} vertices at the places of other vertices (weld = true joins such vertices)")
    twice = len(faces) - len(np.unique(np.sort(faces, axis=1), axis=0))
    if twice:
        found.append(f"{twice} triangles at the places of other triangles; export a single side of the cloth")
    crowded = topology.faces_per_edge > 2
    if crowded.any():
        x, y, z = vertices[topology.edges[crowded.argmax()]].mean(axis=0)
        place = f"({x:.3f}, {y:.3f}, {z:.3f}) m"
        found.append(f"{crowded.sum()} edges with more than two triangles, the first at {place}")
    # the two triangles of an inner edge pass it in opposite directions
    turned = int((np.unique(_sides(faces), axis=0, return_counts=True)[1] == 2).sum())
    if turned:
        found.append(f"{turned} edges whose two triangles face opposite ways: the orientation is not consistent")
    return found


def _sides(faces: np.ndarray) -> np.ndarray:
    """Return the sides of all triangles in their directions, shape (3 m, 2)."""
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def pieces(faces: np.ndarray) -> np.ndarray:
    """Return the index of the connected piece of each triangle, shape (m,), counted from the largest piece."""
    number = connected(_sides(faces), faces.max() + 1)[faces[:, 0]]
    found, sizes = np.unique(number, return_counts=True)
    rank = np.empty(int(found.max()) + 1, dtype=np.int64)
    rank[found[np.argsort(-sizes, kind="stable")]] = np.arange(len(found))
    return rank[number]


def fold_edges(topology: Topology, up: np.ndarray) -> np.ndarray:
    """Return the edges between triangles that face up and down, shape (s, 2)."""
    one, other = up[topology.neighbours].T
    return topology.inner_edges[one != other]


def border_loops(faces: np.ndarray) -> list[np.ndarray]:
    """Return the borders of a mesh as closed paths of vertices, in the direction of its triangles, the longest first.

    Raises:
        InputError: If a vertex has more than two border edges.
    """
    sides = _sides(faces).tolist()
    following: dict[int, int] = {}
    inner = {(b, a) for a, b in sides}
    for a, b in sides:
        if (a, b) in inner:
            continue
        if a in following:
            raise InputError(
                f"mesh: parts must touch along edges, but two touch only at vertex {a}; join or separate these parts"
            )
        following[a] = b
    loops = []
    while following:
        loop = [next(iter(following))]
        while (after := following.pop(loop[-1])) != loop[0]:
            loop.append(after)
        loops.append(np.array(loop))
    return sorted(loops, key=len, reverse=True)
