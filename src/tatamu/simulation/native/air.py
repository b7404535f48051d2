"""Air around a thin sheet: drag, and the mass of air that the sheet carries.

Isotropic drag is equal in all directions (`Air.drag`). The following forces depend on the direction. n is the unit
normal of the sheet, and v its velocity. The velocity has the parts v_n = n.v and v_t = v - v_n n. The forces per area
are:

    f_n = -(c_n + q |v_n|) v_n n - m_a (d v_n / dt) n        drag and added mass along the normal
    f_t = -(c_t + q_t |v_t|) v_t                             drag along the surface
    q = max(q_n, k_n s^(-1/3))                               s: path along the normal since v_n changed its sign

f_n is the force along the normal, f_t the force along the surface, and t the time. c_n and c_t are linear drag, and q_n
and q_t quadratic drag. k_n is the constant of drag after a change of direction. m_a is the added mass of air, and rho
the areal density.

With the added mass, the inertia of cloth per area is rho + m_a along n, and rho across n. Gravity acts on rho only. By
the Sherman-Morrison formula, an acceleration a loses the fraction alpha = m_a / (rho + m_a) of its component along n.
If the normal turns by d n, the velocity also changes by -alpha (d n . v) n, because d v_n / dt = n.a + (d n / dt).v.
Then the energy rho v^2 / 2 + m_a v_n^2 / 2 is conserved. The derivation is in docs/theory/air.md.

Cloth in contact carries no air, because there is no air between the surfaces.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.contact.projection import Positions
from tatamu.simulation.native.geometry import Vector, normal_of, unit


class Air(NamedTuple):
    """Constants of gravity, of isotropic drag, and of drag and added mass that depend on the direction."""

    gravity: float
    """Acceleration of gravity [m/s^2]."""
    drag: float
    """Linear drag in every direction, divided by the areal density [1/s]."""
    directional: bool
    """Whether any drag or added mass depends on the direction, or on the square of the velocity."""
    density: float
    """Areal density rho of the cloth [kg/m^2]."""
    added_mass: float
    """Mass m_a of the air that the cloth carries [kg/m^2]."""
    normal_linear: float
    """Linear drag c_n along the normal [N s/m^3]."""
    normal_quadratic: float
    """Quadratic drag q_n along the normal [kg/m^3]."""
    turning: float
    """Constant k_n of quadratic drag after cloth changes its direction [kg/m^(8/3)].

    The quadratic drag is k_n s^(-1/3) if this is larger than q_n. s is the path along the normal since the velocity
    along the normal changed its sign."""
    tangential_linear: float
    """Linear drag c_t along the surface [N s/m^3]."""
    tangential_quadratic: float
    """Quadratic drag q_t along the surface [kg/m^3]."""


class AirSurface(NamedTuple):
    """The surface of the cloth, on which the air acts.

    All arrays are empty if `Air.directional` is false.
    """

    normals: np.ndarray
    """Unit normal of the surface at each slot, from the last update, shape (3, slots)."""
    carried: np.ndarray
    """Ratio alpha of the carried mass of air to the mass of cloth and carried air [-], shape (slots,).

    The array has one number per slot. The ratio is 0 for cloth that is held or in contact."""
    along: np.ndarray
    """Temporary memory: decrease of the velocities along the normals in a step [m/s], shape (slots,)."""
    path: np.ndarray
    """Path along the normal since the velocity along the normal changed its sign [m], shape (slots,).

    The path has the sign of this velocity."""
    sums: np.ndarray
    """Temporary memory: sum of the area vectors of the triangles around each vertex [m^2], shape (n, 3)."""


def air_of(gravity: float, material: Material) -> Air:
    """Return the constants of air for the material of a cloth and the acceleration of gravity [m/s^2]."""
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
"""Smallest value of the path s in the formula k_n s^(-1/3) of drag [m].

A shorter path is replaced by this value, which prevents a division by zero."""
EVERY = 2
"""Number of outer time steps between two updates of the normals. An update takes as long as a few substeps."""


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
def _quadratic(path: np.ndarray, s: int, un: float, air: Air, step: float) -> float:
    """Return the quadratic drag along the normal of a vertex [kg/m^3].

    Args:
        path: Path along the normal of each slot since its last change of direction [m]. The path of this slot is
            updated.
        s: Slot of the vertex.
        un: Velocity along the normal [m/s].
        air: Constants of air.
        step: Time for which the velocity acts [s].
    """
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
    """Return a velocity u [m/s] after a time `step` [s] of drag, at a surface whose normal n has turned.

    Args:
        ux: First component of the velocity [m/s].
        uy: Second component of the velocity [m/s].
        uz: Third component of the velocity [m/s].
        nx: First component of the normal.
        ny: Second component of the normal.
        nz: Third component of the normal.
        turn: Change of the velocity along the normal because the normal has turned [m/s].
        quadratic: Quadratic drag along the normal [kg/m^3].
        mass: Inertia per area along the normal [kg/m^2].
        air: Constants of air.
        step: Time for which drag acts [s].
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
    """Update the normals of the surface, and reduce all velocities by drag for a time `step` [s].

    Drag is implicit: it depends on the velocity after the reduction. Therefore drag never reverses a velocity. The
    velocity at which drag balances a constant force is exact.

    Args:
        V: Velocities by slot [m/s], shape (3, slots).
        surface: Surface of the cloth. Its normals and its carried air are updated.
        air: Constants of air.
        positions: Positions of the vertices. A vertex that contact has moved counts as touching a surface, so it
            carries no air.
        faces: Triangles, shape (m, 3).
        slot: Slot of each vertex, shape (n,).
        free: 0 for held vertices and 1 for others, by slot.
        step: Time for which drag acts [s].
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
    """Subtract the part of the velocity changes that the added mass of air prevents.

    The velocity changes come from forces, gravity and isotropic drag.

    Args:
        V: Velocities by slot [m/s], shape (3, slots).
        F: Forces [N], shape (3, width). The first columns belong to the slots. The other columns are not used.
        inverse_mass: Inverse mass of the cloth without air, by slot [1/kg].
        surface: Normals of the surface, and the air that it carries.
        step: Time for which the forces act [s].
        fall: Downward velocity that gravity adds [m/s].
        slower: Relative change of a velocity by isotropic drag [-].
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
