"""A scene as a MuJoCo model.

Each vertex is a body with three sliders, and a flex, MuJoCo's deformable body, connects all vertices. The membrane
follows the law of Saint Venant and Kirchhoff on each triangle, and bending is a quadratic hinge model (MuJoCo 4.0, XML
reference, flex/elasticity). The Young modulus E and an elastic thickness t, other than that of contact, follow from the
stiffness Y [N/m] and the rigidity B [N m]:

    Y = E t,  B = E t^3 / 12 (1 - nu^2)   =>   t = sqrt(12 B (1 - nu^2) / Y),  E = Y / t
"""

from __future__ import annotations

from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.extras import lacking
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.topology import Topology, among, areas, lumped
from tatamu.simulation.mujoco.controlled import CONTACT, RIGID, rigid
from tatamu.simulation.scene import Scene, Table


def engine() -> Any:
    """Return the Python package `mujoco`, or raise InputError if it is missing or older than 4.0."""
    try:
        import mujoco
    except ImportError:
        raise lacking("mujoco", "mujoco") from None
    if not hasattr(mujoco.mjtIntegrator, "mjINT_DISCRETE"):
        raise InputError(f"mujoco: must be 4.0 or later, given {mujoco.__version__}; run `pip install -U mujoco`")
    return mujoco


def vertex_masses(scene: Scene) -> np.ndarray:
    """Return the lumped mass of each vertex [kg], shape (n,)."""
    cloth = scene.cloth
    return lumped(scene.material.areal_density * areas(cloth.rest, cloth.faces), cloth.faces, len(cloth.vertices))


def compiled(scene: Scene) -> Any:
    """Return the compiled model, with its sliders zero in the unstrained shape; `mj_setConst` must run next."""
    mujoco = engine()
    try:
        model = mujoco.MjModel.from_xml_string(_document(scene))
    except ValueError as error:
        raise InputError(f"mujoco: {' '.join(str(error).split())}") from None
    if len(scene.cloth.seams) and model.flex_bending.size:  # seams do not resist bending
        edges = np.sort(model.flex_edge, axis=1)
        assert np.array_equal(np.unique(edges, axis=0), Topology(scene.cloth.faces).edges)
        model.flex_bending.reshape(len(edges), -1)[among(edges, scene.cloth.seams)] = 0.0
    drag = scene.material.air_drag / scene.material.areal_density * vertex_masses(scene)
    model.dof_damping[: 3 * len(drag)] = np.repeat(drag, 3)
    return model


def _document(scene: Scene) -> str:
    return "".join(
        [
            "<mujoco>",
            f'<option gravity="0 0 {-scene.gravity!r}" integrator="discrete" solver="CG"',
            ' cone="elliptic" impratio="10" tolerance="1e-4" iterations="200"/>',
            '<size memory="1G"/><worldbody>',
            "" if scene.table is None else _table(scene.table, scene.material),
            *_bodies(scene),
            *(rigid(number, body) for number, body in enumerate(scene.bodies)),
            "</worldbody><deformable>",
            _flex(scene),
            "</deformable></mujoco>",
        ]
    )


def _table(table: Table, material: Material) -> str:
    half = 0.5 * table.tilt
    return (
        f'<geom type="plane" size="0 0 1" pos="0 0 {table.height!r}" quat="{np.cos(half)} 0 {np.sin(half)} 0"'
        f' friction="{material.friction_table!r} 0 0" condim="3" priority="1" {CONTACT}/>'
    )


def _bodies(scene: Scene) -> list[str]:
    sliders = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    lines = []
    for number, (mass, (x, y, z)) in enumerate(zip(vertex_masses(scene), scene.cloth.rest.tolist(), strict=True)):
        inertia = " ".join([repr(float(mass) * 1e-6)] * 3)
        lines.append(
            f'<body name="v{number}" pos="{x!r} {y!r} {z!r}">'
            f'<inertial pos="0 0 0" mass="{float(mass)!r}" diaginertia="{inertia}"/>{sliders}</body>'
        )
    return lines


def _flex(scene: Scene) -> str:
    material = scene.material
    bodies = " ".join(f"v{number}" for number in range(len(scene.cloth.vertices)))
    elements = " ".join(map(str, scene.cloth.faces.ravel().tolist()))
    bends = material.bending_rigidity > 0.0
    squeeze = 12.0 * (1.0 - material.poisson_ratio**2)
    thickness = float(np.sqrt(squeeze * material.bending_rigidity / material.stretch_stiffness)) if bends else 1e-3
    meets = f'conaffinity="{1 | RIGID}"' if scene.bodies else ""
    return (
        f'<flex name="cloth" dim="2" radius="{0.5 * material.thickness!r}" body="{bodies}" element="{elements}">'
        f'<elasticity young="{material.stretch_stiffness / thickness!r}" poisson="{material.poisson_ratio!r}"'
        f' thickness="{thickness!r}" elastic2d="{"both" if bends else "stretch"}"/>'
        f'<contact {meets} selfcollide="auto" condim="3" friction="{material.friction_cloth!r} 0 0" {CONTACT}/></flex>'
    )
