"""The data of a scene at its start, as the compiled loops read and write them."""

from __future__ import annotations

import numpy as np

from tatamu.simulation.native.addresses import NONE
from tatamu.simulation.native.air import Air, air_of, surface_of
from tatamu.simulation.native.contact.bodies.state import bodies_of
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.contact.state import initial_state
from tatamu.simulation.native.contact.table import TablePlane
from tatamu.simulation.native.elastic import bending, hysteresis
from tatamu.simulation.native.memory.bands import BLOCK
from tatamu.simulation.native.model import Model, model_of, steps_per_frame, substeps
from tatamu.simulation.native.options import Options, StepOptions
from tatamu.simulation.native.system import State, StepSizes, System
from tatamu.simulation.scene import Scene


def step_sizes(scene: Scene, model: Model, options: StepOptions) -> StepSizes:
    """Return the lengths of the time steps of a scene."""
    outer_step = 1.0 / (scene.frame_rate * steps_per_frame(scene.frame_rate, options.outer_step))
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
    return System(
        state=_state(scene, model, air),
        elastic=model.elastic,
        mesh=mesh,
        contact=initial_state(mesh, options.contact.pairs_per_edge),
        air=air,
        bodies=bodies_of(scene.bodies, scene.grippers, sizes.outer_step, steps_of(scene, sizes), mesh),
        plane=_plane(scene),
        sizes=sizes,
        options=options.contact._replace(restored=np.array(options.contact.restored)),
        limits=options.limits,
        kernels=NONE,
    )


def steps_of(scene: Scene, sizes: StepSizes) -> int:
    """Return the number of outer steps of a scene."""
    return int(scene.duration / sizes.outer_step + 1e-6)


def _plane(scene: Scene) -> TablePlane:
    tilt = scene.table.tilt if scene.table else 0.0
    return TablePlane(
        present=scene.table is not None,
        height=scene.table.height if scene.table else 0.0,
        sine=float(np.sin(tilt)),
        cosine=float(np.cos(tilt)),
        half_thickness=0.5 * scene.material.thickness,
        friction=scene.material.friction_table,
    )


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
