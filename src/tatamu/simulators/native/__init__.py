"""The embedded simulator: explicit, multirate, on the processor. docs/native.md derives it."""

from tatamu.simulators.native.memory.kernel_cache import forget_stale_kernels

forget_stale_kernels()  # before any kernel is loaded

from tatamu.simulators.native.options import (  # noqa: E402
    ContactOptions,
    ElasticOptions,
    LimitOptions,
    Options,
    StepOptions,
    UntangleOptions,
)
from tatamu.simulators.native.simulator import simulate, simulate_many  # noqa: E402

__all__ = [
    "ContactOptions",
    "ElasticOptions",
    "LimitOptions",
    "Options",
    "StepOptions",
    "UntangleOptions",
    "simulate",
    "simulate_many",
]
