"""Membrane forces: St. Venant-Kirchhoff elasticity on linear triangles, written with squared edge lengths.

    eps_q = |x_b - x_a|^2 - L_q^2            edge q, opposite corner q: exact Green strain along it, no square root
    eps   = P (E_xx, E_yy, 2 E_xy),          rows of P: 2 (dx^2, dy^2, dx dy) of the rest edge
    W     = A/2 E' C E = 1/2 eps' S eps,     S = A P^-T C P^-1, plane stress C with stiffness Y and ratio nu
    f_a   = -2 tau_q (x_a - x_b) - ..,       tau = S eps

The derivations are in docs/theory/membrane.md. Edges are taken at the positions x + tau_d v, which gives Kelvin-Voigt
damping. eps is a small difference of large numbers, so it has double precision, and all following steps have single.

The *tension field* replaces wrinkles too fine for the mesh by a membrane that resists compression less than tension.
A compressed sheet buckles, but the mesh has no waves shorter than two cells, so it would carry load like a plate that
cannot buckle. The energy is therefore reduced, as in tension field theory (Pipkin 1986; Choi and Ko 2002 for cloth).
With the principal strains E1 >= E2 and m = E2 + nu E1, the second principal stress divided by q:

    W      = 1/2 Y psi(E1, b) + 1/2 q psi(m, (1 + nu) b),   q = Y / (1 - nu^2)
    psi(e) = e^2 for e > 0, c e^2 down to -b, c e^2 + (1 - c)(e + b)^2 beyond

c is the material's `compression`; with c = 1, the membrane is St. Venant-Kirchhoff. b is
`ElasticOptions.crowding_strain`, which keeps triangles from turning inside out. With 1 + nu, the stresses are equal at
E1 = E2.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from tatamu.simulation.material import Material
from tatamu.simulation.native.bands import BLOCK, Bands
from tatamu.simulation.native.compiled import kernel
from tatamu.simulation.native.elastic import symmetric
from tatamu.simulation.scene import MIN_IN_PLANE

ENDS = np.array([[1, 2], [2, 0], [0, 1]])
"""The two corners that edge q joins, shape (3, 2)."""

# Constants in single precision. A plain 0.5 would convert everything that it is multiplied by to double precision.
HALF: Any = np.float32(0.5)
ZERO: Any = np.float32(0.0)
ONE: Any = np.float32(1.0)
TINY: Any = np.float32(1e-12)
"""Added to the radius of Mohr's circle, which is used as a divisor."""


class Membrane(NamedTuple):
    """Constants of the membrane, in the order of memory, with zeros at places without a triangle."""

    bands: np.ndarray
    """Table of the bands of triangles, with the slots of their vertices."""
    copies: np.ndarray
    """Slots that some triangles need as copies."""
    S: np.ndarray
    """Twice the stiffness S [N/m^3], packed as in `symmetric`, in single precision, shape (6, places)."""
    L2: np.ndarray
    """Squared rest lengths of the edges [m^2], shape (3, places)."""
    relaxed: np.ndarray
    """`wrinkling_constants` in single precision, shape (12, places), or (12, 0) if the cloth does not wrinkle."""
    compression: Any
    """Ratio c of compressive to tensile stiffness, in single precision [-]."""
    crowding: Any
    """Compressive strain b beyond which cloth that wrinkles has its full stiffness, in single precision [-]."""


