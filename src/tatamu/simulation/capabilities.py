"""Capabilities and limits of a simulator. Other modules read them, instead of testing which simulator is used."""

from __future__ import annotations

from dataclasses import dataclass

from tatamu.base.errors import InputError
from tatamu.simulation.material import DIRECTIONAL_AIR, ORTHOTROPIC_BENDING, ORTHOTROPIC_MEMBRANE, Material
from tatamu.simulation.scene import Scene


@dataclass(frozen=True)
class Capabilities:
    """The capabilities and limits of a simulator.

    By default, a simulator has no capability and no limit.
    """

    parallel: bool = False
    """Whether several threads of one process can call `simulate` at the same time, without a change of the results."""
    coarse_search: bool = False
    """Whether folds can be learned on a mesh that is coarser than the garment's own."""
    compression: bool = False
    """Whether the simulator can simulate cloth that resists compression less than tension (`Material.compression`).

    If it cannot, cloth resists compression and tension equally."""
    orthotropy: bool = False
    """Whether cloth can have separate stiffnesses for warp, weft, shear and bias. If not, cloth is isotropic."""
    hysteresis: bool = False
    """Whether bending can have internal friction (`Material.bending_hysteresis`). If not, bending is elastic."""
    directional_air: bool = False
    """Whether air can have directional drag, quadratic drag and added mass. If not, only `Material.air_drag` acts."""
    bodies: bool = False
    """Whether cloth can collide with rigid bodies (`Scene.bodies`). If not, scenes with bodies are refused."""
    sound_cell: float | None = None
    """Largest mean edge length of a mesh on which folds have the right shape; None if not limited.

    The unit is the bending length of the cloth (`Material.bending_length`)."""
    usable_cell: float | None = None
    """Largest mean edge length of a mesh on which two folds can be compared; None if not limited.

    The unit is the bending length of the cloth (`Material.bending_length`)."""
    friction_table: float | None = None
    """Largest Coulomb coefficient between cloth and table; None if not limited.

    Larger coefficients are reduced to this limit."""
    friction_cloth: float | None = None
    """Largest Coulomb coefficient between layers of cloth; None if not limited.

    Larger coefficients are reduced to this limit."""

    def refuse(self, scene: Scene, name: str) -> None:
        """Raise an error if the simulator, whose name is `name`, cannot simulate a scene at all.

        Raises:
            InputError: If the scene has rigid bodies and the simulator does not support them.
        """
        if scene.bodies and not self.bodies:
            raise InputError(
                f"bodies: must be none for {name}, which cannot do rigid bodies, given {len(scene.bodies)}; "
                f"simulate the scene with native"
            )

    def lacking(self, material: Material) -> list[str]:
        """Return a line of text for each property of a material that the simulator cannot represent."""
        lines = []
        own = [name for name in (*ORTHOTROPIC_MEMBRANE, *ORTHOTROPIC_BENDING) if getattr(material, name) is not None]
        if own and not self.orthotropy:
            lines.append(f"all directions are alike, without {', '.join(own)}")
        if material.bending_hysteresis > 0.0 and not self.hysteresis:
            lines.append("bending springs back, without bending_hysteresis")
        if material.directional_air and not self.directional_air:
            given = [name for name in DIRECTIONAL_AIR if getattr(material, name) > 0.0]
            lines.append(f"air acts by air_drag alone, without {', '.join(given)}")
        return lines
