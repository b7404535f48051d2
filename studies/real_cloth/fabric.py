"""The fabrics whose drape was measured, with assumptions for properties that were not measured.

A drape paper gives weight, thickness and bending. All other properties are those of typical fabrics, chosen before any
drape was simulated.
"""

from __future__ import annotations

from dataclasses import dataclass

from tatamu.material import Material

GF_CM = 9.80665e-5
"""KES bending rigidity: gf cm^2/cm in N m."""
GF = 9.80665e-3
"""KES bending hysteresis: gf cm/cm in N."""
SOFTENED = 300.0
"""Stretch stiffness of cloth that is to drape [N/m]. A woven fabric has thousands along its yarns, and a mesh of a
third of a bending length would lock with them (docs/theory/membrane.md)."""
SHEAR = 34.0
"""Shear stiffness of a woven fabric [N/m]: median of the ten fabrics of Wang, O'Brien and Ramamoorthi 2011 at their
smallest strain; 0.6 gf/cm/degree, in the unit of KES-FB1."""
WARP, WEFT, TWIST = 1.265, 0.735, 1.62
"""Rigidity along warp and weft and against twist over their mean: medians of the 618 fabrics of Feng et al. 2022, of
which the stiffer direction has 1.72 times the rigidity of the other, and strips on the bias 0.90 of the mean."""

FRICTION = 22.0
"""HB over B of a fabric whose hysteresis was not measured [1/m]: median of the four of Matsudaira et al. 2015."""

WAVINESS = 1e-3
"""Amplitude of cloth that is not quite flat [m]; assumed, because no measurement is known."""


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
    def isotropic(self) -> Material:
        """Return the fabric as an isotropic sheet."""
        return Material(
            areal_density=self.density,
            stretch_stiffness=SOFTENED,
            bending_rigidity=self.bending,
            thickness=self.thickness,
            friction_table=0.0,
            friction_cloth=0.3,
        )

    @property
    def woven(self) -> Material:
        """Return the fabric as a typical weave of that rigidity."""
        return self._weave(WARP, WEFT)

    def weave(self, anisotropy: float) -> Material:
        """Return the fabric as a weave with this ratio of the rigidities along warp and weft."""
        return self._weave(2.0 * anisotropy / (1.0 + anisotropy), 2.0 / (1.0 + anisotropy))

    def _weave(self, warp: float, weft: float) -> Material:
        """Return a weave by its rigidities along warp and weft over their mean."""
        return self.isotropic.model_copy(
            update={
                "shear_stiffness": SHEAR,
                "bending_rigidity": warp * self.bending,
                "bending_rigidity_weft": weft * self.bending,
                "bending_rigidity_bias": 0.25 * (warp + weft + TWIST) * self.bending,
            }
        )

    @property
    def frictional(self) -> Material:
        """Return the typical weave with the measured hysteresis of bending."""
        return self.woven.model_copy(update={"bending_hysteresis": 0.5 * self.hysteresis})

    @property
    def rubbing(self) -> Material:
        """Return the typical weave with a typical hysteresis of bending."""
        return self.woven.model_copy(update={"bending_hysteresis": FRICTION * self.bending})
