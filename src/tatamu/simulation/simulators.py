"""Simulators by name. From a `Scene`, a simulator computes the motion of the cloth, a `Rollout`.

Each simulator is a folder of this package.
"""

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
    """Capabilities and limits of the simulator. Callers read this value instead of comparing the simulator's name."""

    def require(self) -> None:
        """Check that the programs which the simulator needs are installed.

        Raises:
            InputError: If a program is not installed.
        """
        ...

    def prepare(self) -> None:
        """Compile functions, and make other preparations, so that the first rollout need not wait for them."""
        ...

    def compilation(self) -> tuple[int, int]:
        """Return the progress of compilation: the number of compiled functions on disk, and the number to be compiled.

        The first number is 0 if this process did not have to compile any function.
        """
        ...

    def simulate(self, scene: Scene) -> Rollout:
        """Simulate one scene.

        Raises:
            SimulationError: If the rollout exceeded a limit of the model.
        """
        ...

    def simulate_many(self, scenes: Sequence[Scene]) -> list[Rollout]:
        """Simulate several scenes. The positions are the same as if each scene were simulated alone."""
        ...


SIMULATORS: dict[str, str | Simulator] = {
    "native": "tatamu.simulation.native",
    "blender": "tatamu.simulation.blender",
    "mujoco": "tatamu.simulation.mujoco",
}
"""All simulators by name. Each is a module, given by its import path, or an object with the same functions.

A module is imported when it is first used."""


def named(name: str) -> Simulator:
    """Return the simulator that has this name.

    Raises:
        InputError: If no simulator has this name.
    """
    if name not in SIMULATORS:
        raise InputError(f"simulator: must be one of {', '.join(SIMULATORS)}, given {name!r}")
    found = SIMULATORS[name]
    return cast(Simulator, import_module(found)) if isinstance(found, str) else found


def register_simulator(name: str, simulator: Simulator) -> None:
    """Add a simulator, so that it can be used by its name, for example in `simulate(scene, name)`.

    Args:
        name: Name of the simulator.
        simulator: A module or an object with the attributes of `Simulator`.

    Raises:
        InputError: If a simulator with this name exists.
    """
    if name in SIMULATORS:
        raise InputError(f"name: must be new, given {name!r}, which is a simulator already")
    SIMULATORS[name] = simulator


def capabilities(name: str) -> Capabilities:
    """Return the capabilities and limits of the simulator that has this name.

    Raises:
        InputError: If no simulator has this name.
    """
    return named(name).CAPABILITIES


def require(*names: str) -> None:
    """Check that the simulators with these names can run on this machine. Call this function before long work starts.

    Raises:
        InputError: If a name is unknown, or a program that one of the simulators needs is not installed.
    """
    for name in names:
        named(name).require()


def simulate(scene: Scene, simulator: str = "native") -> Rollout:
    """Simulate a scene with the simulator of a given name, and return the rollout."""
    return named(simulator).simulate(scene)


def simulate_many(scenes: Sequence[Scene], simulator: str = "native") -> list[Rollout]:
    """Simulate several scenes, and return their rollouts.

    The positions are the same as if each scene were simulated alone.
    """
    return named(simulator).simulate_many(scenes)
