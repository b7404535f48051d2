"""Simulators by name. A simulator is a function from a Scene to a Rollout; each has its own folder."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import Protocol, cast

from tatamu.errors import InputError
from tatamu.rollout import Rollout
from tatamu.scene import Scene
from tatamu.simulators.capabilities import Capabilities


class Simulator(Protocol):
    """The names that the module of a simulator has."""

    CAPABILITIES: Capabilities
    """The simulator's capabilities; callers read them instead of comparing names."""

    def require(self) -> None:
        """Check for programs that it needs in addition to tatamu.

        Raises:
            InputError: It is not installed.
        """
        ...

    def prepare(self) -> None:
        """Do the work that the first rollout would wait for, such as compiling."""
        ...

    def compilation(self) -> tuple[int, int]:
        """Return the number of its compiled functions on disk (0 if none had to be compiled), and their total."""
        ...

    def simulate(self, scene: Scene) -> Rollout:
        """Run one scene.

        Raises:
            SimulationError: The rollout passed a limit of the model.
        """
        ...

    def simulate_many(self, scenes: Sequence[Scene]) -> list[Rollout]:
        """Run several scenes; the same positions as one by one."""
        ...


SIMULATORS: dict[str, str | Simulator] = {
    "native": "tatamu.simulators.native",
    "blender": "tatamu.simulators.blender",
    "mujoco": "tatamu.simulators.mujoco",
}
"""Name of each simulator and the module that is a `Simulator`, imported when first used, or one that was registered."""


def named(name: str) -> Simulator:
    """The simulator called `name`.

    Raises:
        InputError: There is none of that name.
    """
    if name not in SIMULATORS:
        raise InputError(f"simulator: must be one of {', '.join(SIMULATORS)}, given {name!r}")
    found = SIMULATORS[name]
    return cast(Simulator, import_module(found)) if isinstance(found, str) else found


def register_simulator(name: str, simulator: Simulator) -> None:
    """Add a simulator, so that `simulate(scene, name)`, tasks and checks use it.

    Args:
        name: Name of the simulator.
        simulator: A module or an object with the attributes of `Simulator`.

    Raises:
        InputError: If a simulator of that name exists.
    """
    if name in SIMULATORS:
        raise InputError(f"name: must be new, given {name!r}, which is a simulator already")
    SIMULATORS[name] = simulator


def capabilities(name: str) -> Capabilities:
    """The abilities and limits of the simulator called `name`.

    Raises:
        InputError: There is none of that name.
    """
    return named(name).CAPABILITIES


def require(*names: str) -> None:
    """Refuse simulators that cannot run here, before any work is done for them.

    Raises:
        InputError: If there is none of that name, or a program that it needs is not installed.
    """
    for name in names:
        named(name).require()


def simulate(scene: Scene, simulator: str = "native") -> Rollout:
    """Make a rollout of a scene in the simulator of that name."""
    return named(simulator).simulate(scene)


def simulate_many(scenes: Sequence[Scene], simulator: str = "native") -> list[Rollout]:
    """Make rollouts of several scenes; the same positions as one by one."""
    return named(simulator).simulate_many(scenes)
