"""Records that time stepping reads and writes: arrays and numbers, which compiled loops take as they are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulators.native.air import Air, AirSurface
from tatamu.simulators.native.contact.bodies.state import Bodies
from tatamu.simulators.native.contact.projection import Positions
from tatamu.simulators.native.contact.state import ContactMesh, ContactState
from tatamu.simulators.native.contact.table import TablePlane
from tatamu.simulators.native.elastic.bending import HingeMeasures
from tatamu.simulators.native.model import ElasticModel
from tatamu.simulators.native.options import ContactOptions, LimitOptions


class State(NamedTuple):
    """Positions and velocities, by slot for the elastic forces and by vertex for contact; and scratch memory."""

    X: np.ndarray
    """Positions in slots and copies [m], shape (3, width)."""
    V: np.ndarray
    """Velocities in slots [m/s], shape (3, slots)."""
    Y: np.ndarray
    """Positions that forces are computed at [m], shape (3, width)."""
    F: np.ndarray
    """Forces in slots and copies [N], single, zero before and after each substep, shape (3, width)."""
    inverse_mass: np.ndarray
    """[1/kg], 0 of held vertices and fillers, shape (slots,)."""
    free: np.ndarray
    """1 of vertices that gravity and drag move, 0 of held vertices and fillers, shape (slots,)."""
    slot: np.ndarray
    """Slot of each vertex, shape (n,)."""
    positions: Positions
    """Positions by vertex; a time step of these is a round of contact."""
    triangle_forces: np.ndarray
    """Scratch: forces of a block of triangles on their corners [N], single, shape (9 BLOCK,)."""
    hinges: HingeMeasures
    """Scratch, single."""
    surface: AirSurface
    """The surface as air meets it."""


class Hands(NamedTuple):
    """Held vertices and their paths."""

    vertex: np.ndarray
    """Shape (k,)."""
    base: np.ndarray
    """Positions where the hand closed [m], shape (k, 3)."""
    gripper: np.ndarray
    """Which gripper holds each, shape (k,)."""
    path: np.ndarray
    """Displacements of the grippers at the beginning of each outer step [m], shape (grippers, outer steps + 1, 3)."""


class StepSizes(NamedTuple):
    """The step sizes of the three rates."""

    outer_step: float
    """H [s]."""
    kick: float
    """Bending step [s]."""
    substep: float
    """Membrane step h [s]."""
    kicks: int
    """Bending steps per outer step."""
    substeps_per_kick: int
    """Membrane steps per bending step."""
    damping: float
    """Time constant tau_d of the membrane's Kelvin-Voigt damping [s]."""


class System(NamedTuple):
    """A running scene without its hands: everything that a step reads and writes."""

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


class Span(NamedTuple):
    """Outer steps to make."""

    first: int
    """Number of the first."""
    last: int
    """Number of the one to stop before."""
    per_frame: int
    """Outer steps per frame."""
