"""The simulator `native`: explicit time steps on the processor, without other programs (docs/theory/native.md)."""

from tatamu.simulation.native.compiled import forget_stale_kernels

forget_stale_kernels()  # must run before any kernel is loaded

from collections.abc import Sequence  # noqa: E402
from functools import partial  # noqa: E402
from time import perf_counter  # noqa: E402

import numpy as np  # noqa: E402

from tatamu.base.version import __version__  # noqa: E402
from tatamu.simulation.native.compiled import compilation as compilation  # noqa: E402
from tatamu.simulation.native.grippers import HandTarget as HandTarget  # noqa: E402
from tatamu.simulation.native.led_bodies import BodyTarget as BodyTarget  # noqa: E402
from tatamu.simulation.native.options import ContactOptions as ContactOptions  # noqa: E402
from tatamu.simulation.native.options import ElasticOptions as ElasticOptions  # noqa: E402
from tatamu.simulation.native.options import LimitOptions as LimitOptions  # noqa: E402
from tatamu.simulation.native.options import Options as Options  # noqa: E402
from tatamu.simulation.native.options import RestOptions as RestOptions  # noqa: E402
from tatamu.simulation.native.options import StepOptions as StepOptions  # noqa: E402
from tatamu.simulation.native.options import UntangleOptions as UntangleOptions  # noqa: E402
from tatamu.simulation.native.precompile import smallest_scene  # noqa: E402
from tatamu.simulation.native.simulation import Simulation as Simulation  # noqa: E402
from tatamu.simulation.native.snapshot import SimulationState as SimulationState  # noqa: E402
from tatamu.simulation.rollout import Rollout  # noqa: E402
from tatamu.simulation.scene import Scene  # noqa: E402
from tatamu.simulation.side_by_side import side_by_side  # noqa: E402
from tatamu.simulation.simulators import Capabilities  # noqa: E402

CAPABILITIES = Capabilities(
    parallel=True,
    coarse_search=True,
    compression=True,
    orthotropy=True,
    hysteresis=True,
    directional_air=True,
    bodies=True,
)
"""Rollouts do not hold Python's lock, so they run side by side. Bending is accurate even on large cells."""


def require() -> None:
    """Do nothing, because this simulator needs no other program."""


def prepare() -> None:
    """Compile the kernels of the simplest scenes, or load their compiled code from disk."""
    Simulation(smallest_scene()).frames()


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
