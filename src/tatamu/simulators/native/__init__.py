"""The embedded simulator: explicit, multirate, on the processor. docs/native.md derives it."""

from tatamu.simulators.native.simulator import simulate, simulate_many

__all__ = ["simulate", "simulate_many"]
