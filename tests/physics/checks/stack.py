"""Check of stacks: each layer must rest one thickness above the next, carry the layers above, and not move."""

from __future__ import annotations

from functools import partial

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.scene import Cloth, Scene, Table
from tests.physics.check import Case, Check
from tests.physics.findings import Curve, Figure, Findings, relative, small
from tests.physics.meshes import staggered, staggered_across
from tests.physics.scenes import joined, raised
from tests.physics.subject import Subject

FABRIC = Material(areal_density=0.2, stretch_stiffness=300.0, bending_rigidity=2e-5, thickness=0.001)
SIDE = 0.16


def stack(count: int, duration: float) -> tuple[Scene, list[np.ndarray]]:
    """Return a scene with a stack of equal square cloths on a level table, and the vertices of each cloth.

    Every second cloth is rotated, so that no vertex lies on another vertex.
    """
    layouts = (staggered, staggered_across)
    parts = []
    for layer in range(count):
        plan, faces = layouts[layer % 2](SIDE, SIDE, 0.02)
        parts.append((raised(plan - SIDE / 2, (layer + 0.5) * FABRIC.thickness), faces))
    vertices, faces, members = joined(parts)
    return Scene(
        cloth=Cloth(vertices=vertices, faces=faces), material=FABRIC, table=Table(), duration=duration
    ), members


def at_rest(subject: Subject, count: int, duration: float = 10.0) -> Findings:
    """Check the gaps between the layers of a stack at rest, and how far the layers creep."""
    scene, members = stack(count, duration)
    positions = subject.simulate(scene).positions
    inner = [part[(np.abs(scene.cloth.vertices[part, :2]) < 0.4 * SIDE).all(axis=1)] for part in members]
    heights = np.array([positions[-1][part, 2].mean() for part in inner])
    gaps = np.diff(heights)
    thickness = scene.material.thickness
    worst = float(gaps[np.argmax(np.abs(gaps - thickness))])
    limit = subject.limit("layer gap")
    yield relative("gap between layers that is furthest off [mm]", 1e3 * thickness, 1e3 * worst, limit)
    top = (count - 0.5) * thickness
    yield relative("height of the top layer [mm]", 1e3 * top, 1e3 * float(heights[-1]), limit, "the weight is carried")
    second = round(1.0 * scene.frame_rate)
    crept = float(np.linalg.norm(positions[-1][:, :2] - positions[second][:, :2], axis=1).max())
    quantity = f"creep in the {duration - 1:g} s after the first [mm]"
    yield small(quantity, 1e3 * crept, subject.limit("stack creep", 1e3), "mm")
    layer = np.arange(count) + 1
    yield Curve("stack", "a thickness apart", layer, 1e3 * thickness * (layer - 0.5), reference=True)
    yield Curve("stack", f"{count} layers", np.arange(count) + 1, 1e3 * heights)


CHECKS = (
    Check(
        "stack",
        "Stacks at rest for 10 s",
        "layers a thickness apart, nothing moves",
        tuple(Case(f"{count} layers", partial(at_rest, count=count), quick=count == 2) for count in (2, 4, 8)),
        {"stack": Figure("Heights in a stack", "layer", "height [mm]")},
    ),
)
