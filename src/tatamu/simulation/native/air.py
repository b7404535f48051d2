"""Air around a thin sheet: drag, and the mass of air that the sheet carries (derived in docs/theory/air.md).

Besides isotropic drag (`Air.drag`), forces per area act along the unit normal n of the sheet and along its surface,
where the velocity v has the parts v_n = n.v and v_t = v - v_n n:

    f_n = -(c_n + q |v_n|) v_n n - m_a (d v_n / dt) n        drag and added mass along the normal
    f_t = -(c_t + q_t |v_t|) v_t                             drag along the surface
    q = max(q_n, k_n s^(-1/3))                               s: path along the normal since v_n changed its sign

The inertia per area is rho + m_a along n, while gravity acts on rho only. By the Sherman-Morrison formula, an
acceleration loses the fraction alpha = m_a / (rho + m_a) of its component along n. If the normal turns by d n, the
velocity changes by -alpha (d n . v) n, which conserves the energy rho v^2 / 2 + m_a v_n^2 / 2. Cloth in contact carries
no air, because there is none between the surfaces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.geometry import normal_of, unit


class Air(NamedTuple):
    """Constants of gravity, drag and added mass."""

    gravity: float
    """Acceleration of gravity [m/s^2]."""
    drag: float
    """Isotropic linear drag, divided by the areal density [1/s]."""
    directional: bool
    """Whether any force depends on the direction, or on the square of the velocity."""
    density: float
    """Areal density rho of the cloth [kg/m^2]."""
    added_mass: float
    """Mass m_a of the air that the cloth carries [kg/m^2]."""
    normal_linear: float
    """Linear drag c_n along the normal [N s/m^3]."""
    normal_quadratic: float
    """Quadratic drag q_n along the normal [kg/m^3]."""
    turning: float
    """Constant k_n of quadratic drag after a change of direction [kg/m^(8/3)]."""
    tangential_linear: float
    """Linear drag c_t along the surface [N s/m^3]."""
    tangential_quadratic: float
    """Quadratic drag q_t along the surface [kg/m^3]."""


class AirSurface(NamedTuple):
    """The surface on which air acts by direction; all arrays are empty without `Air.directional`."""

    normals: np.ndarray
    """Unit normal at each slot, from the last update, shape (3, slots)."""
    carried: np.ndarray
    """Ratio alpha at each slot [-], shape (slots,); 0 for cloth that is held or in contact."""
    along: np.ndarray
    """Temporary: decrease of the velocities along the normals in a step [m/s], shape (slots,)."""
    path: np.ndarray
    """Path since the velocity along the normal changed its sign, with this sign [m], shape (slots,)."""
    sums: np.ndarray
    """Temporary: sum of the area vectors of the triangles around each vertex [m^2], shape (n, 3)."""


def air_of(gravity: float, material: Material) -> Air:
    """Return the constants of air for an acceleration of gravity [m/s^2] and a material."""
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


EVERY = 2
"""Outer steps between two updates of the normals, each of which takes as long as a few substeps."""


def surface_of(slots: int, vertices: int, air: Air) -> AirSurface:
    """Return the arrays of a surface for given numbers of slots and vertices."""
    room = slots if air.directional else 0
    sums = np.zeros((vertices if air.directional else 0, 3))
    return AirSurface(np.zeros((3, room)), np.zeros(room), np.zeros(room), np.zeros(room), sums)


@kernel
def _sum_normals(x: np.ndarray, faces: np.ndarray, sums: np.ndarray) -> None:
    """Sum the area vectors (normals multiplied by the area) of the triangles around each vertex."""
    for v in range(sums.shape[0]):
        for k in range(3):
            sums[v, k] = 0.0
    for f in range(faces.shape[0]):
        a, b, c = faces[f, 0], faces[f, 1], faces[f, 2]
        nx, ny, nz = normal_of(x, a, b, c)
        for v in (a, b, c):
            sums[v, 0] += nx
            sums[v, 1] += ny
            sums[v, 2] += nz


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
    """Update the normals, and reduce all velocities by drag for a time `step` [s].

    Drag is implicit, so it never reverses a velocity, and the velocity at which it balances a constant force is exact.
    A vertex that contact has moved touches a surface, so it carries no air.
    """
    normals = surface.normals
    carried = surface.carried
    path = surface.path
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
            un = nx * ux + ny * uy + nz * uz
            turn = carried[s] * ((nx - normals[0, s]) * ux + (ny - normals[1, s]) * uy + (nz - normals[2, s]) * uz)
            quadratic = air.normal_quadratic
            if air.turning > 0.0:
                if path[s] * un < 0.0:
                    path[s] = 0.0
                path[s] += step * un
                away = max(abs(path[s]), 1e-9)  # against a division by zero
                quadratic = max(quadratic, air.turning / np.cbrt(away))
            tx, ty, tz = ux - un * nx, uy - un * ny, uz - un * nz
            un -= turn
            un /= 1.0 + step * (air.normal_linear + quadratic * abs(un)) / mass
            ut = np.sqrt(tx * tx + ty * ty + tz * tz)
            slower = 1.0 / (1.0 + step * (air.tangential_linear + air.tangential_quadratic * ut) / air.density)
            V[0, s], V[1, s], V[2, s] = slower * tx + un * nx, slower * ty + un * ny, slower * tz + un * nz
        normals[0, s] = nx
        normals[1, s] = ny
        normals[2, s] = nz


@kernel
def resist(
    V: np.ndarray, F: np.ndarray, inverse_mass: np.ndarray, surface: AirSurface, step: float, fall: float, slower: float
) -> None:
    """Subtract the part of the velocity changes that the added mass of air prevents.

    They come from the forces F in a time `step`, from gravity, which adds the downward velocity `fall`, and from
    isotropic drag, which changes velocities by the fraction `slower`.
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
