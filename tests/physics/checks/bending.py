"""Checks of bending: cantilevers against the heavy elastica, and the crease of a fold against a heavy chain.

The heavy elastica is the theory of a thin strip that bends under its own weight. In the check `cantilever`, one row of
vertices across the middle of a strip is held, and the strip droops on both sides. By symmetry, the slope of the strip
at this row is zero. Therefore each side is a cantilever with exactly the length from this row to the tip.

The check `clamp` holds a whole end instead, as a robot or a ruler does. The strip can then also bend behind the last
held row, over half a cell. Therefore the clamp of the reference is half a cell behind this row.

Strips come to rest with air drag near critical damping. The drag does not change where they come to rest.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from tatamu.simulation.heavy_strip import cantilever, chord, slowest_frequency
from tatamu.simulation.material import GRAVITY, Material
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
from tests.physics.chain import FoldedStrip, start
from tests.physics.check import Case, Check
from tests.physics.findings import Curve, Figure, Findings, Row, absolute, relative
from tests.physics.meshes import LAYOUTS, Mesh, mirrored, right, staggered
from tests.physics.scenes import held, raised
from tests.physics.subject import Subject

LENGTH, WIDTH = 0.10, 0.06
GAMMAS = (1.0, 3.0, 10.0, 30.0, 100.0)
SPACINGS = (0.02, 0.01, 0.005)
DENSITY = 0.2


def strip_material(gamma: float, length: float) -> tuple[Material, float]:
    """Return a fabric and the time in which its strip comes to rest [s].

    The fabric has w L^3 / B = gamma, with the weight per area w, the length L and the bending rigidity B. The air drag
    of the fabric is near critical damping.
    """
    slowest = slowest_frequency(gamma, length, GRAVITY)
    rigidity = DENSITY * GRAVITY * length**3 / gamma
    material = Material(
        areal_density=DENSITY, stretch_stiffness=500.0, bending_rigidity=rigidity, air_drag=2 * slowest * DENSITY
    )
    return material, 16.0 / slowest


def droop(
    subject: Subject, mesh: Mesh, material: Material, duration: float, fibre: list[list[float]] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Let a level strip droop on both sides of its middle row, which is held.

    Args:
        subject: The simulator.
        mesh: Mesh that is symmetric about x = 0.
        material: Material of the strip.
        duration: Time in which the strip comes to rest [s].
        fibre: Direction of the warp; None if the material is isotropic.

    Returns:
        Two arrays over the n vertices: the unstrained distance from the middle row [m], shape (n,), and the horizontal
        and vertical distance from this row at rest (reach and drop) [m], shape (n, 2).
    """
    plan, faces = mesh
    cloth = Cloth(vertices=raised(plan), faces=faces, fibre=fibre)
    end = subject.end(cloth, material, np.flatnonzero(np.abs(plan[:, 0]) < 1e-12), duration)
    return np.abs(plan[:, 0]), np.column_stack([np.abs(end[:, 0]), -end[:, 2]])


def tip_of(along: np.ndarray, shape: np.ndarray, length: float) -> np.ndarray:
    """Return the mean position of the vertices at the end of a strip [m], shape (2,).

    The position consists of the horizontal and the vertical distance from the clamp: reach and drop.
    """
    return shape[along > length - 1e-9].mean(axis=0)


def chord_of(tip: np.ndarray) -> float:
    """Return the angle between the horizontal and the line from a clamp down to the tip of a strip [degrees].

    `tip` has the horizontal and the vertical distance of the tip from the clamp.
    """
    return float(np.degrees(np.arctan2(tip[1], tip[0])))


def both_sides(subject: Subject, gamma: float, layout: str) -> Findings:
    """Check how a strip that is held at its middle row droops on three meshes, and how fast its tip converges."""
    wanted = cantilever(gamma)[-1] * LENGTH
    angle = np.degrees(chord(gamma))
    material, duration = strip_material(gamma, LENGTH)
    misses = []
    for spacing in SPACINGS:
        along, shape = droop(subject, mirrored(LAYOUTS[layout](LENGTH, WIDTH, spacing)), material, duration)
        tip = tip_of(along, shape, LENGTH)
        misses.append(float(np.linalg.norm(tip - wanted)) / LENGTH)
        limit = subject.limit(f"chord at {1e3 * spacing:g} mm")
        yield absolute(
            f"chord at {1e3 * spacing:g} mm [deg]",
            angle,
            chord_of(tip),
            limit,
            "deg",
            f"tip off by {100 * misses[-1]:.2f} % of L",
        )
        if layout == "right triangles":
            yield Curve("cantilever", f"{1e3 * spacing:g} mm", 100 * shape[:, 0], -100 * shape[:, 1])
    yield from _order(subject, layout, misses)
    if layout == "right triangles":
        curve = 100 * LENGTH * cantilever(gamma)
        yield Curve("cantilever", "heavy elastica", curve[:, 0], -curve[:, 1], reference=True)


def _order(subject: Subject, layout: str, misses: list[float]) -> Findings:
    order = float(np.polyfit(np.log(SPACINGS), np.log(np.maximum(misses, 1e-9)), 1)[0])
    least = subject.limit("order")
    yield Row(
        "observed order of the tip's error",
        least,
        order,
        0.0 if least is None else max(0.0, least - order),
        None if least is None else 0.0,
        "-",
        "at least",
    )
    yield Curve("order", layout, 1e3 * np.array(SPACINGS), 100 * np.array(misses))


