"""The parameters of a material that calibration finds: their names, search ranges and units."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Parameter:
    """One field of a material that calibration can find."""

    name: str
    symbol: str
    unit: str
    """Unit for readers; empty if the parameter has none."""
    words: str
    """Name of the parameter in words."""
    limits: tuple[float, float] | None = None
    """Smallest and largest value in a search, in the unit of the material's field; None if none searches for it."""

    @property
    def label(self) -> str:
        """The symbol and the unit, as the label of an axis."""
        return f"{self.symbol} [{self.unit}]" if self.unit else self.symbol


KNOWN = {
    parameter.name: parameter
    for parameter in (
        Parameter("areal_density", "ρ", "kg/m²", "areal density"),
        Parameter("stretch_stiffness", "Y", "N/m", "stretch stiffness", (1.0, 1e5)),
        Parameter("bending_rigidity", "B", "µN m", "bending rigidity", (1e-8, 1e-2)),
        Parameter("friction_table", "μ", "", "friction on the table"),
        Parameter("compression", "c", "", "resists compression, part of Y", (0.01, 1.0)),
        Parameter("shear_stiffness", "G", "N/m", "shear stiffness", (1.0, 1e4)),
        Parameter("air_added_mass", "m_a", "g/m²", "air that it carries", (1e-3, 2.0)),
        Parameter("air_drag_quadratic", "q_n", "kg/m³", "quadratic drag of air", (1e-2, 100.0)),
        Parameter("bending_hysteresis", "HB", "mN", "friction of bending", (1e-6, 1.0)),
    )
}
"""Parameters by the names of their fields in a material."""
PARAMETERS = tuple(KNOWN)
"""Names of the parameters, in the order of the rows and columns of every covariance matrix."""
SYMBOLS = {name: parameter.symbol for name, parameter in KNOWN.items()}
PLACE = {name: number for number, name in enumerate(PARAMETERS)}
"""Index of each parameter's row and column in every covariance matrix, by the name of the parameter."""
LIMITS = {name: parameter.limits for name, parameter in KNOWN.items() if parameter.limits is not None}
"""Smallest and largest value in the search for each parameter, in the unit of the material's field."""
OPTIONAL = ("shear_stiffness", "air_added_mass", "air_drag_quadratic", "bending_hysteresis")
"""Parameters that are reported only if a test determines them."""
UNMEASURED = ("poisson_ratio", "friction_cloth", "air_drag")
"""Fields of a material that no test determines."""
