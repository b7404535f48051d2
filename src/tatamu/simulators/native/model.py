"""A scene's cloth made ready for the compiled loops: constants, memory layout, step sizes."""

from __future__ import annotations

import ctypes
import sys
from dataclasses import dataclass
from hashlib import blake2b
from math import ceil
from threading import Lock
from typing import NamedTuple

import numpy as np
from scipy import sparse

from tatamu.material import Material
from tatamu.scene import Cloth
from tatamu.simulators.native.contact import broad_phase as candidates
from tatamu.simulators.native.elastic import bending, membrane
from tatamu.simulators.native.elastic.stable_step import (
    bending_frequency,
    hinge_gradients,
    hinge_stiffness,
    membrane_frequency,
)
from tatamu.simulators.native.memory.bands import bands, slots, turned, turned_hinges
from tatamu.topology import Topology, among, areas, edge_lengths, lumped

OUTER_STEP = 1e-3
"""Contact and friction are resolved at least this often [s]."""
MEMBRANE_PHASE, BENDING_PHASE = 1.25, 1.0
"""Largest h omega of the explicit steps; 2 is the limit of stability, the rest is room for large deformation."""
UPPER = [0, 1, 2, 4, 5, 8]
"""Where the upper triangle of a symmetric matrix, 3 x 3, stands in its nine elements."""
DENSEST_PAIRS = 24
"""Edge pairs kept per edge at most."""


class Elastic(NamedTuple):
    """Constants of the elastic forces, per place of their bands."""

    triangles: np.ndarray  # band table
    triangle_copies: np.ndarray
    S: np.ndarray  # (6, places)
    L2: np.ndarray  # (3, places)
    R: np.ndarray  # (12, places) of cloth that wrinkles, (12, 0) of other cloth
    compression: np.float32
    hinges: np.ndarray  # band table
    hinge_copies: np.ndarray
    rest_moment: np.ndarray  # (places,)
    curls: np.ndarray  # band table of triangles over places of hinges
    curl_copies: np.ndarray
    K: np.ndarray  # (6, places of curls)


@dataclass(frozen=True)
class Model:
    """Everything about cloth and material that no scene changes."""

    slot: np.ndarray
    """Slot of each vertex, shape (n,)."""
    slots: int
    """Slots with vertices or fillers; copies come behind."""
    width: int
    """Slots and copies together."""
    mass: np.ndarray
    """Lumped mass of each vertex [kg], shape (n,)."""
    elastic: Elastic
    mesh: candidates.Mesh
    membrane_step: float
    """Largest step of the membrane [s]."""
    bending_step: float
    """Largest step of the bending [s]."""
    thickness: float
    """How far layers rest apart [m]."""
    lengths: np.ndarray
    """Of the edges at rest [m], shape (e,)."""

    @property
    def shortest(self) -> float:
        """Shortest edge at rest [m]."""
        return float(self.lengths.min())


_kept: dict[bytes, Model] = {}
_keeping = Lock()  # simulate_many runs scenes in threads
_MOST_KEPT = 16


def model_of(cloth: Cloth, material: Material) -> Model:
    """The model of a cloth; the last few are kept, as a study simulates one cloth many times."""
    digest = blake2b(digest_size=16)
    for array in (cloth.rest, cloth.faces, cloth.seams):
        digest.update(repr(array.shape).encode() + np.ascontiguousarray(array).tobytes())
    digest.update(material.model_dump_json().encode())
    key = digest.digest()
    with _keeping:
        if key not in _kept:
            while len(_kept) >= _MOST_KEPT:
                _kept.pop(next(iter(_kept)))
            _kept[key] = _build(cloth, material)
            _give_back_memory()
        return _kept[key]


def _give_back_memory() -> None:
    """Return to the system what building took: glibc would keep it, some 25 MB at 13,000 vertices."""
    if sys.platform == "linux":
        getattr(ctypes.CDLL(None), "malloc_trim", int)(0)


