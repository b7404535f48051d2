"""Records of arrays and numbers that the time steps read and write. Compiled loops receive them directly."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.native.addresses import Addresses
from tatamu.simulation.native.air import Air, AirSurface
from tatamu.simulation.native.contact.bodies.state import Bodies
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactMesh, ContactState
from tatamu.simulation.native.contact.table import TablePlane
from tatamu.simulation.native.elastic.bending import HingeMeasures
from tatamu.simulation.native.model import ElasticModel
from tatamu.simulation.native.options import ContactOptions, LimitOptions


class State(NamedTuple):
    """Positions and velocities of the cloth, and temporary memory.

    Elastic forces use the arrays by slot, and contact uses them by vertex.
    """

    X: np.ndarray
    """Positions in slots and copies of slots [m], shape (3, width)."""
    V: np.ndarray
    """Velocities in slots [m/s], shape (3, slots)."""
    Y: np.ndarray
    """Positions at which forces are computed, in slots and copies of slots [m], shape (3, width)."""
    F: np.ndarray
    """Forces in slots and copies of slots [N], in single precision, shape (3, width).

    Between substeps they are zero."""
    inverse_mass: np.ndarray
    """Inverse mass of the vertex in each slot [1/kg], shape (slots,).

    It is 0 for held vertices and for slots without a vertex."""
    free: np.ndarray
    """Whether gravity and drag move the vertex in each slot, shape (slots,).

    It is 0 for held vertices and for slots without a vertex, and 1 for all other slots."""
    slot: np.ndarray
    """Slot of each vertex, shape (n,)."""
    positions: Positions
    """Positions by vertex, for contact. Their fields `start` and `predicted` refer to one round of contact."""
    triangle_forces: np.ndarray
    """Temporary memory: forces of a block of triangles on their corners [N], in single precision, shape (9 BLOCK,)."""
    hinges: HingeMeasures
    """Temporary memory for the hinges of bending, in single precision."""
    surface: AirSurface
    """Normals of the cloth's surface, and the air that it carries."""


class Hands(NamedTuple):
    """Held vertices and the paths of the grippers that hold them."""

    vertex: np.ndarray
    """Indices of the k held vertices, shape (k,)."""
    base: np.ndarray
    """Positions of these vertices when their gripper closed [m], shape (k, 3)."""
    gripper: np.ndarray
    """Number of the gripper that holds each vertex, shape (k,)."""
    path: np.ndarray
    """Displacements of the grippers at the start of each outer step [m], shape (grippers, outer steps + 1, 3)."""


class StepSizes(NamedTuple):
    """Lengths of the three kinds of time steps: outer steps, bending steps and membrane steps."""

    outer_step: float
    """Length H of an outer step [s]."""
    kick: float
    """Length of a bending step [s]."""
    substep: float
    """Length h of a membrane step [s]."""
    kicks: int
    """Number of bending steps in an outer step."""
    substeps_per_kick: int
    """Number of membrane steps in a bending step."""
    damping: float
    """Time constant tau_d of the membrane's Kelvin-Voigt damping [s]."""


class System(NamedTuple):
    """A running scene without its hands: all data that a step reads and writes."""

    state: State
    elastic: ElasticModel
    mesh: ContactMesh
    contact: ContactState
    air: Air
    bodies: Bodies
    plane: TablePlane
    sizes: StepSizes
    options: ContactOptions
    limits: LimitOptions
    kernels: Addresses


class Span(NamedTuple):
    """A range of outer steps to simulate."""

    first: int
    """Number of the first step."""
    last: int
    """Number of the step after the last step."""
    per_frame: int
    """Number of outer steps in a frame."""
