"""Reads the triangles of binary glTF 2.0 files (GLB).

Materials, textures, cameras and animations are not looked at. A mesh is placed by the transforms of its nodes or, if it
has a skin, by the skin's joints alone, as glTF says.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.garments.objfile import MAX_TRIANGLES, TriangleMesh

MAX_COUNT = 3 * MAX_TRIANGLES
"""Largest number of elements of an accessor, and of vertices and indices of all meshes."""
NUMBERS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""Numpy types of the components of an accessor, by their number in glTF."""
DRACO = "KHR_draco_mesh_compression"
COMPRESSED = (DRACO, "EXT_meshopt_compression", "KHR_meshopt_compression")
INSTANCES = "EXT_mesh_gpu_instancing"
HARMLESS = (
    *("KHR_mesh_quantization", "KHR_materials", "KHR_texture", "KHR_lights", "KHR_animation", "KHR_xmp"),
    *("EXT_texture", "EXT_lights", "MSFT_texture", "MSFT_packing", "GOOGLE_texture"),
)
"""Beginnings of the extensions without which the shape of a mesh can be read."""
TRIANGLES, STRIP, FAN = 4, 5, 6
"""Numbers of the ways in which the indices of a primitive make triangles."""


def parse_glb(data: bytes) -> TriangleMesh:
    """Read the mesh in the bytes of a GLB file.

    Raises:
        InputError: If the file needs an extension that changes the mesh, keeps data elsewhere, or is too large.
        ValueError: If the bytes are not a GLB file.
    """
    parts = list(_Glb(data).parts())
    if not parts:
        raise InputError("mesh: must contain triangles, given none")
    first = np.cumsum([0, *(len(part.vertices) for part in parts)])
    uv = [part.uv for part in parts if part.uv is not None]
    names = tuple(name for part in parts for name in part.parts)
    return TriangleMesh(
        np.concatenate([part.vertices for part in parts]),
        np.concatenate([part.faces + start for part, start in zip(parts, first[:-1], strict=True)]),
        np.concatenate(uv) if len(uv) == len(parts) else None,
        names if len(set(names)) > 1 else (),
    )


