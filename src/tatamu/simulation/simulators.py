"""Simulators by name. Each is a folder of this package and computes a `Rollout` from a `Scene`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Protocol, cast

from tatamu.base.errors import InputError
from tatamu.simulation.material import DIRECTIONAL_AIR, ORTHOTROPIC_BENDING, ORTHOTROPIC_MEMBRANE, Material
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene


@dataclass(frozen=True)
class Capabilities:
    """The capabilities and limits of a simulator, by default none, which callers read instead of testing its name."""

    parallel: bool = False
    """Whether several threads of one process can call `simulate` at once without a change of the results."""
    coarse_search: bool = False
    """Whether folds can be learned on a mesh that is coarser than the garment's own."""
    compression: bool = False
    """Whether cloth can resist compression less than tension (`Material.compression`). If not, both are equal."""
    orthotropy: bool = False
    """Whether cloth can have separate stiffnesses for warp, weft, shear and bias. If not, cloth is isotropic."""
    hysteresis: bool = False
    """Whether bending can have internal friction (`Material.bending_hysteresis`). If not, bending is elastic."""
    directional_air: bool = False
    """Whether air can have directional and quadratic drag and added mass. If not, only `Material.air_drag` acts."""
    bodies: bool = False
    """Whether cloth can collide with rigid bodies (`Scene.bodies`). If not, scenes with bodies are refused."""
    sound_cell: float | None = None
    """Maximum mean edge of a mesh on which folds have the right shape [bending lengths]; None if not limited."""
    usable_cell: float | None = None
    """Maximum mean edge of a mesh on which two folds can be compared [bending lengths]; None if not limited."""
    friction_table: float | None = None
    """Maximum Coulomb coefficient between cloth and table, to which larger ones are reduced; None if not limited."""
    friction_cloth: float | None = None
    """Maximum Coulomb coefficient between layers, to which larger ones are reduced; None if not limited."""

    def refuse(self, scene: Scene, name: str) -> None:
        """Raise InputError if the scene has rigid bodies that the simulator `name` cannot simulate."""
        if scene.bodies and not self.bodies:
            raise InputError(
                f"bodies: {name} cannot simulate rigid bodies, given {len(scene.bodies)}; simulate the scene with "
                "native"
            )

    def lacking(self, material: Material) -> list[str]:
        """Return a line for each property of a material that the simulator cannot represent."""
        lines = []
        own = [name for name in (*ORTHOTROPIC_MEMBRANE, *ORTHOTROPIC_BENDING) if getattr(material, name) is not None]
        if own and not self.orthotropy:
            lines.append(f"{', '.join(own)}: ignored, so the cloth is equally stiff in all directions")
        if material.bending_hysteresis > 0.0 and not self.hysteresis:
            lines.append("bending_hysteresis: ignored, so bending is elastic")
        if material.directional_air and not self.directional_air:
            given = [name for name in DIRECTIONAL_AIR if getattr(material, name) > 0.0]
            lines.append(f"{', '.join(given)}: ignored, so air acts through air_drag only")
        return lines


class Simulator(Protocol):
    """The functions and values that the module of a simulator must contain."""

    CAPABILITIES: Capabilities

    def require(self) -> None:
        """Raise InputError if a program that the simulator needs is not installed."""

    def prepare(self) -> None:
        """Compile functions, and do everything else for which the first rollout would have to wait."""

    def compilation(self) -> tuple[int, int]:
        """Return the number of functions compiled on disk, 0 if this process had to compile none, and of all needed."""

    def simulate(self, scene: Scene) -> Rollout:
        """Simulate one scene, or raise SimulationError if the rollout exceeds a limit of the model."""

    def simulate_many(self, scenes: Sequence[Scene]) -> list[Rollout]:
        """Simulate several scenes, with the same positions as if each were simulated alone."""


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
        raise InputError(f"name: must be new, but there is already a simulator {name!r}")
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
