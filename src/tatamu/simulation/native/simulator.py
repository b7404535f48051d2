"""Functions that simulate a `Scene` and return a `Rollout`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from time import perf_counter

import numpy as np

from tatamu.base.version import __version__
from tatamu.simulation.native.options import Options
from tatamu.simulation.native.precompile import smallest_scene
from tatamu.simulation.native.simulation import Simulation
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.side_by_side import side_by_side


def simulate(scene: Scene, options: Options | None = None) -> Rollout:
    """Simulate one scene, or raise SimulationError if it fails; without options, the defaults are used."""
    started = perf_counter()
    simulation = Simulation(scene, options)
    setup = perf_counter() - started
    positions = simulation.frames()
    info = {
        "simulator": "native",
        "version": __version__,
        "wall_seconds": perf_counter() - started - setup,
        "setup_seconds": setup,
        "steps": simulation.number,
        "substeps": simulation.substeps,
        "warnings": simulation.warnings(),
    }
    return Rollout(np.arange(scene.frames) / scene.frame_rate, positions, np.array(scene.cloth.faces), info)


def simulate_many(scenes: Sequence[Scene], options: Options | None = None) -> list[Rollout]:
    """Simulate several scenes in parallel, one per processor; of several errors, the first is raised."""
    return side_by_side(partial(simulate, options=options), scenes)


def load_kernels() -> None:
    """Compile the kernels of the simplest scenes, or load their compiled code from disk."""
    Simulation(smallest_scene()).frames()
