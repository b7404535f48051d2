"""The parameters of a material that calibration finds: their names, search ranges and units."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Parameter:
    """One field of a material that calibration can find."""

    name: str
    symbol: str
    unit: str
    """Unit of the parameter; "-" if it has no unit."""
    words: str
    """Name of the parameter in words."""
    shown_unit: str = ""
    """Unit with which pages show the parameter; empty if this unit is `unit`."""
    shown_factor: float = 1.0
    """Factor from a value in `unit` to the value that pages show."""

    @property
    def label(self) -> str:
        """The symbol and the shown unit, as the label of an axis."""
        return self.symbol if self.unit == "-" else f"{self.symbol} [{self.shown_unit or self.unit}]"


KNOWN = {
    parameter.name: parameter
    for parameter in (
        Parameter("areal_density", "ρ", "kg/m²", "areal density"),
        Parameter("stretch_stiffness", "Y", "N/m", "stretch stiffness"),
        Parameter("bending_rigidity", "B", "N m", "bending rigidity", "µN m", 1e6),
        Parameter("friction_table", "μ", "-", "friction on the table"),
        Parameter("compression", "c", "-", "resists compression, part of Y"),
        Parameter("shear_stiffness", "G", "N/m", "shear stiffness"),
        Parameter("air_added_mass", "m_a", "kg/m²", "air that it carries", "g/m²", 1e3),
        Parameter("air_drag_quadratic", "q_n", "kg/m³", "quadratic drag of air"),
        Parameter("bending_hysteresis", "HB", "N", "friction of bending", "mN", 1e3),
    )
}
"""Parameters by the names of their fields in a material."""
PARAMETERS = tuple(KNOWN)
"""Names of the parameters, in the order of the rows and columns of every covariance matrix."""
UNITS = {name: parameter.unit for name, parameter in KNOWN.items()}
SYMBOLS = {name: parameter.symbol for name, parameter in KNOWN.items()}
PLACE = {name: number for number, name in enumerate(PARAMETERS)}
"""Index of each parameter's row and column in every covariance matrix, by the name of the parameter."""
LIMITS = {
    "shear_stiffness": (1.0, 1e4),
    "stretch_stiffness": (1.0, 1e5),
    "bending_rigidity": (1e-8, 1e-2),
    "compression": (0.01, 1.0),
    "air_added_mass": (1e-3, 2.0),
    "air_drag_quadratic": (1e-2, 100.0),
    "bending_hysteresis": (1e-6, 1.0),
}
"""Smallest and largest value in the search for each parameter, in its unit."""
OPTIONAL = ("shear_stiffness", "air_added_mass", "air_drag_quadratic", "bending_hysteresis")
"""Parameters that are reported only if a test determines them."""
UNMEASURED = ("poisson_ratio", "friction_cloth", "air_drag")
"""Fields of a material that no test determines."""
