"""Air around a thin sheet: isotropic drag, drag by direction, and the mass of air that it carries.

Per area, with the unit normal n, the velocity v, v_n = n.v and v_t = v - v_n n:

    f_n = -(c_n + q |v_n|) v_n n - m_a (d v_n / dt) n        drag and added mass along the normal
    f_t = -(c_t + q_t |v_t|) v_t                             drag along the surface
    q = max(q_n, k_n s^(-1/3))                               s: path along the normal since v_n changed its sign

With the added mass, cloth has the inertia rho + m_a along n and rho across it; only rho has weight. By the
Sherman-Morrison formula, accelerations lose the part alpha = m_a / (rho + m_a) of their component along n. Because d
v_n / dt = n.a + (d n / dt).v, a turning normal changes the velocity as well, by -alpha (d n . v) n. Then rho v^2 / 2 +
m_a v_n^2 / 2 is conserved. Derived in docs/theory/air.md.

Cloth in contact carries no air, because there is none between the surfaces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.material import Material
from tatamu.simulators.native.compiled import kernel
from tatamu.simulators.native.contact.projection import Positions
from tatamu.simulators.native.geometry import Vector, normal_of, unit


class Air(NamedTuple):
    """Gravity and isotropic drag, and the constants of air that acts by direction."""

    gravity: float
    """[m/s^2]."""
    drag: float
    """Linear drag in every direction, per areal density [1/s]."""
    directional: bool
    """Whether any of the following constants is not zero."""
    density: float
    """Areal density of the cloth, rho [kg/m^2]."""
    added_mass: float
    """m_a [kg/m^2]."""
    normal_linear: float
    """c_n [N s/m^3]."""
    normal_quadratic: float
    """q_n [kg/m^3]."""
    turning: float
    """k_n [kg/m^(8/3)]."""
    tangential_linear: float
    """c_t [N s/m^3]."""
    tangential_quadratic: float
    """q_t [kg/m^3]."""


class AirSurface(NamedTuple):
    """The cloth as air meets it, by slot; without rows where air has no direction."""

    normals: np.ndarray
    """Unit normals at the last look, shape (3, slots)."""
    carried: np.ndarray
    """alpha = m_a / (rho + m_a), 0 for cloth that is held or in contact [-], shape (slots,)."""
    along: np.ndarray
    """Scratch: reduction of velocities along the normals in a step [m/s], shape (slots,)."""
    path: np.ndarray
    """Way along the normal since the velocity along it changed its sign, with that sign [m], shape (slots,)."""
    sums: np.ndarray
    """Scratch: areas of the triangles around each vertex as a vector [m^2], shape (n, 3)."""


def air_of(gravity: float, material: Material) -> Air:
    """Air and gravity [m/s^2] around a cloth."""
    return Air(
        gravity=gravity,
        drag=material.air_drag / material.areal_density,
        directional=material.directional_air,
        density=material.areal_density,
        added_mass=material.air_added_mass,
        normal_linear=material.air_drag_normal,
        normal_quadratic=material.air_drag_quadratic,
        turning=material.air_drag_turning,
        tangential_linear=material.air_drag_tangential,
        tangential_quadratic=material.air_drag_quadratic_tangential,
    )


SHORTEST = 1e-9
"""Least path since a turn [m]; the velocity there is near zero."""
EVERY = 2
"""Outer steps between two looks at where the surface faces: a look costs as much as a few substeps."""


def surface_of(slots: int, vertices: int, air: Air) -> AirSurface:
    """Return the scratch arrays of a surface with these numbers of slots and vertices."""
    room = slots if air.directional else 0
    sums = np.zeros((vertices if air.directional else 0, 3))
    return AirSurface(np.zeros((3, room)), np.zeros(room), np.zeros(room), np.zeros(room), sums)


@kernel
def _sum_normals(x: np.ndarray, faces: np.ndarray, sums: np.ndarray) -> None:
    """Add up the normals of the triangles around each vertex."""
    sums[:] = 0.0
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        nx, ny, nz = normal_of(x, a, b, c)
        for v in (a, b, c):
            sums[v, 0] += nx
            sums[v, 1] += ny
            sums[v, 2] += nz


@kernel
def _quadratic(path: np.ndarray, s: int, un: float, air: Air, step: float) -> float:
    """Return the quadratic drag of slot s along its normal [kg/m^3], with the velocity un [m/s] for `step` [s]."""
    if path[s] * un < 0.0:
        path[s] = 0.0
    path[s] += step * un
    return max(air.normal_quadratic, air.turning / np.cbrt(max(abs(path[s]), SHORTEST)))


@kernel
def _slowed(
    ux: float,
    uy: float,
    uz: float,
    nx: float,
    ny: float,
    nz: float,
    turn: float,
    quadratic: float,
    mass: float,
    air: Air,
    step: float,
) -> Vector:
    """A velocity u [m/s] after a time `step` [s] of drag, across a normal n that has turned.

    Args:
        ux: See above; uy and uz likewise.
        uy: See ux.
        uz: See ux.
        nx: The normal; ny and nz likewise.
        ny: See nx.
        nz: See nx.
        turn: What the turning of the normal takes from the velocity along it [m/s].
        quadratic: Drag along the normal [kg/m^3].
        mass: Per area, along the normal [kg/m^2].
        air: The air.
        step: See above.
    """
    un = nx * ux + ny * uy + nz * uz
    tx, ty, tz = ux - un * nx, uy - un * ny, uz - un * nz
    un -= turn
    un /= 1.0 + step * (air.normal_linear + quadratic * abs(un)) / mass
    ut = np.sqrt(tx * tx + ty * ty + tz * tz)
    slower = 1.0 / (1.0 + step * (air.tangential_linear + air.tangential_quadratic * ut) / air.density)
    return slower * tx + un * nx, slower * ty + un * ny, slower * tz + un * nz


@kernel
def meet(
    V: np.ndarray,
    surface: AirSurface,
    air: Air,
    positions: Positions,
    faces: np.ndarray,
    slot: np.ndarray,
    free: np.ndarray,
    step: float,
) -> None:
    """Turn the normals, and slow all velocities by drag for a time `step` [s].

    Drag is implicit in the velocity that it slows, so it only ever slows, and the velocity at which it balances a
    constant force is exact.

    Args:
        V: Velocities by slot [m/s], shape (3, slots).
        surface: Surface whose normals and carried air are updated.
        air: The air.
        positions: Positions of the vertices; a vertex moved by contact touches something.
        faces: Triangles, shape (m, 3).
        slot: Slot of each vertex, shape (n,).
        free: 0 of held vertices, by slot.
        step: [s].
    """
    normals = surface.normals
    carried = surface.carried
    sums = surface.sums
    x = positions.x
    predicted = positions.predicted
    _sum_normals(x, faces, sums)
    for v in range(slot.shape[0]):
        s = slot[v]
        nx, ny, nz = unit(sums[v, 0], sums[v, 1], sums[v, 2])
        carried[s] = 0.0
        if free[s] > 0.0:
            ux, uy, uz = V[0, s], V[1, s], V[2, s]
            touches = x[v, 0] != predicted[v, 0] or x[v, 1] != predicted[v, 1] or x[v, 2] != predicted[v, 2]
            mass = air.density if touches else air.density + air.added_mass
            carried[s] = 1.0 - air.density / mass
            turn = carried[s] * ((nx - normals[0, s]) * ux + (ny - normals[1, s]) * uy + (nz - normals[2, s]) * uz)
            quadratic = air.normal_quadratic
            if air.turning > 0.0:
                quadratic = _quadratic(surface.path, s, nx * ux + ny * uy + nz * uz, air, step)
            V[0, s], V[1, s], V[2, s] = _slowed(ux, uy, uz, nx, ny, nz, turn, quadratic, mass, air, step)
        normals[0, s] = nx
        normals[1, s] = ny
        normals[2, s] = nz


@kernel
def resist(
    V: np.ndarray, F: np.ndarray, inverse_mass: np.ndarray, surface: AirSurface, step: float, fall: float, slower: float
) -> None:
    """Subtract from velocities the part of forces, gravity and isotropic drag that accelerates the carried air.

    Args:
        V: Velocities by slot [m/s], shape (3, slots).
        F: Forces by slot and copy [N], shape (3, width).
        inverse_mass: Inverse mass of the cloth alone, by slot [1/kg].
        surface: Normals and carried air.
        step: For how long the forces act [s].
        fall: What gravity adds to a velocity downwards [m/s].
        slower: Change of a velocity by drag, as part of it [-].
    """
    n = V.shape[1]
    along = surface.along
    fx, fy, fz = F[0, :n], F[1, :n], F[2, :n]
    vx, vy, vz = V[0], V[1], V[2]
    nx, ny, nz = surface.normals[0], surface.normals[1], surface.normals[2]
    for i in range(n):
        force = nx[i] * fx[i] + ny[i] * fy[i] + nz[i] * fz[i]
        speed = nx[i] * vx[i] + ny[i] * vy[i] + nz[i] * vz[i]
        given = step * inverse_mass[i] * force + slower * speed - fall * nz[i]
        along[i] = surface.carried[i] * given
    for k in range(3):
        v = V[k]
        normal = surface.normals[k]
        for i in range(n):
            v[i] -= along[i] * normal[i]
