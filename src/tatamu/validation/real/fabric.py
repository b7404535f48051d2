"""The fabrics whose drape was measured, and what the measurements lack of them.

A drape paper gives weight, thickness and bending. What else a simulator needs is that of typical fabrics of the kind,
fixed before looking at any drape.
"""

from __future__ import annotations

from dataclasses import dataclass

from tatamu.material import Material

GF_CM = 9.80665e-5
"""KES bending rigidity: gf cm^2/cm in N m."""
GF = 9.80665e-3
"""KES bending hysteresis: gf cm/cm in N."""
SOFTENED = 300.0
"""Stretch stiffness of isotropic cloth that is to drape [N/m]. A woven fabric has thousands along its yarns and about
30 N/m in shear; an isotropic sheet has one number for both, and a mesh of a third of a bending length would lock with
thousands (docs/theory/membrane.md)."""


@dataclass(frozen=True)
class Fabric:
    """A fabric by its own measurements."""

    name: str
    kind: str
    density: float
    """Areal density [kg/m^2]."""
    bending: float
    """B, mean of warp and weft [N m]."""
    hysteresis: float = 0.0
    """2HB: width of the bending hysteresis [N]."""
    thickness: float = 4e-4
    """[m]"""

    @property
    def assumed(self) -> str:
        """Everything that is not its own, in a sentence."""
        return f"Assumed: an isotropic membrane of {SOFTENED:g} N/m with a Poisson ratio of 0.25."

    @property
    def material(self) -> Material:
        """The fabric as a simulator gets it."""
        return Material(
            areal_density=self.density,
            stretch_stiffness=SOFTENED,
            bending_rigidity=self.bending,
            thickness=self.thickness,
            friction_table=0.0,
            friction_cloth=0.3,
        )
