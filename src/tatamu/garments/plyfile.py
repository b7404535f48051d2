"""Reads files in the Polygon File Format (PLY), which are text or binary.

A file has elements (tables), of which the vertices and the faces are read. The header lists the elements with their
lengths and their properties (columns); a property may be a list, such as the corners of a face.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np

from tatamu.base.errors import InputError
from tatamu.garments.objfile import MAX_TRIANGLES, MAX_VERTICES, TriangleMesh, triangulate

TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
}
Order = Literal["<", ">"]
ORDERS: dict[str, Order | None] = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}
"""Byte order of each format; None for text."""


class _Property(NamedTuple):
    name: str
    kind: str
    counted_by: str = ""
    """Type of the number that states the length of each list; empty for single numbers."""


@dataclass
class _Element:
    name: str
    count: int
    properties: list[_Property]

    @property
    def has_lists(self) -> bool:
        return any(each.counted_by for each in self.properties)


def parse_ply(data: bytes) -> TriangleMesh:
    """Read the mesh in the bytes of a PLY file.

    Raises:
        ValueError: If the bytes are not a PLY file, or the file is incomplete.
        InputError: If the mesh has more vertices or faces than a garment's mesh may have.
    """
    order, elements, data = _header(data)
    body = _Body(data, order)
    vertices, polygons = np.empty((0, 3)), list[list[int]]()
    for element in elements:
        try:
            if element.name == "vertex":
                if element.has_lists:
                    raise ValueError("element vertex must not have list properties")
                names = [each.name for each in element.properties]
                vertices = body.table(element)[:, [names.index(axis) for axis in "xyz"]]
            elif element.name == "face":
                polygons = list(body.lists(element))
            elif element.has_lists:
                list(body.lists(element))
            elif element.properties:
                body.table(element)
        except IndexError:
            stated = f"its header states {element.count} {element.name} elements"
            raise ValueError(f"the file ends too early: {stated}") from None
    for number, corners in enumerate(polygons):
        if any(not 0 <= corner < len(vertices) for corner in corners):
            raise ValueError(f"face {number} uses a vertex outside 0 to {len(vertices) - 1}")
    faces = [tuple(each[k] for k in cut) for each in polygons for cut in triangulate(each, vertices)]
    return TriangleMesh(vertices, np.array(faces, dtype=np.int64).reshape(-1, 3))


def _header(data: bytes) -> tuple[Order | None, list[_Element], bytes]:
    """Return the byte order, the elements, and the data after the header."""
    head, mark, body = data.partition(b"end_header")
    lines = [line.split() for line in head.decode("ascii", "replace").splitlines()]
    if not mark or not lines or lines[0] != ["ply"]:
        raise ValueError("the file does not begin with the header of a PLY file")
    stated = ""
    elements: list[_Element] = []
    for words in lines[1:]:
        match words:
            case ["format", name, _] if name in ORDERS:
                stated = name
            case ["element", name, count] if count.isdecimal():
                elements.append(_Element(name, int(count), []))
            case ["property", "list", counted_by, kind, name] if elements:
                elements[-1].properties.append(_Property(name, TYPES[kind], TYPES[counted_by]))
            case ["property", kind, name] if elements:
                elements[-1].properties.append(_Property(name, TYPES[kind]))
            case ["comment" | "obj_info", *_] | []:
                pass
            case _:
                raise ValueError(f"the header contains an unknown line, {' '.join(words)[:40]!r}")
    if not stated:
        raise ValueError("the header does not state a format")
    for element in elements:
        most = MAX_TRIANGLES if element.name == "face" else MAX_VERTICES
        if element.count > most:
            raise InputError(f"mesh: must have at most {most} {element.name} elements, given {element.count}")
    return ORDERS[stated], elements, body[2:] if body.startswith(b"\r\n") else body[1:]


class _Body:
    """The data of a file after its header, which are taken one after the other: bytes, or the words of a text."""

    def __init__(self, data: bytes, order: Order | None) -> None:
        self._data: Any = data.split() if order is None else data
        self._order = order
        self._next = 0

    def table(self, element: _Element) -> np.ndarray:
        """Return an element without lists, shape (count, properties)."""
        if self._order is None:
            width = len(element.properties)
            return np.array(self._taken("u1", width * element.count), dtype=float).reshape(-1, width)
        row = np.dtype([(f"p{k}", each.kind) for k, each in enumerate(element.properties)])
        rows = self._taken(row, element.count)
        return np.column_stack([rows[name].astype(float) for name in row.names or ()])

    def lists(self, element: _Element) -> Iterator[list[int]]:
        """Yield the vertices of each face."""
        for _ in range(element.count):
            corners: list[int] = []
            for each in element.properties:
                count = int(self._taken(each.counted_by, 1)[0]) if each.counted_by else 1
                if count < 0:
                    raise IndexError
                found = self._taken(each.kind, count)
                if each.name in ("vertex_index", "vertex_indices"):
                    corners = [int(value) for value in found]
            yield corners

    def _taken(self, kind: np.dtype[Any] | str, count: int) -> Any:
        """Return the next numbers of a type, or the next words."""
        start, self._next = self._next, self._next + count * (np.dtype(kind).itemsize if self._order else 1)
        if self._next > len(self._data):
            raise IndexError
        part = self._data[start : self._next]
        return np.frombuffer(part, np.dtype(kind).newbyteorder(self._order)) if self._order else part
