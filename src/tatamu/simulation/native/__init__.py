"""The simulator `native`: explicit time steps on the processor, without other programs (docs/theory/native.md)."""

from tatamu.simulation.native.memory.kernel_cache import forget_stale_kernels

forget_stale_kernels()  # must run before any kernel is loaded

from tatamu.simulation.native.compiled import compilation  # noqa: E402
from tatamu.simulation.native.led_bodies import BodyTarget  # noqa: E402
from tatamu.simulation.native.options import (  # noqa: E402
    ContactOptions,
    ElasticOptions,
    LimitOptions,
    Options,
    RestOptions,
    StepOptions,
    UntangleOptions,
)
from tatamu.simulation.native.simulation import Simulation  # noqa: E402
from tatamu.simulation.native.simulator import load_kernels, simulate, simulate_many  # noqa: E402
from tatamu.simulation.native.snapshot import SimulationState  # noqa: E402
from tatamu.simulation.native.targets import HandTarget  # noqa: E402
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
    """Compile the kernels, or load their compiled code from disk."""
    load_kernels()


__all__ = [
    "CAPABILITIES",
    "BodyTarget",
    "ContactOptions",
    "ElasticOptions",
    "HandTarget",
    "LimitOptions",
    "Options",
    "RestOptions",
    "Simulation",
    "SimulationState",
    "StepOptions",
    "UntangleOptions",
    "compilation",
    "prepare",
    "require",
    "simulate",
    "simulate_many",
]
