"""Reads Wavefront OBJ files: vertices, triangles, texture coordinates, and names of the mesh's parts.

Faces that have more than three corners are cut into triangles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from tatamu.base.errors import InputError
from tatamu.simulation.mesh.topology import twice_areas

MAX_TRIANGLES = 200_000
"""Maximum number of triangles; with a tenth of it, simulations take minutes."""
MAX_VERTICES = 3 * MAX_TRIANGLES
"""Maximum number of vertices: three for each triangle, as in STL files."""


@dataclass(frozen=True)
class TriangleMesh:
    """A triangle mesh that was read from a file."""

    vertices: np.ndarray
    """Positions of the vertices in the file's unit, shape (n, 3)."""
    faces: np.ndarray
    """Triangles, shape (m, 3)."""
    uv: np.ndarray | None = None
    """Texture coordinates of each triangle's corners, if the file has them, shape (m, 3, 2)."""
    parts: tuple[str, ...] = ()
    """Name of each triangle's part; empty if the file names none."""

    def kept(self, faces: np.ndarray) -> TriangleMesh:
        """Return the mesh of the triangles in the mask `faces`, shape (m,)."""
        used, index = np.unique(self.faces[faces], return_inverse=True)
        return TriangleMesh(
            self.vertices[used],
            index.reshape(-1, 3),
            None if self.uv is None else self.uv[faces],
            tuple(part for part, keep in zip(self.parts, faces, strict=True) if keep) if self.parts else (),
        )


def parse_obj(data: bytes) -> TriangleMesh:
    """Read the mesh in the bytes of an OBJ file; faces with more than three corners are cut into triangles.

    Comments and names may be in any encoding, because only the numbers matter.
    """
    text = data.decode("utf-8", "replace")
    reader = _Reader()
    for number, line in enumerate(text.replace("\\\n", " ").replace("\\\r\n", " ").splitlines(), start=1):
        try:
            if len(line) > 100_000:
                raise ValueError(f"lines must have at most 100000 characters, given {len(line)}")
            reader.take(line.split("#", 1)[0].split())
        except (ValueError, IndexError, OverflowError) as error:
            shown = line.strip()[:40]
            reason = f": {error}" if str(error) and not isinstance(error, IndexError) else ""
            raise ValueError(f"line {number} is not valid in an OBJ file: {shown!r}{reason}") from None
    return reader.mesh()


class _Reader:
    def __init__(self) -> None:
        self.vertices: list[list[float]] = []
        self.texture: list[list[float]] = []
        self.faces: list[tuple[int, int, int]] = []
        self.corners: list[tuple[int, int, int]] = []
        self.parts: list[str] = []
        self.part = ""

    def take(self, words: list[str]) -> None:
        if len(self.faces) > MAX_TRIANGLES or max(len(self.vertices), len(self.texture)) > MAX_VERTICES:
            raise InputError(f"mesh: must have at most {MAX_TRIANGLES} triangles and {MAX_VERTICES} vertices")
        match words[:1]:
            case ["v"]:
                self.vertices.append([float(words[1]), float(words[2]), float(words[3])])
            case ["vt"]:
                self.texture.append([float(words[1]), float(words[2]) if len(words) > 2 else 0.0])
            case ["f"]:
                self._face([word.split("/") for word in words[1:]])
            case ["o"] | ["g"]:
                self.part = " ".join(words[1:]) or self.part

    def _face(self, corners: list[list[str]]) -> None:
        places = [_index(corner[0], len(self.vertices)) for corner in corners]
        images = [_index(c[1], len(self.texture)) if len(c) > 1 and c[1] else -1 for c in corners]
        own = np.array([self.vertices[place] for place in places])
        for a, b, c in triangulate(range(len(places)), own):
            self.faces.append((places[a], places[b], places[c]))
            self.corners.append((images[a], images[b], images[c]))
            self.parts.append(self.part)

    def mesh(self) -> TriangleMesh:
        vertices = np.array(self.vertices, dtype=float).reshape(-1, 3)
        corners = np.array(self.corners, dtype=np.int64).reshape(-1, 3)
        mapped = bool(len(corners)) and bool((corners >= 0).all())
        uv = np.array(self.texture, dtype=float)[corners] if mapped else None
        named = tuple(self.parts) if len(set(self.parts)) > 1 else ()
        return TriangleMesh(vertices, np.array(self.faces, dtype=np.int64).reshape(-1, 3), uv, named)


def _index(word: str, count: int) -> int:
    """Return the index of a vertex, which counts from 1 in the file, or back from the last one with -1."""
    number = int(word)
    place = number - 1 if number > 0 else count + number
    if not 0 <= place < count:
        raise IndexError
    return place


def triangulate(corners: Sequence[int], vertices: np.ndarray) -> list[tuple[int, int, int]]:
    """Cut a face of a mesh into triangles that have the orientation of the face, as indices into `corners`.

    A convex face becomes a fan around its first corner. A concave face is projected onto the plane that fits it best
    (Newell's normal), and divided inside its outline. `vertices` are those of the whole mesh, shape (n, 3).

    Raises:
        ValueError: If the face has fewer than three corners or too many, or it touches or crosses itself.
    """
    count = len(corners)
    if not 3 <= count <= 2_000:
        raise ValueError(f"faces must have 3 to 2000 corners, given {count}")
    fan = [(0, k, k + 1) for k in range(1, count - 1)]
    if count == 3:
        return fan
    flat = _in_plane(vertices[list(corners)])
    if (twice_areas(flat, np.array(fan)) >= 0.0).all() or not np.isfinite(flat).all():
        return fan
    return _divided(flat)


def _in_plane(points: np.ndarray) -> np.ndarray:
    """Return the points of a face in its plane, counter-clockwise about its normal, shape (k, 2)."""
    with np.errstate(all="ignore"):
        around = points - points.mean(axis=0)
        around /= max(float(np.abs(around).max()), 1e-300)
        normal = np.cross(around, np.roll(around, -1, axis=0)).sum(axis=0)
        across = np.eye(3)[int(np.abs(normal).argmin())]
        first = np.cross(across, normal)
        first /= max(float(np.linalg.norm(first)), 1e-300)
        second = np.cross(normal, first)
        second /= max(float(np.linalg.norm(second)), 1e-300)
    return np.column_stack([around @ first, around @ second])


def _divided(flat: np.ndarray) -> list[tuple[int, int, int]]:
    """Return triangles that fill a concave outline."""
    outline = shapely.Polygon(flat)
    place = {(float(x), float(y)): k for k, (x, y) in enumerate(flat)}
    if not outline.is_valid or len(place) < len(flat):
        raise ValueError(f"a face of {len(flat)} corners touches or crosses itself")
    found = []
    for triangle in shapely.get_parts(shapely.constrained_delaunay_triangles(outline)):
        a, b, c = (place[x, y] for x, y in triangle.normalize().exterior.coords[:3])
        found.append((a, c, b))  # normalised rings are clockwise
    return sorted(found)
