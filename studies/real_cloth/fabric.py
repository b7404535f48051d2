"""Describes fabrics whose drape was measured, with assumptions for properties that were not measured.

A paper on drape states weight, thickness and bending rigidity of its fabrics. All other properties are typical values,
which were chosen before any drape was simulated.
"""

from __future__ import annotations

from dataclasses import dataclass

from tatamu.simulation.material import Material

GF_CM = 9.80665e-5
"""Factor from the unit of bending rigidity of KES, a system of fabric testers, to SI: from gf cm^2/cm to N m."""
GF = 9.80665e-3
"""Factor from the unit of bending hysteresis of KES, a system of fabric testers, to SI: from gf cm/cm to N."""
SOFTENED = 300.0
"""Stretch stiffness of all simulated fabrics [N/m]. A real woven fabric has thousands of N/m along its yarns. With such
a large stiffness, a mesh whose spacing is a third of a bending length would be too stiff against bending
(docs/theory/bending.md)."""
SHEAR = 34.0
"""Shear stiffness of a woven fabric [N/m]. It is the median of the ten fabrics of Wang, O'Brien and Ramamoorthi 2011 at
their smallest strain. In the unit of the tester KES-FB1, this value is 0.6 gf/cm/degree."""
WARP, WEFT, TWIST = 1.265, 0.735, 1.62
"""Bending rigidities of a typical fabric along the warp and along the weft, and its rigidity against twist. All three
are divided by the mean of the rigidities along warp and weft. The values are medians of the 618 fabrics of Feng et al.
2022. In these fabrics, the rigidity of the stiffer direction is 1.72 times the rigidity of the softer direction. The
rigidity of strips at 45 degrees is 0.90 times the mean."""

FRICTION = 22.0
"""Ratio HB / B for a fabric without a measured hysteresis [1/m]. HB is half the width of the bending hysteresis, and B
is the bending rigidity. The ratio is the median of the four fabrics of Matsudaira et al. 2015."""

WAVINESS = 1e-3
"""Amplitude of the waves in simulated cloth that is not quite flat [m]. It is assumed, because no measurement is
known."""


@dataclass(frozen=True)
class Fabric:
    """A fabric with its measured properties."""

    name: str
    kind: str
    density: float
    """Areal density of the fabric [kg/m^2]."""
    bending: float
    """Bending rigidity B of the fabric, as a mean of warp and weft [N m]."""
    hysteresis: float = 0.0
    """Width 2HB of the fabric's hysteresis: difference in moment per width between bending and unbending [N]."""
    thickness: float = 4e-4
    """Thickness of the fabric [m]."""

    @property
    def isotropic(self) -> Material:
        """Material of the fabric, modelled as equal in all directions (isotropic)."""
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
        """Material of the fabric, modelled as a typical weave with the fabric's mean rigidity."""
        return self._weave(WARP, WEFT)

    def weave(self, anisotropy: float) -> Material:
        """Return the material of the fabric as a weave; `anisotropy` is the ratio of rigidities along warp and weft."""
        return self._weave(2.0 * anisotropy / (1.0 + anisotropy), 2.0 / (1.0 + anisotropy))

    def _weave(self, warp: float, weft: float) -> Material:
        """Return the material of a weave with rigidities along warp and weft in units of their mean."""
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
        """Material of the fabric, modelled as a typical weave with the measured hysteresis of bending."""
        return self.woven.model_copy(update={"bending_hysteresis": 0.5 * self.hysteresis})

    @property
    def rubbing(self) -> Material:
        """Material of the fabric, modelled as a typical weave with a typical hysteresis of bending."""
        return self.woven.model_copy(update={"bending_hysteresis": FRICTION * self.bending})
