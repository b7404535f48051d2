"""Preparation of a scene's cloth for the compiled loops: constants, memory layout and stable time steps."""

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

from tatamu.simulation.material import Material
from tatamu.simulation.mesh.topology import Topology, among, areas, edge_lengths, lumped
from tatamu.simulation.native.bands import bands, slots, turned, turned_hinges
from tatamu.simulation.native.contact.state import ContactMesh
from tatamu.simulation.native.elastic import bending, curvature, membrane
from tatamu.simulation.native.elastic.bending import Bending
from tatamu.simulation.native.elastic.membrane import Membrane
from tatamu.simulation.native.elastic.stable_step import (
    bending_frequency,
    hinge_gradients,
    hinge_stiffness,
    membrane_frequency,
)
from tatamu.simulation.native.options import ContactOptions, Options, StepOptions
from tatamu.simulation.scene import Cloth


class ElasticModel(NamedTuple):
    """Constants of membrane and bending."""

    membrane: Membrane
    bending: Bending


@dataclass(frozen=True)
class Model:
    """All data that depend on a cloth and its material alone."""

    slot: np.ndarray
    """Slot of each vertex, shape (n,)."""
    slots: int
    """Number of slots, including fillers."""
    width: int
    """Number of slots and of copies of slots together."""
    mass: np.ndarray
    """Lumped mass of each vertex [kg], shape (n,)."""
    elastic: ElasticModel
    mesh: ContactMesh
    membrane_frequency: float
    """Maximum angular frequency of the membrane at rest [1/s]."""
    bending_frequency: float
    """Maximum angular frequency of bending at rest, without friction [1/s]."""
    sticking_frequency: float
    """Maximum angular frequency of bending at rest, while all friction sticks [1/s]; 0 without friction."""
    rest_measures: np.ndarray
    """Measures g = 4 tan(theta / 4) in the unstrained shape [-], in the order of the hinges in memory."""
    lengths: np.ndarray
    """Lengths of the edges at rest [m], shape (e,)."""


_kept: dict[bytes, Model] = {}
_keeping = Lock()  # because simulate_many runs scenes in threads


def model_of(cloth: Cloth, material: Material, options: Options) -> Model:
    """Return the model of a cloth; recent ones are kept, because a study simulates a cloth many times."""
    digest = blake2b(digest_size=16)
    fibre = np.empty((0, 3)) if cloth.fibre is None else cloth.fibre
    for array in (cloth.rest, cloth.faces, cloth.seams, fibre):
        digest.update(repr(array.shape).encode() + np.ascontiguousarray(array).tobytes())
    digest.update(material.model_dump_json().encode())
    digest.update(repr((options.elastic, options.contact)).encode())
    key = digest.digest()
    with _keeping:
        if key in _kept:
            return _kept[key]
    built = _build(cloth, material, options)  # outside the lock, so that other threads can build their models
    with _keeping:
        while len(_kept) >= 48:  # a study simulates about 20 scenarios, each with its own material
            _kept.pop(next(iter(_kept)))
        if sys.platform == "linux":  # give memory back; glibc would keep about 25 MB for a mesh of 13,000 vertices
            getattr(ctypes.CDLL(None), "malloc_trim", int)(0)
        return _kept.setdefault(key, built)


