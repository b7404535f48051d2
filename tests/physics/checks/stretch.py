"""Checks of stretch: strain of a hanging sheet, shear, contraction, and the catenary.

Without drag, waves in a membrane decay slowly. The scenes of these checks therefore have air drag near critical damping
of the slowest wave. The drag does not change the shape in which the cloth comes to rest.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from tatamu.simulation.material import GRAVITY, Material, settling
from tatamu.simulation.scene import Cloth, Gripper, Scene
from tests.physics.check import Case, Check
from tests.physics.findings import Curve, Figure, Findings, relative, small
from tests.physics.meshes import LAYOUTS, right
from tests.physics.references import catenary, hang_displacement, pulled_width, shear_sag
from tests.physics.scenes import flat, hanging, held, raised, upright
from tests.physics.subject import Subject

FABRICS = {
    "woven": Material(areal_density=0.2, stretch_stiffness=1000.0, poisson_ratio=0.0, bending_rigidity=2e-5),
    "jersey": Material(areal_density=0.15, stretch_stiffness=150.0, poisson_ratio=0.0, bending_rigidity=5e-6),
}
"""Materials without Poisson effect. These materials do not contract across the pull, so the held edge does not disturb
the one-dimensional strain of the reference."""
PLANE = Material(areal_density=0.2, stretch_stiffness=100.0, poisson_ratio=0.3, bending_rigidity=2e-5)
MESHES = ("right triangles", "staggered", "irregular")


def settled(material: Material, slowest: float) -> tuple[Material, float]:
    """Return a material with critical drag, and the time in which its cloth comes to rest [s].

    The drag is critical for a motion with the angular frequency `slowest` [rad/s].
    """
    damped = settling(material, slowest)
    rate = min(slowest, damped.air_drag / material.areal_density / 2)
    return damped, 18.0 / rate


def hang(subject: Subject, fabric: str, layout: str, spacing: float = 0.02) -> Findings:
    """Check the strain of a sheet that hangs from one edge."""
    length = 0.3
    plan, faces = LAYOUTS[layout](length, 0.1, spacing)
    plain = FABRICS[fabric]
    wave = np.pi / (2 * length) * np.sqrt(plain.stretch_stiffness / plain.areal_density)
    material, duration = settled(plain, wave)
    start = hanging(plan)
    end = subject.end(Cloth(vertices=start, faces=faces), material, np.flatnonzero(plan[:, 0] == 0), duration)
    sunk = start[:, 2] - end[:, 2]
    wanted = hang_displacement(plan[:, 0], length, plain, GRAVITY)
    last = plan[:, 0] > length - 1e-9
    yield relative(
        "mean strain [-]",
        wanted.max() / length,
        float(sunk[last].mean()) / length,
        subject.limit("hang strain"),
        "rho g L / 2Y",
    )
    band = np.rint(plan[:, 0] / spacing).astype(int)  # the reference has one dimension: compare means over the width
    off = 100 * float(np.abs(np.bincount(band, sunk - wanted) / np.bincount(band)).max() / wanted.max())
    yield small("off the linear strain profile / end", off, subject.limit("hang profile", 100), "%")
    if layout == "staggered":
        order = np.argsort(plan[:, 0])
        fine = np.linspace(0, length, 61)
        curve = hang_displacement(fine, length, plain, GRAVITY)
        yield Curve("hang", f"{fabric}: reference", 100 * fine, 1e3 * curve, reference=True)
        yield Curve("hang", f"{fabric}: {subject.name}", 100 * plan[order, 0], 1e3 * sunk[order])


def shear(subject: Subject, layout: str, plain: Material = PLANE) -> Findings:
    """Check how a tall panel that is held along its upright sides sags in its plane by shear."""
    span = 0.1
    height = 0.4
    mesh = LAYOUTS[layout](span, height, 0.01)
    plan = mesh[0]
    material, duration = settled(plain, np.pi / span * np.sqrt(plain.shear_modulus / plain.areal_density))
    sides = np.flatnonzero((plan[:, 0] == 0) | (plan[:, 0] == span))
    cloth = upright(mesh)
    sunk = cloth.vertices[:, 2] - subject.end(cloth, material, sides, duration)[:, 2]
    middle = np.abs(plan[:, 1] - height / 2) < height / 8
    wanted = shear_sag(plan[middle, 0], span, plain, GRAVITY)
    share = float(sunk[middle] @ wanted / (wanted @ wanted))
    peak = float(shear_sag(np.array([span / 2]), span, plain, GRAVITY)[0])
    yield relative("sag of the middle [mm]", 1e3 * peak, 1e3 * peak * share, subject.limit("shear"), "rho g D² / 8G")
    yield Curve(
        "shear",
        "reference",
        100 * np.linspace(0, span, 41),
        1e3 * shear_sag(np.linspace(0, span, 41), span, plain, GRAVITY),
        reference=True,
    )
    yield Curve("shear", layout, 100 * plan[middle, 0], 1e3 * sunk[middle])


def pull(subject: Subject, layout: str, stretch: float = 1.01) -> Findings:
    """Check how the area of a weightless sheet changes when the sheet is pulled at its ends.

    Far from the ends, its sides move inwards freely.
    """
    length = 0.4
    width = 0.1
    ramp = 0.05
    mesh = LAYOUTS[layout](length, width, 0.01)
    plan = mesh[0]
    wave = np.pi / length * np.sqrt(PLANE.stretch_stiffness / PLANE.areal_density)
    material, duration = settled(PLANE, wave)
    pulled = Gripper(
        vertices=np.flatnonzero(plan[:, 0] == length).tolist(),
        times=[0.0, ramp],
        displacements=[[0, 0, 0], [length * (stretch - 1), 0, 0]],
    )
    grippers = [held(np.flatnonzero(plan[:, 0] == 0)), pulled]
    scene = Scene(cloth=flat(mesh), material=material, grippers=grippers, gravity=0.0, duration=ramp + duration)
    moved = subject.simulate(scene).positions[-1][:, :2] - plan
    middle = np.abs(plan[:, 0] - length / 2) < length / 10
    along, across = (np.polyfit(plan[middle, k] - plan[middle, k].mean(), moved[middle, k], 1)[0] for k in (0, 1))
    wanted = (1 + along) * pulled_width(1 + along, PLANE.poisson_ratio) - 1
    got = (1 + along) * (1 + across) - 1
    yield relative(
        "change of area A/A0 - 1 [-]",
        float(wanted),
        float(got),
        subject.limit("pulled area"),
        f"at the stretch measured in the middle, {1 + along:.5f}",
    )


def hands(subject: Subject, length: float = 0.5, span: float = 0.4) -> Findings:
    """Check how a limp strip sags between two hands that hold its ends and move towards each other."""
    mesh = right(length, 0.06, 0.01)
    plan = mesh[0]
    shift = (length - span) / 2
    limp = Material(areal_density=0.2, stretch_stiffness=1000.0, bending_rigidity=1e-7, air_drag=3.0)
    grippers = [
        Gripper(
            vertices=np.flatnonzero(plan[:, 0] == end).tolist(),
            times=[0.0, 0.5],
            displacements=[[0, 0, 0], [sign * shift, 0, 0]],
        )
        for end, sign in ((0.0, 1), (length, -1))
    ]
    cloth = Cloth(vertices=raised(plan), faces=mesh[1])
    end = subject.simulate(Scene(cloth=cloth, material=limp, grippers=grippers, duration=4.0)).positions[-1]
    curve = catenary(span, length)
    middle = np.abs(plan[:, 0] - length / 2) < 1e-9
    yield relative(
        "sag [mm]",
        -1e3 * float(curve[:, 1].min()),
        -1e3 * float(end[middle, 2].mean()),
        subject.limit("catenary"),
        f"L = {length} m, D = {span} m",
    )
    yield Curve("catenary", "catenary", 100 * curve[:, 0], 100 * curve[:, 1], reference=True)
    yield Curve("catenary", subject.name, 100 * (end[:, 0] - length / 2), 100 * end[:, 2])


CHECKS = (
    Check(
        "hang",
        "Sheet hung by an edge",
        "strain rho g (L - s) / Y",
        tuple(
            Case(f"{fabric}, {layout}", partial(hang, fabric=fabric, layout=layout), quick=fabric == "woven")
            for fabric in FABRICS
            for layout in MESHES
        ),
        {"hang": Figure("Displacement of a hanging sheet", "distance from the held edge [cm]", "moved down [mm]")},
    ),
    Check(
        "shear",
        "Shear of a panel under its own weight",
        "plane stress, G = Y / (2 (1 + nu))",
        tuple(Case(layout, partial(shear, layout=layout), quick=layout == "staggered") for layout in MESHES),
        {"shear": Figure("Panel held along its sides", "across [cm]", "sag [mm]")},
    ),
    Check(
        "pull",
        "Area of a pulled sheet",
        "plane stress, contraction nu",
        tuple(Case(layout, partial(pull, layout=layout), quick=layout == "staggered") for layout in MESHES),
    ),
    Check(
        "catenary",
        "Limp strip between two hands",
        "2a sinh(D / 2a) = L",
        (Case("0.5 m over 0.4 m", hands),),
        {"catenary": Figure("Strip between two hands", "x [cm]", "z [cm]", equal=True)},
    ),
)
