"""Closed-form references for an ideal cloth, solved from first principles.

Symbols: g is gravity [m/s^2], rho areal density [kg/m^2], Y membrane stiffness [N/m], nu Poisson ratio [-], mu Coulomb
    coefficient [-], G shear stiffness [N/m], B bending rigidity [N m], and L length [m]. Longer solutions are in the
    modules `frictional_strip` and `plate`, and in `tatamu.simulation.heavy_strip`.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from tatamu.simulation.material import Material


def fall(time: np.ndarray, gravity: float) -> np.ndarray:
    """Return the height z = -g t^2 / 2 in free fall from rest [m], with the gravity g and the time t."""
    return -0.5 * gravity * time**2


def hang_displacement(distance: np.ndarray, length: float, material: Material, gravity: float) -> np.ndarray:
    """Return how far points of a hanging sheet move down because of its weight [m].

    At the distance s below the held edge, the tension per width carries the weight of the cloth below, rho g (L - s).
    The strain is the tension divided by the membrane stiffness Y, so the displacement is u(s) = rho g (L s - s^2 / 2) /
    Y. Here rho is the areal density, g the acceleration of gravity and L the length. This formula is exact if the
    Poisson ratio is 0.

    Args:
        distance: Unstrained distance from the held edge [m].
        length: Unstrained length [m].
        material: Material of the sheet.
        gravity: Acceleration of gravity [m/s^2].
    """
    weight = material.areal_density * gravity
    return weight * (length * distance - distance**2 / 2) / material.stretch_stiffness


def shear_sag(across: np.ndarray, span: float, material: Material, gravity: float) -> np.ndarray:
    """Return how far a tall vertical panel sags in its own plane if it is held along both upright sides [m].

    Far from its top and bottom, the panel is in pure shear. The sag u follows from G u'' = -rho g, with the shear
    stiffness G, the areal density rho and the acceleration of gravity g. Its solution is u = rho g x (D - x) / (2 G).
    If the material has no value of G, G is Y / (2 (1 + nu)) as in an isotropic sheet, with the membrane stiffness Y and
    the Poisson ratio nu.

    Args:
        across: Distance x from one held side [m].
        span: Distance D between the sides [m].
        material: Material of the panel.
        gravity: Acceleration of gravity [m/s^2].
    """
    return material.areal_density * gravity * across * (span - across) / (2 * material.shear_modulus)


def off_axis_stiffness(material: Material, angle: float) -> float:
    """Return the stiffness of a strip with free sides that is cut at an angle [rad] to the warp [N/m].

    The stiffness Y(a) is the tension per width divided by the strain. Y and Y_weft are the stiffnesses along warp and
    weft, G is the shear stiffness, and nu the Poisson ratio. Let c = cos(a) and s = sin(a).

    1 / Y(a) = c^4 / Y + s^4 / Y_weft + (1 / G - 2 nu / sqrt(Y Y_weft)) c^2 s^2 (Jones, Mechanics of Composite
    Materials, 1975, section 2.6).
    """
    along = np.cos(angle) ** 2
    across = np.sin(angle) ** 2
    coupled = 2 * material.poisson_ratio / np.sqrt(material.stretch_stiffness * material.weft_stiffness)
    compliance = (
        along**2 / material.stretch_stiffness
        + across**2 / material.weft_stiffness
        + (1 / material.shear_modulus - coupled) * along * across
    )
    return float(1 / compliance)


def off_axis_rigidity(material: Material, angle: float) -> float:
    """Return the rigidity of a wide sheet that is bent to a cylinder at an angle [rad] to the warp [N m].

    The rigidity is the moment per width divided by the curvature.

    B(a) = B c^4 + B_weft s^4 + T c^2 s^2, with the rigidities B and B_weft along warp and weft, the twist rigidity T, c
    = cos(a) and s = sin(a).
    """
    along = np.cos(angle) ** 2
    across = np.sin(angle) ** 2
    ends = material.bending_rigidity * along**2 + material.weft_rigidity * across**2
    return float(ends + material.twist_rigidity * along * across)


def pulled_width(stretch: float, poisson_ratio: float) -> float:
    """Return the relative width of a sheet with free sides that is pulled to the stretch `stretch`.

    The width is 1 - nu (stretch - 1), with the Poisson ratio nu.
    """
    return 1.0 - poisson_ratio * (stretch - 1.0)


def catenary(span: float, length: float, count: int = 201) -> np.ndarray:
    """Return the shape of an inextensible limp strip between two hands of equal height.

    The result has the shape (count, 2): x and z [m] at equal distances along the strip.

    The span D and the length L determine the parameter a by 2 a sinh(D / 2a) = L. The shape is z = a cosh(x / a).
    """
    low = span / 40
    high = 40 * span
    a = brentq(lambda a: 2 * a * np.sinh(span / (2 * a)) - length, low, high, xtol=1e-14)
    arc = np.linspace(-length / 2, length / 2, count)
    x = a * np.arcsinh(arc / a)
    return np.column_stack([x, a * (np.cosh(x / a) - np.cosh(span / (2 * a)))])


def incline_threshold(mu: float) -> float:
    """Return the tilt theta at which a resting sheet starts to slide [rad].

    The tilt follows from tan(theta) = mu, with the friction coefficient mu.
    """
    return float(np.arctan(mu))


def incline_acceleration(tilt: float, mu: float, gravity: float) -> float:
    """Return the acceleration of a sheet down an incline [m/s^2]; zero if the sheet sticks.

    The acceleration is g (sin(tilt) - mu cos(tilt)), with the friction coefficient mu and the acceleration of gravity
    g.
    """
    return float(max(0.0, gravity * (np.sin(tilt) - mu * np.cos(tilt))))


def arc_energy(material: Material, curvature: float, area: float) -> float:
    """Return the bending energy of a flat sheet that is rolled to a cylinder [J].

    The energy is B k^2 A / 2, with the bending rigidity B, the curvature k and the area A.
    """
    return 0.5 * material.bending_rigidity * curvature**2 * area
