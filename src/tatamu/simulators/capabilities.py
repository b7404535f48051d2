"""The capabilities and limits that a simulator states, so that callers need not know its name."""

from __future__ import annotations

from dataclasses import dataclass

from tatamu.errors import InputError
from tatamu.material import DIRECTIONAL_AIR, ORTHOTROPIC_BENDING, ORTHOTROPIC_MEMBRANE, Material
from tatamu.scene import Scene


@dataclass(frozen=True)
class Capabilities:
    """The abilities and limits of a simulator; the defaults are the usual case."""

    parallel: bool = False
    """Whether `simulate` may be called in several threads of one process, with the same results."""
    coarse_search: bool = False
    """Whether a coarser mesh ranks folds nearly as the default mesh does, so that a search may start on it."""
    compression: bool = False
    """Whether cloth may resist compression less than tension (`Material.compression`); otherwise equally."""
    orthotropy: bool = False
    """Whether warp, weft, shear and bias may have separate stiffnesses; otherwise cloth is isotropic."""
    hysteresis: bool = False
    """Whether bending may have friction (`Material.bending_hysteresis`); otherwise it is elastic."""
    directional_air: bool = False
    """Whether air has directional and quadratic drag and added mass; otherwise only `air_drag` acts."""
    bodies: bool = False
    """Whether cloth may collide with rigid bodies (`Scene.bodies`); otherwise scenes with bodies are refused."""
    sound_cell: float | None = None
    """Mean edge of the largest cells, in bending lengths, whose folds have the right shape; None if not limited."""
    usable_cell: float | None = None
    """Mean edge of the largest cells, in bending lengths, on which two folds may be compared; None if not limited."""
    friction_table: float | None = None
    """Largest Coulomb coefficient between cloth and table; larger ones are cut to it. None if not limited."""
    friction_cloth: float | None = None
    """Largest Coulomb coefficient between layers of cloth; larger ones are cut to it. None if not limited."""

    def refuse(self, scene: Scene, name: str) -> None:
        """Refuse a scene that the simulator of that name cannot simulate at all.

        Raises:
            InputError: If the scene has rigid bodies and the simulator cannot do bodies.
        """
        if scene.bodies and not self.bodies:
            raise InputError(
                f"bodies: must be none for {name}, which cannot do rigid bodies, given {len(scene.bodies)}; "
                f"simulate the scene with native"
            )

    def lacking(self, material: Material) -> list[str]:
        """A line for each property of a material that is beyond the simulator, for the user to read."""
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
