"""Records of arrays and numbers that the time steps read and write, and what they contain at the start of a scene."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.native.addresses import NONE, Addresses
from tatamu.simulation.native.air import Air, AirSurface, air_of, surface_of
from tatamu.simulation.native.bands import BLOCK
from tatamu.simulation.native.contact.bodies.state import Bodies, bodies_of
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import ContactMesh, ContactState, initial_state
from tatamu.simulation.native.contact.table import TablePlane
from tatamu.simulation.native.elastic import bending, hysteresis
from tatamu.simulation.native.elastic.bending import HingeMeasures
from tatamu.simulation.native.model import ElasticModel, Model, model_of, steps_per_frame, substeps
from tatamu.simulation.native.options import ContactOptions, LimitOptions, Options, StepOptions
from tatamu.simulation.scene import Scene, Table


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


def step_sizes(scene: Scene, model: Model, options: StepOptions) -> StepSizes:
    """Return the lengths of the time steps of a scene."""
    per_frame = steps_per_frame(scene.frame_rate, options.outer_step, scene.material.thickness)
    outer_step = 1.0 / (scene.frame_rate * per_frame)
    kicks, substeps_per_kick = substeps(model, outer_step, options)
    kick = outer_step / kicks
    substep = kick / substeps_per_kick
    damping = min(options.membrane_damping, options.damping_part * substep)
    return StepSizes(outer_step, kick, substep, kicks, substeps_per_kick, damping)


def initial_system(scene: Scene, options: Options) -> System:
    """Return the data of a scene at its start, without addresses of kernels."""
    model = model_of(scene.cloth, scene.material, options)
    sizes = step_sizes(scene, model, options.step)
    mesh = model.mesh._replace(inverse_mass=model.mesh.inverse_mass.copy())
    air = air_of(scene.gravity, scene.material)
    table = scene.table or Table()
    return System(
        state=_state(scene, model, air),
        elastic=model.elastic,
        mesh=mesh,
        contact=initial_state(mesh, options.contact.pairs_per_edge),
        air=air,
        bodies=bodies_of(scene.bodies, scene.grippers, sizes.outer_step, steps_of(scene, sizes), mesh),
        plane=TablePlane(
            present=scene.table is not None,
            height=table.height,
            sine=float(np.sin(table.tilt)),
            cosine=float(np.cos(table.tilt)),
            half_thickness=0.5 * scene.material.thickness,
            friction=scene.material.friction_table,
        ),
        sizes=sizes,
        options=options.contact._replace(restored=np.array(options.contact.restored)),
        limits=options.limits,
        kernels=NONE,
    )


def steps_of(scene: Scene, sizes: StepSizes) -> int:
    """Return the number of outer steps of a scene."""
    return int(scene.duration / sizes.outer_step + 1e-6)


def _state(scene: Scene, model: Model, air: Air) -> State:
    count = len(scene.cloth.vertices)
    elastic = model.elastic.bending
    measures = np.concatenate([model.rest_measures, model.rest_measures[elastic.coupling_copies]])
    X = np.zeros((3, model.width))
    X[:, model.slot] = scene.cloth.vertices.T
    inverse_mass = np.zeros(model.slots)
    inverse_mass[model.slot] = 1.0 / model.mass
    free = np.zeros(model.slots)
    free[model.slot] = 1.0
    return State(
        X=X,
        V=np.zeros((3, model.slots)),
        Y=np.zeros_like(X),
        F=np.zeros_like(X, dtype=np.float32),
        inverse_mass=inverse_mass,
        free=free,
        slot=model.slot,
        positions=Positions(
            x=np.array(scene.cloth.vertices, order="C"),
            start=np.empty((count, 3)),
            predicted=np.array(scene.cloth.vertices, order="C"),
        ),
        triangle_forces=np.zeros(9 * BLOCK, dtype=np.float32),
        hinges=bending.scratch(
            elastic.hinges,
            len(elastic.rest_moment),
            len(elastic.coupling_copies),
            slip=hysteresis.unslipped(elastic.friction, measures, elastic.couplings),
        ),
        surface=surface_of(model.slots, count, air),
    )