def rest_frames(rest: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the corners of each triangle in its own plane [m], shape (m, 3, 2).

    Corner 0 is at the origin, and corner 1 is on the positive x axis.
    """
    a, b, c = (rest[faces[:, k]] for k in range(3))
    length = np.linalg.norm(b - a, axis=1)
    along = (b - a) / length[:, None]
    x = np.einsum("ij,ij->i", c - a, along)
    y = np.linalg.norm((c - a) - x[:, None] * along, axis=1)
    frames = np.zeros((len(faces), 3, 2))
    frames[:, 1, 0] = length
    frames[:, 2, 0] = x
    frames[:, 2, 1] = y
    return frames


def along_fibres(frames: np.ndarray, rest: np.ndarray, faces: np.ndarray, fibre: np.ndarray | None) -> np.ndarray:
    """Return corners from `rest_frames` [m], turned so that the warp (`Cloth.fibre`) is along the x axis."""
    a, b, c = (rest[faces[:, k]] for k in range(3))
    along = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    across = c - a - np.einsum("ij,ij->i", c - a, along)[:, None] * along
    across /= np.linalg.norm(across, axis=1)[:, None]
    if fibre is None:
        x = np.column_stack([along[:, 0], across[:, 0]])
        y = np.column_stack([along[:, 1], across[:, 1]])
        parts = np.where(np.linalg.norm(x, axis=1)[:, None] > MIN_IN_PLANE, x, y)
    else:
        parts = np.column_stack([(along * fibre).sum(axis=1), (across * fibre).sum(axis=1)])
    cosine, sine = (parts / np.linalg.norm(parts, axis=1)[:, None]).T
    turn = np.stack([np.stack([cosine, sine], -1), np.stack([-sine, cosine], -1)], axis=1)
    return np.einsum("mij,mkj->mki", turn, frames)


def plane_stress(material: Material) -> np.ndarray:
    """Return the stiffness C from (E_xx, E_yy, 2 E_xy), with x along the warp, to stress [N/m], shape (3, 3)."""
    nu = material.poisson_ratio
    if not material.orthotropic_membrane:
        return np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) * material.stretch_stiffness / (1 - nu * nu)
    warp = material.stretch_stiffness
    weft = material.weft_stiffness
    both = nu * np.sqrt(warp * weft)
    plane = np.array([[warp, both, 0.0], [both, weft, 0.0], [0.0, 0.0, 0.0]]) / (1 - nu * nu)
    plane[2, 2] = material.shear_modulus
    return plane


def constants(frames: np.ndarray, material: Material) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return twice S, packed, shape (6, m), squared rest lengths [m^2], shape (3, m), and `wrinkling_constants`.

    `frames` have the warp along the x axis.
    """
    edges = frames[:, ENDS[:, 1]] - frames[:, ENDS[:, 0]]
    dx = edges[..., 0]
    dy = edges[..., 1]
    inverse = np.linalg.inv(2 * np.stack([dx * dx, dy * dy, dx * dy], axis=-1))
    area = 0.5 * np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    stiffness = area[:, None, None] * (inverse.transpose(0, 2, 1) @ plane_stress(material) @ inverse)
    return 2 * symmetric.pack(stiffness), (dx * dx + dy * dy).T, wrinkling_constants(inverse, area, material)


def wrinkling_constants(inverse: np.ndarray, area: np.ndarray, material: Material) -> np.ndarray:
    """Return the constants of wrinkling, shape (12, m), or (12, 0) if the cloth does not wrinkle.

    Rows 0 to 8 are P^-1 from changes of squared edge lengths to strains [1/m^2], rows 9 and 10 twice the area times Y
    and times q [N m], and row 11 is nu.
    """
    nu = material.poisson_ratio
    if material.compression == 1.0:
        return np.zeros((12, 0))
    force = 2.0 * area * material.stretch_stiffness
    rows = [force, force / (1.0 - nu * nu), np.full(len(area), nu)]
    return np.concatenate([inverse.reshape(len(area), 9).T, rows])


def in_bands(
    triangles: Bands,
    S: np.ndarray,
    L2: np.ndarray,
    relaxed: np.ndarray,
    compression: float,
    crowding: float,
    real: type = np.float32,
) -> Membrane:
    """Return what `constants` returned in the order of memory, with the precision `real` of forces."""
    return Membrane(
        bands=triangles.table,
        copies=triangles.copied,
        S=triangles.spread(S).astype(real),
        L2=triangles.spread(L2),
        relaxed=(triangles.spread(relaxed) if relaxed.size else relaxed).astype(real),
        compression=real(compression),
        crowding=real(crowding),
    )


def gradients(rest: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the derivatives of squared edge lengths by the ends (`ENDS`), at rest, shape (m, 3 edges, 2 ends, 3)."""
    start, end = (rest[faces[:, ENDS[:, k]]] for k in range(2))
    return 2.0 * np.stack([start - end, end - start], axis=2)


@kernel
def _side(x, y, z, to_x, to_y, to_z, l2, real):  # type: ignore[no-untyped-def]
    """Return the vector of an edge, and the change of its squared length from `l2`, in the precision `real`."""
    dx = to_x - x
    dy = to_y - y
    dz = to_z - z
    return real(dx), real(dy), real(dz), real(dx * dx + dy * dy + dz * dz - l2)


@kernel
def _pull(ux, uy, uz, vx, vy, vz, wx, wy, wz, t0, t1, t2, j, out):  # type: ignore[no-untyped-def]
    """Set column j of `out` to the forces on the corners of a triangle.

    Each corner is pulled along the edge that leaves it, and back along the edge that arrives.
    """
    out[j] = t2 * wx - t1 * vx
    out[j + BLOCK] = t2 * wy - t1 * vy
    out[j + 2 * BLOCK] = t2 * wz - t1 * vz
    out[j + 3 * BLOCK] = t0 * ux - t2 * wx
    out[j + 4 * BLOCK] = t0 * uy - t2 * wy
    out[j + 5 * BLOCK] = t0 * uz - t2 * wz
    out[j + 6 * BLOCK] = t1 * vx - t0 * ux
    out[j + 7 * BLOCK] = t1 * vy - t0 * uy
    out[j + 8 * BLOCK] = t1 * vz - t0 * uz


@kernel
def _forces(
    X: np.ndarray, a: int, b: int, c: int, L2: np.ndarray, S: np.ndarray, e: int, n: int, out: np.ndarray
) -> None:
    """Set nine rows of `out` to the forces [N] on the corners a + j, b + j and c + j of n triangles from place e on.

    Rows are sliced one by one, because the compiler only recognises one-dimensional slices as contiguous. If `out` were
    several arrays, the loop could be vectorised only after tests that none overlaps with an array that is read.
    """
    xa, ya, za = X[0, a : a + n], X[1, a : a + n], X[2, a : a + n]
    xb, yb, zb = X[0, b : b + n], X[1, b : b + n], X[2, b : b + n]
    xc, yc, zc = X[0, c : c + n], X[1, c : c + n], X[2, c : c + n]
    l0, l1, l2 = L2[0, e : e + n], L2[1, e : e + n], L2[2, e : e + n]
    s0, s1, s2 = S[0, e : e + n], S[1, e : e + n], S[2, e : e + n]
    s3, s4, s5 = S[3, e : e + n], S[4, e : e + n], S[5, e : e + n]
    real = out.dtype.type
    for j in range(n):
        ux, uy, uz, e0 = _side(xb[j], yb[j], zb[j], xc[j], yc[j], zc[j], l0[j], real)
        vx, vy, vz, e1 = _side(xc[j], yc[j], zc[j], xa[j], ya[j], za[j], l1[j], real)
        wx, wy, wz, e2 = _side(xa[j], ya[j], za[j], xb[j], yb[j], zb[j], l2[j], real)
        t0 = s0[j] * e0 + s1[j] * e1 + s2[j] * e2
        t1 = s1[j] * e0 + s3[j] * e1 + s4[j] * e2
        t2 = s2[j] * e0 + s4[j] * e1 + s5[j] * e2
        _pull(ux, uy, uz, vx, vy, vz, wx, wy, wz, t0, t1, t2, j, out)


@kernel
def _half_slope(e: float, compression: float, crowding: float) -> float:
    """Return half of the derivative of psi(e)."""
    return max(e, ZERO) + compression * min(e, ZERO) + (ONE - compression) * min(e + crowding, ZERO)


@kernel
def stress_of_wrinkled(
    exx: float, eyy: float, exy: float, young: float, plane: float, nu: float, compression: float, crowding: float
) -> tuple[float, float, float]:
    """Return the stress (xx, yy, xy) of a triangle for its Green strains, multiplied by twice its area A [N m].

    `young` is 2 A Y and `plane` is 2 A q, while `compression` and `crowding` are c and b.
    """
    mean = HALF * (exx + eyy)
    half = HALF * (exx - eyy)
    radius = np.sqrt(half * half + exy * exy) + TINY
    first = mean + radius
    across = _half_slope(mean - radius + nu * first, compression, (ONE + nu) * crowding)
    s1 = young * _half_slope(first, compression, crowding) + plane * nu * across
    s2 = plane * across
    middle = HALF * (s1 + s2)
    lean = HALF * (s1 - s2) / radius
    return middle + lean * half, middle - lean * half, lean * exy


@kernel
def _forces_of_wrinkled(
    X: np.ndarray, a: int, b: int, c: int, L2: np.ndarray, membrane: Membrane, e: int, n: int, out: np.ndarray
) -> None:
    """Compute the forces of cloth that resists compression less than tension, like `_forces`."""
    R = membrane.relaxed
    compression = membrane.compression
    crowding = membrane.crowding
    xa, ya, za = X[0, a : a + n], X[1, a : a + n], X[2, a : a + n]
    xb, yb, zb = X[0, b : b + n], X[1, b : b + n], X[2, b : b + n]
    xc, yc, zc = X[0, c : c + n], X[1, c : c + n], X[2, c : c + n]
    l0, l1, l2 = L2[0, e : e + n], L2[1, e : e + n], L2[2, e : e + n]
    p0, p1, p2 = R[0, e : e + n], R[1, e : e + n], R[2, e : e + n]
    p3, p4, p5 = R[3, e : e + n], R[4, e : e + n], R[5, e : e + n]
    p6, p7, p8 = R[6, e : e + n], R[7, e : e + n], R[8, e : e + n]
    young, plane, ratio = R[9, e : e + n], R[10, e : e + n], R[11, e : e + n]
    real = out.dtype.type
    for j in range(n):
        ux, uy, uz, e0 = _side(xb[j], yb[j], zb[j], xc[j], yc[j], zc[j], l0[j], real)
        vx, vy, vz, e1 = _side(xc[j], yc[j], zc[j], xa[j], ya[j], za[j], l1[j], real)
        wx, wy, wz, e2 = _side(xa[j], ya[j], za[j], xb[j], yb[j], zb[j], l2[j], real)
        exx = p0[j] * e0 + p1[j] * e1 + p2[j] * e2
        eyy = p3[j] * e0 + p4[j] * e1 + p5[j] * e2
        exy = HALF * (p6[j] * e0 + p7[j] * e1 + p8[j] * e2)
        sxx, syy, sxy = stress_of_wrinkled(exx, eyy, exy, young[j], plane[j], ratio[j], compression, crowding)
        t0 = p0[j] * sxx + p3[j] * syy + p6[j] * sxy
        t1 = p1[j] * sxx + p4[j] * syy + p7[j] * sxy
        t2 = p2[j] * sxx + p5[j] * syy + p8[j] * sxy
        _pull(ux, uy, uz, vx, vy, vz, wx, wy, wz, t0, t1, t2, j, out)


@kernel
def _add(F: np.ndarray, a: int, n: int, forces: np.ndarray, row: int) -> None:
    """Add three rows of `forces` from `row` on to the columns of F from a on."""
    for k in range(3):
        f = F[k, a : a + n]
        begin = (row + k) * BLOCK
        more = forces[begin : begin + n]
        for j in range(n):
            f[j] += more[j]


@kernel
def add_force(X: np.ndarray, F: np.ndarray, membrane: Membrane, scratch: np.ndarray) -> None:
    """Add the membrane force at the positions X [m] to F [N], both in slots and copies."""
    table = membrane.bands
    for r in range(table.shape[0]):
        for done in range(0, table[r, 1], BLOCK):
            n = min(table[r, 1] - done, BLOCK)
            e = table[r, 0] + done
            a = table[r, 2] + done
            b = table[r, 3] + done
            c = table[r, 4] + done
            _forces(X, a, b, c, membrane.L2, membrane.S, e, n, scratch)
            _add(F, a, n, scratch, 0)
            _add(F, b, n, scratch, 3)
            _add(F, c, n, scratch, 6)


@kernel
def add_force_of_wrinkled(X: np.ndarray, F: np.ndarray, membrane: Membrane, scratch: np.ndarray) -> None:
    """Add the force of cloth that resists compression less than tension, like `add_force`."""
    table = membrane.bands
    for r in range(table.shape[0]):
        for done in range(0, table[r, 1], BLOCK):
            n = min(table[r, 1] - done, BLOCK)
            e = table[r, 0] + done
            a = table[r, 2] + done
            b = table[r, 3] + done
            c = table[r, 4] + done
            _forces_of_wrinkled(X, a, b, c, membrane.L2, membrane, e, n, scratch)
            _add(F, a, n, scratch, 0)
            _add(F, b, n, scratch, 3)
            _add(F, c, n, scratch, 6)


@kernel
def largest_stretch(X: np.ndarray, membrane: Membrane) -> float:
    """Return the maximum ratio of an edge's length to its rest length; NaN if any number is not finite."""
    table = membrane.bands
    L2 = membrane.L2
    worst = 0.0
    for r in range(table.shape[0]):
        e = table[r, 0]
        n = table[r, 1]
        for q in range(3):
            i = table[r, 2 + (q + 1) % 3]
            k = table[r, 2 + (q + 2) % 3]
            for j in range(n):
                if L2[q, e + j] > 0.0:
                    s = 0.0
                    for d in range(3):
                        s += (X[d, k + j] - X[d, i + j]) ** 2
                    s /= L2[q, e + j]
                    if not s <= worst:
                        worst = s
                        if s != s:
                            return np.nan
    return np.sqrt(worst)
