"""Simulators by name. A simulator is a function from a `Scene` to a `Rollout`. Each simulator has its own folder."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Protocol, cast

from tatamu.errors import InputError
from tatamu.rollout import Rollout
from tatamu.scene import Scene
from tatamu.simulators.capabilities import Capabilities


class Simulator(Protocol):
    """The functions and values that the module of a simulator must contain."""

    CAPABILITIES: Capabilities
    """What the simulator can do, and its limits. Callers read these instead of comparing names."""

    def require(self) -> None:
        """Check that the programs which the simulator needs are installed.

        Raises:
            InputError: If a program is not installed.
        """
        ...

    def prepare(self) -> None:
        """Do work in advance for which the first rollout would otherwise wait, such as compiling."""
        ...

    def compilation(self) -> tuple[int, int]:
        """Return how many of the simulator's compiled functions are on disk, and how many it has.

        The first number is 0 if no function had to be compiled.
        """
        ...

    def simulate(self, scene: Scene) -> Rollout:
        """Simulate one scene.

        Raises:
            SimulationError: If the rollout exceeded a limit of the model.
        """
        ...

    def simulate_many(self, scenes: Sequence[Scene]) -> list[Rollout]:
        """Simulate several scenes. The positions are equal to those of single simulations."""
        ...


SIMULATORS: dict[str, str | Simulator] = {
    "native": "tatamu.simulators.native",
    "blender": "tatamu.simulators.blender",
    "mujoco": "tatamu.simulators.mujoco",
}
"""Module or object of each simulator, by the simulator's name. A module is imported when it is first used."""


def named(name: str) -> Simulator:
    """Return the simulator with a name.

    Raises:
        InputError: If no simulator has this name.
    """
    if name not in SIMULATORS:
        raise InputError(f"simulator: must be one of {', '.join(SIMULATORS)}, given {name!r}")
    found = SIMULATORS[name]
    return cast(Simulator, import_module(found)) if isinstance(found, str) else found


def register_simulator(name: str, simulator: Simulator) -> None:
    """Add a simulator. After that, `simulate(scene, name)`, tasks and checks can use it.

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
    """Return the capabilities and limits of the simulator with a name.

    Raises:
        InputError: If no simulator has this name.
    """
    return named(name).CAPABILITIES


def require(*names: str) -> None:
    """Check that simulators can run on this machine, before any work is done for them.

    Raises:
        InputError: If no simulator has a given name, or a program that the simulator needs is not installed.
    """
    for name in names:
        named(name).require()


def simulate(scene: Scene, simulator: str = "native") -> Rollout:
    """Simulate a scene with the simulator of a given name, and return the rollout."""
    return named(simulator).simulate(scene)


def simulate_many(scenes: Sequence[Scene], simulator: str = "native") -> list[Rollout]:
    """Simulate several scenes, and return their rollouts. The positions are equal to those of single simulations."""
    return named(simulator).simulate_many(scenes)
