"""Meshes of garments from files: read as they are, and what is wrong with them said in words."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from tatamu.errors import InputError
from tatamu.garments.objfile import TriangleMesh, read_obj
from tatamu.topology import Topology, areas, longest_sides

FORMATS = (".obj", ".ply", ".stl", ".glb")
SLIVER = 1e-3
"""A triangle with less area than this part of its longest edge squared is degenerate."""


def read_mesh(path: Path) -> TriangleMesh:
    """The mesh of a file, in the file's unit and axes.

    Raises:
        InputError: The file cannot be read, or holds no triangles.
    """
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise InputError(f"{path}: mesh: must be one of {', '.join(FORMATS)}")
    mesh = read_obj(path) if kind == ".obj" else _loaded(path)
    if kind == ".ply":
        _check_whole(path, len(mesh.vertices), len(mesh.faces))
    if not len(mesh.faces):
        raise InputError(f"{path}: mesh: must have triangles, given none")
    if not np.isfinite(mesh.vertices).all():
        raise InputError(f"{path}: mesh: vertices must be finite")
    return mesh.kept(np.ones(len(mesh.faces), dtype=bool))


def _loaded(path: Path) -> TriangleMesh:
    """The mesh of a PLY, STL or GLB file."""
    import trimesh

    kind = path.suffix.lower()
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    try:
        loaded: Any = trimesh.load(
            io.BytesIO(_plain(data, kind)), file_type=kind[1:], force="mesh", process=False, maintain_order=True
        )
        vertices, faces = np.array(loaded.vertices, dtype=float), np.array(loaded.faces, dtype=np.int64)
        image = getattr(loaded.visual, "uv", None) if kind == ".glb" else None
    except Exception as error:  # each of the readers raises its own kinds
        raise InputError(f"{path}: is not a mesh file ({error})") from None
    whole = image is not None and np.shape(image) == (len(vertices), 2) and bool(np.isfinite(image).all())
    return TriangleMesh(vertices, faces, np.asarray(image, dtype=float)[faces] if whole else None)


def _plain(data: bytes, kind: str) -> bytes:
    """The file with question marks in comments where a byte is not ASCII; trimesh would want to guess the encoding."""
    if kind == ".stl":
        count = int.from_bytes(data[80:84], "little")
        return data if len(data) == 84 + 50 * count else _ascii(data)
    if kind == ".ply":
        head, mark, body = data.partition(b"end_header")
        return _ascii(head) + mark + body
    return data


def _ascii(data: bytes) -> bytes:
    return bytes(byte if byte < 128 else ord("?") for byte in data)


def _check_whole(path: Path, vertices: int, faces: int) -> None:
    """Refuse a PLY file that ends before what its header promises: trimesh reads a smaller mesh from it."""
    header = path.read_bytes().split(b"end_header")[0].decode("ascii", "replace")
    elements = [line.split() for line in header.splitlines() if line.startswith("element ")]
    promised = {name: int(number) for _, name, number in elements}
    for name, found in (("vertex", vertices), ("face", faces)):
        if found < promised.get(name, 0):
            raise InputError(f"{path}: is cut short: it promises {promised[name]} of element {name}, and holds {found}")


def welded(mesh: TriangleMesh) -> TriangleMesh:
    """The mesh with vertices at one place made one, and triangles that lose their area left out."""
    number = _places(mesh.vertices)
    first = np.unique(number, return_index=True)[1]
    faces = number[mesh.faces]
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return TriangleMesh(mesh.vertices[first], faces, mesh.uv, mesh.parts).kept(proper)


def _places(vertices: np.ndarray) -> np.ndarray:
    """A number for each vertex, the same for those at one place, shape (n,)."""
    near = 1e-5 * float(np.ptp(vertices, axis=0).max())
    return np.unique(np.round(vertices / max(near, 1e-12)), axis=0, return_inverse=True)[1].ravel()


def faults(vertices: np.ndarray, faces: np.ndarray) -> list[str]:
    """Reasons why a mesh is no cloth, each in a few words; empty if it is one."""
    topology, found = Topology(faces), []
    flat = areas(vertices, faces) < SLIVER * longest_sides(vertices, faces) ** 2
    if flat.any():
        found.append(f"{flat.sum()} triangles without area, the first is {_first(flat)}")
    double = len(vertices) - len(np.unique(_places(vertices)))
    if double:
        found.append(f"{double} vertices at places where there is one already (weld = true joins them)")
    crowded = topology.faces_per_edge > 2
    if crowded.any():
        where = vertices[topology.edges[_first(crowded)]].mean(axis=0)
        found.append(f"{crowded.sum()} edges with more than two triangles, the first at {_place(where)}")
    turned = _turned(topology)
    if turned:
        found.append(f"{turned} edges whose two triangles face opposite ways: the orientation is not consistent")
    return found


def _first(where: np.ndarray) -> int:
    return int(np.argmax(where))


def _place(point: np.ndarray) -> str:
    return "({:.3f}, {:.3f}, {:.3f}) m".format(*point)


def _turned(topology: Topology) -> int:
    """Inner edges that both of their triangles pass in the same direction."""
    sides = np.concatenate([topology.faces[:, [0, 1]], topology.faces[:, [1, 2]], topology.faces[:, [2, 0]]])
    _, passes = np.unique(sides, axis=0, return_counts=True)
    return int((passes == 2).sum())


def pieces(faces: np.ndarray) -> np.ndarray:
    """A number for each triangle, the same for those that hang together, those of most triangles first, shape (m,)."""
    rows, columns = faces.ravel(), np.roll(faces, 1, axis=1).ravel()
    count = int(faces.max()) + 1
    joined = csr_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))
    number = connected_components(joined, directed=False)[1][faces[:, 0]]
    found, sizes = np.unique(number, return_counts=True)
    rank = np.empty(int(found.max()) + 1, dtype=np.int64)
    rank[found[np.argsort(-sizes, kind="stable")]] = np.arange(len(found))
    return rank[number]


def border_loops(faces: np.ndarray) -> list[np.ndarray]:
    """Closed paths of vertices around a mesh whose triangles are counter-clockwise, in their direction, longest first.

    Raises:
        InputError: A vertex has more than two border edges.
    """
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    following: dict[int, int] = {}
    inner = {(b, a) for a, b in sides.tolist()}
    for a, b in sides.tolist():
        if (a, b) in inner:
            continue
        if a in following:
            raise InputError(f"mesh: must touch itself along edges only, but does so in vertex {a} alone")
        following[a] = b
    loops = []
    while following:
        loop = [next(iter(following))]
        while (after := following.pop(loop[-1])) != loop[0]:
            loop.append(after)
        loops.append(np.array(loop))
    return sorted(loops, key=len, reverse=True)
