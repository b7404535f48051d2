"""Checks of woven cloth.

The shear stiffness of woven cloth is independent of its other stiffnesses. Its stretching and bending depend on the
angle to the warp.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from tatamu.simulation.heavy_strip import chord
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.scene import Cloth
from tests.physics.check import Case, Check
from tests.physics.checks.bending import DENSITY, chord_of, strip_material, tip_of
from tests.physics.checks.bending import droop as hung_over
from tests.physics.checks.stretch import settled, shear
from tests.physics.findings import Curve, Figure, Findings, absolute, relative
from tests.physics.meshes import LAYOUTS, mirrored
from tests.physics.references import off_axis_rigidity, off_axis_stiffness
from tests.physics.scenes import hanging, raised
from tests.physics.subject import Subject

WOVEN = Material(
    areal_density=0.2,
    stretch_stiffness=1000.0,
    stretch_stiffness_weft=600.0,
    shear_stiffness=30.0,
    poisson_ratio=0.2,
    bending_rigidity=2e-5,
)
"""Woven material of these checks. Its shear stiffness of 30 N/m is 0.5 gf/cm/degree in Kawabata's units."""
ANGLES = (0, 15, 30, 45, 60, 90)
"""Angles between strips and the warp [degrees]."""
LENGTH = 0.10
BENT = {"bending_rigidity_weft": 0.5, "bending_rigidity_bias": 0.6}
"""Bending rigidities along the weft and at 45 degrees, as fractions of the rigidity along the warp."""


def direction(degrees: float) -> list[list[float]]:
    """Return the direction of the warp in a strip along x that was cut at an angle to the warp."""
    angle = np.radians(degrees)
    return [[float(np.cos(angle)), float(-np.sin(angle)), 0.0]]


def pull(subject: Subject, degrees: float) -> Findings:
    """Check the stiffness of a strip, cut at an angle to the warp, that hangs from one end."""
    length = 0.3
    plan, faces = LAYOUTS["staggered"](length, 0.02, 0.01)
    stiffness = off_axis_stiffness(WOVEN, np.radians(degrees))
    material, duration = settled(WOVEN, np.pi / (2 * length) * np.sqrt(stiffness / WOVEN.areal_density))
    cloth = Cloth(vertices=hanging(plan), rest_vertices=raised(plan), faces=faces, fibre=direction(degrees))
    end = subject.end(cloth, material, np.flatnonzero(plan[:, 0] == 0), 3 * duration)  # longer, because it also sways
    middle = np.abs(plan[:, 0] - length / 2) < length / 4
    strain = float(np.polyfit(plan[middle, 0], -end[middle, 2], 1)[0]) - 1.0
    tension = WOVEN.areal_density * GRAVITY * (length - float(plan[middle, 0].mean()))
    got = tension / strain
    yield relative("tension per width and strain [N/m]", stiffness, got, subject.limit("off-axis stiffness"))
    fine = np.arange(0.0, 91.0, 1.0)
    curve = np.array([off_axis_stiffness(WOVEN, angle) for angle in np.radians(fine)])
    yield Curve("modulus", "plane stress", fine, curve, reference=True)
    yield Curve("modulus", subject.name, np.array([degrees]), np.array([got]))


def droop(subject: Subject, degrees: float, gamma: float = 10.0) -> Findings:
    """Check how a wide sheet, cut at an angle to the warp, droops on both sides of its middle row, which is held."""
    plain, duration = strip_material(gamma, LENGTH)
    parts = {name: part * plain.bending_rigidity for name, part in BENT.items()}
    material = Material.model_validate(plain.model_dump() | parts)
    mesh = mirrored(LAYOUTS["staggered"](LENGTH, 0.12, 0.01))
    along, shape = hung_over(subject, mesh, material, duration, direction(degrees))
    inner = np.abs(mesh[0][:, 1] - 0.06) < 0.03
    tip = tip_of(along[inner], shape[inner], LENGTH)
    rigidity = off_axis_rigidity(material, np.radians(degrees))
    wanted = np.degrees(chord(DENSITY * GRAVITY * LENGTH**3 / rigidity))
    note = f"{rigidity / plain.bending_rigidity:.3f} of the rigidity along the warp"
    yield absolute("chord in the middle [deg]", wanted, chord_of(tip), subject.limit("off-axis chord"), "deg", note)


CHECKS = (
    Check(
        "woven-shear",
        "Shear of a woven panel",
        "rho g D² / 8G with a shear stiffness G of its own",
        (Case("staggered", partial(shear, layout="staggered", plain=WOVEN)),),
        {"shear": Figure("Panel held along its sides", "across [cm]", "sag [mm]")},
    ),
    Check(
        "off-axis",
        "Strip pulled at an angle to the warp",
        "1 / Y(a) = c⁴ / Y + s⁴ / Y_weft + (1 / G - 2 nu / sqrt(Y Y_weft)) c² s²",
        tuple(Case(f"{angle} degrees", partial(pull, degrees=angle), quick=angle in (0, 45)) for angle in ANGLES),
        {"modulus": Figure("Stiffness against angle", "angle to the warp [degrees]", "stiffness [N/m]")},
    ),
    Check(
        "bias-droop",
        "Sheet cut at an angle to the warp, hung over an edge",
        "heavy elastica with B(a) = B c⁴ + B_weft s⁴ + T c² s²",
        tuple(Case(f"{angle} degrees", partial(droop, degrees=angle), quick=angle == 45) for angle in (0, 45, 90)),
    ),
)
