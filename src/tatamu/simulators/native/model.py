"""A scene's cloth made ready for the compiled loops: constants, memory layout, step sizes."""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import blake2b
from math import ceil
from threading import Lock
from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, eigsh

from tatamu.material import Material
from tatamu.scene import Cloth
from tatamu.simulators.native import bending, candidates, membrane
from tatamu.simulators.native.layout import Bands, bands, slots, turned, turned_hinges
from tatamu.topology import Topology, areas, edge_lengths, lumped

OUTER_STEP = 1e-3
"""Contact and friction are resolved at least this often [s]."""
MEMBRANE_PHASE, BENDING_PHASE = 1.25, 1.0
"""Largest h omega of the explicit steps; 2 is the limit of stability, the rest is room for large deformation."""
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
    weights: np.ndarray  # (5, places)
    others: np.ndarray  # (5, places)
    rest_moment: np.ndarray  # (places,)


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
        return _kept[key]


def _build(cloth: Cloth, material: Material) -> Model:
    rest = cloth.rest
    slot, count = slots(rest, Topology(cloth.faces).hinges)
    faces = turned(cloth.faces, slot)
    topology = Topology(faces)
    triangles, hinges = bands(slot[faces], count), bands(slot[turned_hinges(topology.hinges, slot)], count)
    frames = membrane.rest_frames(rest, faces)
    S, L2, R = membrane.constants(frames, material)
    weights, others = bending.constants(
        rest, topology, frames, _seams(topology, cloth.seams), material.bending_rigidity
    )
    mass = lumped(areas(rest, faces) * material.areal_density, faces, len(rest))
    gradient, angle = hinge_gradients(rest, topology.hinges)
    rest_moment = (weights * angle[others]).sum(0)
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
            hinges.spread(weights).astype(np.float32),
            _placed(others, hinges),
            hinges.spread(rest_moment).astype(np.float32),
        ),
        mesh=_contact_mesh(topology, mass, material.thickness, np.sqrt(L2.max())),
        membrane_step=MEMBRANE_PHASE / _membrane_frequency(rest, faces, S, mass),
        bending_step=BENDING_PHASE / _bending_frequency(gradient, weights, others, mass),
        thickness=material.thickness,
        lengths=edge_lengths(rest, topology.edges),
    )


def _placed(others: np.ndarray, hinges: Bands) -> np.ndarray:
    """Hinge numbers as places; fillers point at themselves."""
    out = np.tile(np.arange(hinges.size), (5, 1))
    place = hinges.place
    out[:, place] = place[others]
    return out


def _seams(topology: Topology, seams: np.ndarray) -> np.ndarray:
    """Which hinges are seams, shape (h,)."""
    named = {tuple(sorted(seam)) for seam in seams.tolist()}
    return np.array([tuple(sorted(pair)) in named for pair in topology.hinges[:, :2].tolist()], dtype=bool)


def hinge_gradients(rest: np.ndarray, hinges: np.ndarray) -> tuple[sparse.csr_array, np.ndarray]:
    """D theta / d x at rest as a matrix, shape (h, 3n), and g at rest, shape (h,)."""
    count = len(hinges)
    X = np.ascontiguousarray(rest[hinges.T.ravel()].T)
    table = np.array([[0, count, 0, count, 2 * count, 3 * count]])
    H = np.zeros((10, count))
    bending.measure(X, table, H)
    d2, d3, t2, t3 = H[0:3], H[3:6], H[6], H[7]
    parts = [-(1 - t2) * d2 - (1 - t3) * d3, -t2 * d2 - t3 * d3, d2, d3]
    rows = np.tile(np.arange(count), 12)
    columns = np.concatenate([3 * hinges[:, i] + k for i in range(4) for k in range(3)])
    values = np.concatenate([part[k] for part in parts for k in range(3)])
    flat = np.where(np.abs(H[8]) < 1e-9, 0.0, H[8])
    return sparse.csr_array((values, (rows, columns)), shape=(count, 3 * len(rest))), flat


def _membrane_frequency(rest: np.ndarray, faces: np.ndarray, S: np.ndarray, mass: np.ndarray) -> float:
    """Largest angular frequency of the membrane at rest [1/s]."""
    count = len(faces)
    rows = np.broadcast_to(np.arange(3 * count).reshape(count, 3, 1, 1), (count, 3, 3, 3))
    columns = np.broadcast_to((3 * faces[:, None, :, None] + np.arange(3)), (count, 3, 3, 3))
    gradient = sparse.csr_array(
        (membrane.gradients(rest, faces).ravel(), (rows.ravel(), columns.ravel())),
        shape=(3 * count, 3 * len(rest)),
    )
    full = 0.5 * S[[0, 1, 2, 1, 3, 4, 2, 4, 5]].T.reshape(count, 3, 3)
    stiffness = sparse.bsr_array((full, np.arange(count), np.arange(count + 1)))
    return _largest_frequency(gradient, stiffness, mass)


def _bending_frequency(gradient: sparse.csr_array, weights: np.ndarray, others: np.ndarray, mass: np.ndarray) -> float:
    """Largest angular frequency of bending at rest [1/s]."""
    count = weights.shape[1]
    if not weights.any():
        return 1e-9
    stiffness = sparse.csr_array((weights.ravel(), (np.tile(np.arange(count), 5), others.ravel())))
    return _largest_frequency(gradient, stiffness, mass)


def _largest_frequency(gradient: sparse.csr_array, stiffness: sparse.sparray, mass: np.ndarray) -> float:
    """Largest omega of G' K G u = omega^2 M u."""
    scaled = gradient @ sparse.diags_array(1.0 / np.sqrt(np.repeat(mass, 3)))
    size = scaled.shape[1]
    if size < 40:
        return float(np.sqrt(np.linalg.eigvalsh((scaled.T @ (stiffness @ scaled)).toarray()).max()))
    operator = LinearOperator((size, size), matvec=lambda u: scaled.T @ (stiffness @ (scaled @ u)), dtype=float)
    start = np.cos(np.arange(size) * 2.399963)  # any fixed vector with all frequencies in it
    top = eigsh(operator, k=1, which="LA", v0=start, tol=1e-2, return_eigenvectors=False)
    return float(1.01 * np.sqrt(top[0]))


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