def clamped(subject: Subject, gamma: float, spacing: float) -> Findings:
    """Check how a strip that is held over a whole end droops.

    The reference begins half a cell behind the last held row.
    """
    back = 2 * spacing
    plan, faces = right(LENGTH + back, WIDTH, spacing)
    plan = plan - [back, 0.0]
    material, duration = strip_material(gamma, LENGTH)
    cloth = Cloth(vertices=raised(plan), faces=faces)
    end = subject.end(cloth, material, np.flatnonzero(plan[:, 0] < 1e-9), duration)
    tip = tip_of(plan[:, 0], np.column_stack([end[:, 0], -end[:, 2]]), LENGTH)
    for behind, limit in ((spacing / 2, subject.limit(f"chord at {1e3 * spacing:g} mm")), (0.0, None)):
        wanted = np.degrees(chord(gamma * ((LENGTH + behind) / LENGTH) ** 3))
        yield absolute(
            f"chord at {1e3 * spacing:g} mm, clamp {1e3 * behind:g} mm behind [deg]",
            wanted,
            chord_of(tip + np.array([behind, 0.0])),
            limit,
            "deg",
            "stated only" if behind == 0.0 else "",
        )


def crease(subject: Subject, bending_length: float, spacing: float) -> Findings:
    """Check the crease of a strip that is folded over itself on the table.

    Its upper end is held a little above its lower end.
    """
    length = 0.4
    width = 0.06
    rise = 0.004
    thickness = 0.001
    plan, faces = staggered(length, width, spacing)
    row = length / (len(np.unique(plan[:, 0])) - 1)
    material = Material(
        areal_density=DENSITY,
        stretch_stiffness=500.0,
        thickness=thickness,
        friction_table=0.0,
        bending_rigidity=DENSITY * GRAVITY * bending_length**3,
        friction_cloth=0.0,
        air_drag=15 * DENSITY,
    )
    chain = start(length, bending_length, thickness, 8 * len(np.unique(plan[:, 0])))
    arc = np.linspace(0, length, len(chain))
    vertices = np.column_stack(
        [np.interp(plan[:, 0], arc, chain[:, 0]), plan[:, 1], np.interp(plan[:, 0], arc, chain[:, 1])]
    )
    down = rise + thickness / 2 - chain[-1, 1]
    upper = np.flatnonzero(plan[:, 0] > length - 1.5 * row)
    grippers = [
        held(np.flatnonzero(plan[:, 0] < 1.5 * row)),
        Gripper(vertices=upper.tolist(), times=[0.0, 0.8], displacements=[[0, 0, 0], [0, 0, down]]),
    ]
    cloth = Cloth(vertices=vertices, faces=faces, rest_vertices=raised(plan))
    scene = Scene(cloth=cloth, material=material, grippers=grippers, table=Table(), duration=3.5)
    end = subject.simulate(scene).positions[-1]
    wanted = FoldedStrip(length - 2 * row, bending_length, thickness, rise).solve() + np.array([row, 0.0])
    limit = subject.limit("loop height") if spacing <= 0.55 * bending_length else None
    yield relative("height of the loop [mm]", 1e3 * float(wanted[:, 1].max()), 1e3 * float(end[:, 2].max()), limit)
    yield absolute("reach of the loop [mm]", 1e3 * float(wanted[:, 0].max()), 1e3 * float(end[:, 0].max()), None, "mm")
    name = f"l_b = {100 * bending_length:g} cm"
    yield Curve("crease", f"{name}: chain", 100 * wanted[:, 0], 100 * wanted[:, 1], reference=True)
    yield Curve("crease", f"{name}, {1e3 * spacing:g} mm", 100 * end[:, 0], 100 * end[:, 2])


CHECKS = (
    Check(
        "cantilever",
        "Strip held by its middle row",
        "heavy elastica of the length from that row to the tip",
        tuple(
            Case(
                f"Γ = {gamma:g}, {layout}",
                partial(both_sides, gamma=gamma, layout=layout),
                quick=gamma == 10.0 and layout == "right triangles",
            )
            for gamma in GAMMAS
            for layout in LAYOUTS
        ),
        {
            "cantilever": Figure("Right triangles, Γ = 1, 3, 10, 30, 100", "reach [cm]", "height [cm]", equal=True),
            "order": Figure("Convergence of the tip", "spacing [mm]", "tip off by [% of L]", log=True, joined=True),
        },
    ),
    Check(
        "clamp",
        "Strip held over a whole end",
        "heavy elastica, clamp half a cell behind the last held row",
        tuple(
            Case(
                f"Γ = {gamma:g}, {1e3 * spacing:g} mm",
                partial(clamped, gamma=gamma, spacing=spacing),
                quick=gamma == 10.0 and spacing == 0.01,
            )
            for gamma in GAMMAS
            for spacing in SPACINGS[1:]
        ),
    ),
    Check(
        "crease",
        "Crease of a fold on the table",
        "heavy inextensible chain with contact, least energy",
        tuple(
            Case(
                f"l_b = {100 * length:g} cm, {1e3 * spacing:g} mm",
                partial(crease, bending_length=length, spacing=spacing),
                quick=spacing == 0.014,
            )
            for length in (0.037, 0.022)
            for spacing in (0.02, 0.014, 0.01)
        ),
        {"crease": Figure("Crease of a fold", "x [cm]", "z [cm]", equal=True)},
    ),
)
