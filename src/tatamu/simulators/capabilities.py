"""What a simulator can do, and its limits. Callers use these and need not know the simulator's name."""

from __future__ import annotations

from dataclasses import dataclass

from tatamu.errors import InputError
from tatamu.material import DIRECTIONAL_AIR, ORTHOTROPIC_BENDING, ORTHOTROPIC_MEMBRANE, Material
from tatamu.scene import Scene


@dataclass(frozen=True)
class Capabilities:
    """The capabilities and limits of a simulator. The defaults fit most simulators."""

    parallel: bool = False
    """Whether `simulate` may be called in several threads of one process. The results must not depend on this."""
    coarse_search: bool = False
    """Whether a search may start on a coarser mesh, because folds have nearly the same order by quality there."""
    compression: bool = False
    """Whether cloth may resist compression less than tension (`Material.compression`).

    Otherwise it resists both equally."""
    orthotropy: bool = False
    """Whether warp, weft, shear and bias may have separate stiffnesses. Otherwise cloth is isotropic."""
    hysteresis: bool = False
    """Whether bending may have friction (`Material.bending_hysteresis`). Otherwise bending is elastic."""
    directional_air: bool = False
    """Whether air has directional drag, quadratic drag and added mass. Otherwise only `air_drag` acts."""
    bodies: bool = False
    """Whether cloth may collide with rigid bodies (`Scene.bodies`). Otherwise scenes with bodies are refused."""
    sound_cell: float | None = None
    """Largest mean edge of the mesh with which folds have the right shape, in bending lengths; None if not limited."""
    usable_cell: float | None = None
    """Largest mean edge of the mesh with which two folds may be compared, in bending lengths; None if not limited."""
    friction_table: float | None = None
    """Largest Coulomb coefficient between cloth and table; None if not limited.

    Larger coefficients are reduced to this limit."""
    friction_cloth: float | None = None
    """Largest Coulomb coefficient between layers of cloth; None if not limited.

    Larger coefficients are reduced to this limit."""

    def refuse(self, scene: Scene, name: str) -> None:
        """Raise an error if the simulator with this name cannot simulate a scene at all.

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
