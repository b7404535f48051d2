"""Wavefront OBJ: vertices, triangles, their texture coordinates, and the names of the parts they belong to."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.errors import InputError


@dataclass(frozen=True)
class TriangleMesh:
    """A mesh as a file has it."""

    vertices: np.ndarray
    """In the file's unit, shape (n, 3)."""
    faces: np.ndarray
    """Triangles, shape (m, 3)."""
    uv: np.ndarray | None = None
    """Texture coordinates of each triangle's corners, shape (m, 3, 2)."""
    parts: tuple[str, ...] = ()
    """Name of the part of each triangle, m of them; empty where the file names none."""

    def kept(self, faces: np.ndarray) -> TriangleMesh:
        """The mesh of some of its triangles, chosen by a mask (m,)."""
        used, index = np.unique(self.faces[faces], return_inverse=True)
        return TriangleMesh(
            self.vertices[used],
            index.reshape(-1, 3),
            None if self.uv is None else self.uv[faces],
            tuple(part for part, keep in zip(self.parts, faces, strict=True) if keep) if self.parts else (),
        )


def read_obj(path: Path) -> TriangleMesh:
    """The mesh of an OBJ file; faces with more corners are cut into triangles.

    Comments and names may be in any encoding: only the numbers matter.

    Raises:
        InputError: The file cannot be read, or a line of it is wrong.
    """
    try:
        text = path.read_bytes().decode("utf-8", "replace")
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
    reader = _Reader()
    for number, line in enumerate(text.replace("\\\n", " ").replace("\\\r\n", " ").splitlines(), start=1):
        words = line.split("#", 1)[0].split()
        try:
            reader.take(words)
        except (ValueError, IndexError):
            shown = line.strip()[:40]
            raise InputError(f"{path}: is not a mesh file (line {number}, {shown!r}, is no OBJ)") from None
    return reader.mesh()


class _Reader:
    """The part of an OBJ file read so far."""

    def __init__(self) -> None:
        self.vertices: list[list[float]] = []
        self.texture: list[list[float]] = []
        self.faces: list[tuple[int, int, int]] = []
        self.corners: list[tuple[int, int, int]] = []
        self.parts: list[str] = []
        self.part = ""

    def take(self, words: list[str]) -> None:
        """Read the words of one line."""
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
        for k in range(1, len(corners) - 1):
            self.faces.append((places[0], places[k], places[k + 1]))
            self.corners.append((images[0], images[k], images[k + 1]))
            self.parts.append(self.part)

    def mesh(self) -> TriangleMesh:
        """The mesh that was read."""
        vertices = np.array(self.vertices, dtype=float).reshape(-1, 3)
        corners = np.array(self.corners, dtype=np.int64).reshape(-1, 3)
        mapped = bool(len(corners)) and bool((corners >= 0).all())
        uv = np.array(self.texture, dtype=float)[corners] if mapped else None
        named = tuple(self.parts) if len(set(self.parts)) > 1 else ()
        return TriangleMesh(vertices, np.array(self.faces, dtype=np.int64).reshape(-1, 3), uv, named)


def _index(word: str, count: int) -> int:
    """A number of a vertex from 0, of one from 1 or, counted from the end, from -1."""
    number = int(word)
    place = number - 1 if number > 0 else count + number
    if not 0 <= place < count:
        raise IndexError
    return place
