"""Records of arrays and numbers that the time steps read and write, as compiled loops receive them."""

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
    """The motion of the cloth, by slot for elastic forces and by vertex for contact, and temporary memory."""

    X: np.ndarray
    """Positions in slots and copies of slots [m], shape (3, width)."""
    V: np.ndarray
    """Velocities in slots [m/s], shape (3, slots)."""
    Y: np.ndarray
    """Positions at which forces are computed, in slots and copies of slots [m], shape (3, width)."""
    F: np.ndarray
    """Forces in slots and copies [N], shape (3, width), in single precision; zero between substeps."""
    inverse_mass: np.ndarray
    """Inverse mass in each slot [1/kg], shape (slots,); 0 if held or without a vertex."""
    free: np.ndarray
    """1 where gravity and drag move a vertex, and 0 where it is held or missing, shape (slots,)."""
    slot: np.ndarray
    """Slot of each vertex, shape (n,)."""
    positions: Positions
    """Positions by vertex, for contact."""
    triangle_forces: np.ndarray
    """Temporary: forces of a block of triangles on their corners [N], shape (9 BLOCK,), in single precision."""
    hinges: HingeMeasures
    surface: AirSurface


class Hands(NamedTuple):
    """Held vertices and the paths of the grippers that hold them."""

    vertex: np.ndarray
    """Indices of the held vertices, shape (k,)."""
    base: np.ndarray
    """Their positions when their gripper closed [m], shape (k, 3)."""
    gripper: np.ndarray
    """Index of the gripper that holds each of them, shape (k,)."""
    path: np.ndarray
    """Displacements of the grippers at the start of each outer step [m], shape (grippers, outer steps + 1, 3)."""


class StepSizes(NamedTuple):
    """Lengths of the three kinds of time steps."""

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
    """Outer steps from `first` to before `last`."""

    first: int
    last: int
    per_frame: int
    """Number of outer steps in a frame."""
