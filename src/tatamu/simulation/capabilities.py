"""Capabilities and limits of a simulator, which callers read instead of testing which simulator is used."""

from __future__ import annotations

from dataclasses import dataclass

from tatamu.base.errors import InputError
from tatamu.simulation.material import DIRECTIONAL_AIR, ORTHOTROPIC_BENDING, ORTHOTROPIC_MEMBRANE, Material
from tatamu.simulation.scene import Scene


@dataclass(frozen=True)
class Capabilities:
    """The capabilities and limits of a simulator: by default none."""

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
                f"bodies: must be none for {name}, which cannot do rigid bodies, given {len(scene.bodies)}; "
                f"simulate the scene with native"
            )

    def lacking(self, material: Material) -> list[str]:
        """Return a line for each property of a material that the simulator cannot represent."""
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