def _build(cloth: Cloth, material: Material, options: Options) -> Model:
    rest = cloth.rest
    slot, count = slots(rest, Topology(cloth.faces).hinges)
    topology = Topology(turned(cloth.faces, slot))
    faces = topology.faces
    mass = lumped(areas(rest, faces) * material.areal_density, faces, len(rest))
    frames = membrane.rest_frames(rest, faces)
    if material.orthotropic_membrane or material.orthotropic_bending:
        frames = membrane.along_fibres(frames, rest, faces, cloth.fibre)

    S, L2, relaxed = membrane.constants(frames, material)
    triangles = bands(slot[faces], count)
    stretching = membrane.in_bands(triangles, S, L2, relaxed, material.compression, options.elastic.crowding_strain)

    seams = among(topology.hinges[:, :2], cloth.seams)
    curved = curvature.maps(rest, topology, frames, seams, options.elastic.angle_sum_part)
    K = curvature.stiffness(curved, curvature.rigidities(material))
    gradient, g0 = hinge_gradients(rest, topology.hinges)
    stiffness = hinge_stiffness(K, curved.hinges, len(topology.hinges))
    turning = curvature.rigidities(material) + material.friction_stiffness * np.diag([1.0, 1.0, 2.0])
    sticking = hinge_stiffness(curvature.stiffness(curved, turning), curved.hinges, len(topology.hinges))
    hinges = bands(slot[turned_hinges(topology.hinges, slot)], count)
    folding = bending.in_bands(hinges, curved, K, stiffness @ g0, material)

    return Model(
        slot=slot,
        slots=count,
        width=count + max(len(triangles.copied), len(hinges.copied)),
        mass=mass,
        elastic=ElasticModel(stretching, folding),
        mesh=_contact_mesh(topology, mass, material, float(np.sqrt(L2.max())), options.contact),
        membrane_frequency=membrane_frequency(rest, faces, S, mass),
        bending_frequency=bending_frequency(gradient, stiffness, mass),
        sticking_frequency=bending_frequency(gradient, sticking, mass) if material.friction_stiffness else 0.0,
        rest_measures=hinges.spread(g0),
        lengths=edge_lengths(rest, topology.edges),
    )


def _contact_mesh(
    topology: Topology, mass: np.ndarray, material: Material, longest: float, options: ContactOptions
) -> ContactMesh:
    faces = topology.faces
    edge_faces = _faces_of_edges(topology)
    across = edge_faces[topology.face_edges]
    neighbours = np.where(across[..., 0] == np.arange(len(faces))[:, None], across[..., 1], across[..., 0])
    rows = np.repeat(np.arange(len(faces)), 3)
    incident = sparse.csr_array((np.ones(3 * len(faces)), (faces.ravel(), rows)), shape=(len(mass), len(faces)))
    near = (incident @ incident.T @ incident).tocsr()  # the triangles that contain each vertex or its neighbours
    near.sort_indices()
    thickness = material.thickness
    limit = room(thickness) * options.margin_limit
    margin = max(options.margin_thicknesses * thickness, min(limit, options.margin_edges * longest))
    return ContactMesh(
        faces=np.ascontiguousarray(faces),
        neighbours=np.ascontiguousarray(neighbours),
        near_start=near.indptr.astype(np.int64),
        near=near.indices.astype(np.int64),
        edges=np.ascontiguousarray(topology.edges),
        edge_faces=edge_faces,
        face_edges=np.ascontiguousarray(topology.face_edges),
        inverse_mass=1.0 / mass,
        friction=float(material.friction_cloth),
        thickness=float(thickness),
        search_distance=float(thickness + margin),
        triangle_radius=0.58 * longest,  # at least 1 / sqrt(3)
    )


def _faces_of_edges(topology: Topology) -> np.ndarray:
    """Return the triangles of each edge, shape (e, 2), with -1 beyond a border."""
    edge_faces = np.full((len(topology.edges), 2), -1)
    edges = topology.face_edges.T.ravel()
    order = np.argsort(edges, kind="stable")
    edge = edges[order]
    second = np.r_[False, edge[1:] == edge[:-1]]
    edge_faces[edge, second.astype(int)] = order % len(topology.faces)
    return edge_faces


def room(thickness: float) -> float:
    """Return how many times farther layers may move between two resolutions of contact than layers 1 mm thick."""
    return min(max(thickness / 1e-3, 1.0), 2.0)


def steps_per_frame(frame_rate: float, outer_step: float, thickness: float) -> int:
    """Return the number of outer steps in one frame, each at most `outer_step` [s] times `room` long."""
    return max(1, ceil(1.0 / (frame_rate * outer_step * room(thickness)) - 1e-9))


def substeps(model: Model, step: float, options: StepOptions) -> tuple[int, int]:
    """Return the bending steps in an outer step of the length `step` [s], and the membrane steps in each of them."""
    bends = max(1, ceil(step / (options.bending_phase / model.bending_frequency)))
    bends = max(bends, ceil(step * model.sticking_frequency / options.sticking_phase))
    stretches = max(1, ceil(step / bends / (options.membrane_phase / model.membrane_frequency)))
    return bends, stretches
