"""The embedded simulator: explicit, multirate, on the processor. docs/theory/native.md derives it."""

from tatamu.simulators.native.memory.kernel_cache import forget_stale_kernels

forget_stale_kernels()  # before any kernel is loaded

from tatamu.simulators.capabilities import Capabilities  # noqa: E402
from tatamu.simulators.native.compiled import compilation  # noqa: E402
from tatamu.simulators.native.options import (  # noqa: E402
    ContactOptions,
    ElasticOptions,
    LimitOptions,
    Options,
    RestOptions,
    StepOptions,
    UntangleOptions,
)
from tatamu.simulators.native.simulation import Simulation  # noqa: E402
from tatamu.simulators.native.simulator import load_kernels, simulate, simulate_many  # noqa: E402
from tatamu.simulators.native.snapshot import SimulationState  # noqa: E402
from tatamu.simulators.native.targets import HandTarget  # noqa: E402

CAPABILITIES = Capabilities(
    parallel=True,
    coarse_search=True,
    compression=True,
    orthotropy=True,
    hysteresis=True,
    directional_air=True,
    bodies=True,
)
"""A rollout runs on one core without a lock; bending is accurate on cells on which other simulators crease."""


def require() -> None:
    """Do nothing, because `native` needs no other program."""


def prepare() -> None:
    """Compile the kernels, or read them from disk."""
    load_kernels()


__all__ = [
    "CAPABILITIES",
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