class _Glb:
    """The header and the data of a GLB file."""

    def __init__(self, data: bytes) -> None:
        if data[:4] != b"glTF" or int.from_bytes(data[4:8], "little") != 2:
            raise ValueError("the file does not begin with the header of binary glTF 2")
        chunks: dict[int, bytes] = {}
        place = 12
        while place + 8 <= len(data):
            size, kind = (int.from_bytes(data[place + k : place + k + 4], "little") for k in (0, 4))
            chunks.setdefault(kind, data[place + 8 : place + 8 + size])
            place += 8 + size
        self.header: dict[str, Any] = json.loads(chunks[0x4E4F534A])  # "JSON"
        self.binary = chunks.get(0x004E4942, b"")  # "BIN"
        self.read = 0
        for name in self.header.get("extensionsRequired", ()):
            if not str(name).startswith(HARMLESS):
                raise _unreadable(str(name))
        self.nodes: list[dict[str, Any]] = self.header.get("nodes", [])
        if len(self.nodes) > 10_000:
            raise InputError(f"mesh: must have at most 10000 nodes, given {len(self.nodes)}")
        self.placed = self._placed()

    def parts(self) -> Iterator[TriangleMesh]:
        """Yield the mesh of each primitive with triangles, in the file's frame."""
        for number in self.placed:
            if "mesh" in self.nodes[number]:
                if INSTANCES in self.nodes[number].get("extensions", ()):
                    raise _unreadable(INSTANCES)
                mesh = self.header["meshes"][self.nodes[number]["mesh"]]
                for primitive in mesh["primitives"]:
                    if primitive.get("mode", TRIANGLES) in (TRIANGLES, STRIP, FAN):
                        yield self._part(primitive, mesh, number)

    def _placed(self) -> dict[int, np.ndarray]:
        """Return the matrix of each node of the scene, by the node's index."""
        scenes = self.header.get("scenes")
        below = {child for node in self.nodes for child in node.get("children", ())}
        roots = scenes[self.header.get("scene", 0)].get("nodes", []) if scenes else set(range(len(self.nodes))) - below
        placed: dict[int, np.ndarray] = {}
        waiting = [(number, np.eye(4)) for number in roots]
        while waiting:
            number, outer = waiting.pop()
            if number in placed:
                raise ValueError(f"node {number} has two parents")
            placed[number] = outer @ _transform(self.nodes[number])
            waiting += [(child, placed[number]) for child in self.nodes[number].get("children", ())]
        return dict(sorted(placed.items()))

    def _part(self, primitive: Mapping[str, Any], mesh: Mapping[str, Any], number: int) -> TriangleMesh:
        given, node, matrix = primitive["attributes"], self.nodes[number], self.placed[number]
        if DRACO in primitive.get("extensions", ()) and "bufferView" not in self.header["accessors"][given["POSITION"]]:
            raise _unreadable(DRACO)
        vertices = self.values(given["POSITION"]).astype(float)
        weights = node.get("weights", mesh.get("weights", ()))
        for weight, target in zip(weights, primitive.get("targets", ()), strict=False):
            if weight and "POSITION" in target:
                vertices = vertices + float(weight) * self.values(target["POSITION"])
        indices = self.values(primitive["indices"])[:, 0] if "indices" in primitive else np.arange(len(vertices))
        faces = _triangles(indices.astype(np.int64), primitive.get("mode", TRIANGLES))
        if not 0 <= faces.min(initial=0) <= faces.max(initial=0) < len(vertices):
            raise ValueError(f"a primitive must only use vertices 0 to {len(vertices) - 1}, given {faces.max()}")
        uv = None
        if "TEXCOORD_0" in given:
            uv = (self.values(given["TEXCOORD_0"]) * [1.0, -1.0] + [0.0, 1.0])[faces]  # v points down in glTF
        if "skin" in node:
            vertices = self._skinned(vertices, given, self.header["skins"][node["skin"]])
        else:
            vertices = vertices @ matrix[:3, :3].T + matrix[:3, 3]
            if np.linalg.det(matrix[:3, :3]) < 0.0:  # a mirrored node turns its triangles
                faces, uv = faces[:, ::-1], None if uv is None else uv[:, ::-1]
        name = str(node.get("name") or mesh.get("name") or "")
        return TriangleMesh(vertices, faces, uv, (name,) * len(faces))

    def _skinned(self, vertices: np.ndarray, given: Mapping[str, Any], skin: Mapping[str, Any]) -> np.ndarray:
        """Return the vertices of a skinned mesh, placed by its joints; the transform of its own node does not count."""
        if "JOINTS_0" not in given or "WEIGHTS_0" not in given:
            return vertices
        if not set(skin["joints"]) <= set(self.placed):
            raise ValueError("a joint of a skin is not in the scene")
        joints = np.array([self.placed[number] for number in skin["joints"]])
        if "inverseBindMatrices" in skin:
            bound = self.values(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
            joints = joints @ bound[: len(joints)]
        sets = [k for k in range(8) if f"JOINTS_{k}" in given and f"WEIGHTS_{k}" in given]
        which = np.hstack([self.values(given[f"JOINTS_{k}"]) for k in sets]).astype(np.int64)
        weights = np.hstack([self.values(given[f"WEIGHTS_{k}"]) for k in sets])
        whole = weights.sum(axis=1, keepdims=True)
        blended = np.einsum("nk,nkij->nij", weights / np.where(whole > 0.0, whole, 1.0), joints[which])
        moved = np.einsum("nij,nj->ni", blended[:, :3], np.column_stack([vertices, np.ones(len(vertices))]))
        return np.asarray(np.where(whole > 0.0, moved, vertices))

    def values(self, number: int) -> np.ndarray:
        """Return the numbers of an accessor, shape (count, width). Normalised integers become fractions."""
        accessor = self.header["accessors"][number]
        widths = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
        count, width = int(accessor["count"]), widths[accessor["type"]]
        kind = np.dtype(NUMBERS[accessor["componentType"]])
        self.read += count
        if not 0 <= count <= self.read <= MAX_COUNT * 2:
            raise InputError(f"mesh: must have at most {2 * MAX_COUNT} vertices and indices, given {self.read}")
        found = np.zeros((count, width), kind)
        if "bufferView" in accessor:
            found = self._viewed(accessor, count, width, kind)
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            where, what = sparse["indices"], sparse["values"]
            of = np.dtype(NUMBERS[where["componentType"]])
            found = found.copy()
            found[self._viewed(where, sparse["count"], 1, of)[:, 0]] = self._viewed(what, sparse["count"], width, kind)
        if accessor.get("normalized") and kind.kind in "iu":
            return np.maximum(found / np.iinfo(kind).max, -1.0)
        return found

    def _viewed(self, of: Mapping[str, Any], count: int, width: int, kind: np.dtype[Any]) -> np.ndarray:
        view, offset = self.header["bufferViews"][of["bufferView"]], of.get("byteOffset", 0)
        if view["buffer"] or "uri" in self.header["buffers"][0]:
            for name in set(COMPRESSED) & set(view.get("extensions", ())):
                raise _unreadable(name)
            given = "given vertices in another file or a data URI; export a single .glb file"
            raise InputError(f"mesh: all vertices must be in this file, {given}")
        start, size = view.get("byteOffset", 0), width * kind.itemsize
        stride = view.get("byteStride", size)
        last = start + offset + stride * (count - 1) + size
        if min(start, offset, count - 1) < 0 or stride < size or last > len(self.binary):
            raise ValueError("the file ends too early")
        return np.ndarray((count, width), kind, self.binary, start + offset, (stride, kind.itemsize))


def _unreadable(extension: str) -> InputError:
    how = "without compression" if extension in COMPRESSED else "without this extension"
    return InputError(f"mesh: must not use {extension}, which cannot be read; export the file {how}")


def _transform(node: Mapping[str, Any]) -> np.ndarray:
    """Return the matrix of a node relative to its parent, shape (4, 4)."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    if not abs(x * x + y * y + z * z + w * w - 1.0) < 1e-3:
        raise ValueError(f"a node's rotation must be a unit quaternion, given {node['rotation']}")
    made = np.eye(4)
    made[0, :3] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    made[1, :3] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    made[2, :3] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    made[:3, :3] *= np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=float)
    made[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return made


def _triangles(indices: np.ndarray, mode: int) -> np.ndarray:
    """Return the triangles that a list, a strip or a fan of indices makes, shape (m, 3)."""
    if mode == TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    if mode == FAN:
        return np.column_stack([indices[1:-1], indices[2:], np.full(max(len(indices) - 2, 0), indices[0])])
    strip = np.column_stack([indices[:-2], indices[1:-1], indices[2:]])
    strip[1::2] = strip[1::2, [1, 0, 2]]
    return strip[(strip[:, 0] != strip[:, 1]) & (strip[:, 1] != strip[:, 2]) & (strip[:, 2] != strip[:, 0])]
