"""Simulators by name. Each is a folder of this package and computes a `Rollout` from a `Scene`."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Protocol, cast

from tatamu.base.errors import InputError
from tatamu.simulation.capabilities import Capabilities
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene


class Simulator(Protocol):
    """The functions and values that the module of a simulator must contain."""

    CAPABILITIES: Capabilities

    def require(self) -> None:
        """Raise InputError if a program that the simulator needs is not installed."""
        ...

    def prepare(self) -> None:
        """Compile functions, and do everything else for which the first rollout would have to wait."""
        ...

    def compilation(self) -> tuple[int, int]:
        """Return the number of functions compiled on disk, 0 if this process had to compile none, and of all needed."""
        ...

    def simulate(self, scene: Scene) -> Rollout:
        """Simulate one scene, or raise SimulationError if the rollout exceeds a limit of the model."""
        ...

    def simulate_many(self, scenes: Sequence[Scene]) -> list[Rollout]:
        """Simulate several scenes, with the same positions as if each were simulated alone."""
        ...


SIMULATORS: dict[str, str | Simulator] = {
    "native": "tatamu.simulation.native",
    "blender": "tatamu.simulation.blender",
    "mujoco": "tatamu.simulation.mujoco",
}
"""All simulators by name: an import path, which is imported at its first use, or an object with the same functions."""


def named(name: str) -> Simulator:
    """Return the simulator with this name, or raise InputError."""
    if name not in SIMULATORS:
        raise InputError(f"simulator: must be one of {', '.join(SIMULATORS)}, given {name!r}")
    found = SIMULATORS[name]
    return cast(Simulator, import_module(found)) if isinstance(found, str) else found


def register_simulator(name: str, simulator: Simulator) -> None:
    """Add a module or object with the attributes of `Simulator` by a new name, as in `simulate(scene, name)`."""
    if name in SIMULATORS:
        raise InputError(f"name: must be new, given the existing simulator {name!r}")
    SIMULATORS[name] = simulator


def capabilities(name: str) -> Capabilities:
    """Return the capabilities and limits of the simulator with this name, or raise InputError."""
    return named(name).CAPABILITIES


def require(*names: str) -> None:
    """Raise InputError if a simulator is unknown or cannot run on this machine; call this before long work starts."""
    for name in names:
        named(name).require()


def simulate(scene: Scene, simulator: str = "native") -> Rollout:
    """Simulate a scene with the simulator of this name."""
    return named(simulator).simulate(scene)


def simulate_many(scenes: Sequence[Scene], simulator: str = "native") -> list[Rollout]:
    """Simulate several scenes, with the same positions as if each were simulated alone."""
    return named(simulator).simulate_many(scenes)