def _build(cloth: Cloth, material: Material) -> Model:
    rest = cloth.rest
    slot, count = slots(rest, Topology(cloth.faces).hinges)
    faces = turned(cloth.faces, slot)
    topology = Topology(faces)
    triangles, hinges = bands(slot[faces], count), bands(slot[turned_hinges(topology.hinges, slot)], count)
    frames = membrane.rest_frames(rest, faces)
    S, L2, R = membrane.constants(frames, material)
    free = among(topology.hinges[:, :2], cloth.seams)
    K, at = bending.constants(rest, topology, frames, free, material.bending_rigidity)
    curls = bands(hinges.place[at], hinges.size)
    mass = lumped(areas(rest, faces) * material.areal_density, faces, len(rest))
    gradient, angle = hinge_gradients(rest, topology.hinges)
    stiffness = hinge_stiffness(K, at, len(topology.hinges))
    return Model(
        slot=slot,
        slots=count,
        width=count + max(len(triangles.copied), len(hinges.copied)),
        mass=mass,
        elastic=Elastic(
            triangles.table,
            triangles.copied,
            triangles.spread(S).astype(np.float32),
            triangles.spread(L2),
            (triangles.spread(R) if R.size else R).astype(np.float32),
            np.float32(material.compression),
            hinges.table,
            hinges.copied,
            hinges.spread(stiffness @ angle).astype(np.float32),
            curls.table,
            curls.copied,
            curls.spread(K.reshape(-1, 9).T[UPPER]).astype(np.float32),
        ),
        mesh=_contact_mesh(topology, mass, material.thickness, np.sqrt(L2.max())),
        membrane_step=MEMBRANE_PHASE / membrane_frequency(rest, faces, S, mass),
        bending_step=BENDING_PHASE / bending_frequency(gradient, stiffness, mass),
        thickness=material.thickness,
        lengths=edge_lengths(rest, topology.edges),
    )


def _contact_mesh(topology: Topology, mass: np.ndarray, thickness: float, longest: float) -> candidates.Mesh:
    faces, count = topology.faces, len(mass)
    edge_faces = np.full((len(topology.edges), 2), -1)
    order = np.argsort(topology.face_edges.T.ravel(), kind="stable")
    edge, face = topology.face_edges.T.ravel()[order], order % len(faces)
    second = np.r_[False, edge[1:] == edge[:-1]]
    edge_faces[edge[~second], 0] = face[~second]
    edge_faces[edge[second], 1] = face[second]
    across = edge_faces[topology.face_edges]
    own = np.arange(len(faces))[:, None]
    neighbours = np.where(across[..., 0] == own, across[..., 1], across[..., 0])
    start, near = _near_faces(faces, count)
    margin = thickness + max(3.0 * thickness, min(0.01, 0.75 * longest))
    return candidates.Mesh(
        np.ascontiguousarray(faces),
        np.ascontiguousarray(neighbours),
        start,
        near,
        np.ascontiguousarray(topology.edges),
        edge_faces,
        np.ascontiguousarray(topology.face_edges),
        1.0 / mass,
        np.array([thickness, margin, 0.58 * longest]),
    )


def _near_faces(faces: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Triangles with a corner that is the vertex or shares an edge with it, as start and list."""
    rows = np.repeat(np.arange(len(faces)), 3)
    incident = sparse.csr_array((np.ones(3 * len(faces)), (faces.ravel(), rows)), shape=(count, len(faces)))
    adjacent = incident @ incident.T
    near = (adjacent @ incident).tocsr()
    near.sort_indices()
    return near.indptr.astype(np.int64), near.indices.astype(np.int64)


def steps_per_frame(frame_rate: float) -> int:
    """Outer steps that make one frame."""
    return max(1, ceil(1.0 / (frame_rate * OUTER_STEP) - 1e-9))


def substeps(model: Model, step: float) -> tuple[int, int]:
    """Bending steps per outer step, and membrane steps per bending step."""
    bends = max(1, ceil(step / model.bending_step))
    return bends, max(1, ceil(step / bends / model.membrane_step))
