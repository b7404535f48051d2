"""Time stepping: symplectic Euler at three rates.

Per outer step: bending kicks the velocities (once or more); between the kicks membrane, gravity and drag run in small
substeps, as gravity given in one blow per outer step would ring in the membrane and fall 0.2 % too far in half a
second; then contact and the table correct the positions, and the velocities by the same corrections. Where layers are
crushed, contact is resolved several times per outer step. There is no linear solve, no iteration to a tolerance. Held
vertices have inverse mass zero and follow their path at constant velocity within an outer step.

Forces are computed in single precision, from edges and strains taken in double; states are kept in double.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from tatamu.simulators.native.contact import gauss_seidel as rounds
from tatamu.simulators.native.elastic import bending, membrane

MEMBRANE_DAMPING = 5e-5
"""tau_d of the membrane's Kelvin-Voigt damping [s], at most 0.3 of the substep."""


class State(NamedTuple):
    """What changes from step to step, and scratch memory."""

    X: np.ndarray  # (3, width) positions in slots
    V: np.ndarray  # (3, slots) velocities
    Y: np.ndarray  # (3, width) positions that forces are computed at
    F: np.ndarray  # (3, width) single: forces, zero before and after each step
    forces: np.ndarray  # (9 layout.BLOCK,) scratch, single: of triangles on their corners
    H: np.ndarray  # (blocks of hinges, 8 layout.BLOCK) scratch, single: see `bending.measure`
    bend: np.ndarray  # (3, hinges and copies) scratch, single: g, g' and moments
    x: np.ndarray  # (n, 3) positions by vertex
    before: np.ndarray  # (n, 3) positions at the start of the outer step
    moved: np.ndarray  # (n, 3) positions before contact
    inverse_mass: np.ndarray  # (slots,), 0 for held vertices and fillers
    free: np.ndarray  # (slots,), 1 or 0 likewise
    slot: np.ndarray  # (n,)
    rounds: np.ndarray  # (1,) how often contact is resolved per outer step


class Hands(NamedTuple):
    """Held vertices and their paths."""

    vertex: np.ndarray  # (k,)
    base: np.ndarray  # (k, 3) positions where the hand closed
    gripper: np.ndarray  # (k,)
    path: np.ndarray  # (grippers, outer steps + 1, 3) displacements


class World(NamedTuple):
    """Numbers of the scene."""

    gravity: float
    drag: float  # 1/s
    friction_cloth: float
    friction_table: float
    has_table: bool
    height: float
    sine: float
    cosine: float
    half_thickness: float


@njit(cache=True, error_model="numpy")
def copy_out(X, copied, slots):  # type: ignore[no-untyped-def]
    """Copy the values of slots `copied` behind the last slot."""
    for k in range(3):
        x = X[k]
        for i in range(copied.shape[0]):
            x[slots + i] = x[copied[i]]


@njit(cache=True, error_model="numpy")
def _add_back(F, copied, slots):  # type: ignore[no-untyped-def]
    for k in range(3):
        f = F[k]
        for i in range(copied.shape[0]):
            f[copied[i]] += f[slots + i]
            f[slots + i] = 0.0


@njit(cache=True, error_model="numpy")
def _place(Y, X, V, h):  # type: ignore[no-untyped-def]
    """Positions h seconds ahead."""
    n = V.shape[1]
    for k in range(3):
        y, x, v = Y[k, :n], X[k, :n], V[k, :n]
        for i in range(n):
            y[i] = x[i] + h * v[i]


@njit(cache=True, error_model="numpy")
def _bend(state, elastic, h):  # type: ignore[no-untyped-def]
    slots = state.V.shape[1]
    _place(state.Y, state.X, state.V, 0.0)
    copy_out(state.Y, elastic.hinge_copies, slots)
    bending.add_force(
        state.Y,
        state.F,
        elastic.hinges,
        elastic.rest_moment,
        elastic.curls,
        elastic.curl_copies,
        elastic.K,
        state.H,
        state.bend[0],
        state.bend[1, : elastic.rest_moment.shape[0]],
        state.bend[2],
    )
    _add_back(state.F, elastic.hinge_copies, slots)
    for k in range(3):
        v, f = state.V[k], state.F[k, :slots]
        for i in range(slots):
            v[i] += h * state.inverse_mass[i] * f[i]
            f[i] = 0.0


@njit(cache=True, error_model="numpy")
def _move(state, world, h, ahead):  # type: ignore[no-untyped-def]
    """Kick by the forces and by gravity, then drift, and look so far ahead for the next step.

    Drag on the velocity alone does not change where cloth rests.
    """
    n = state.V.shape[1]
    slower = -h * world.drag / (1.0 + h * world.drag)
    for k in range(3):
        x, v, y, f = state.X[k, :n], state.V[k, :n], state.Y[k, :n], state.F[k, :n]
        fall = h * world.gravity if k == 2 else 0.0
        for i in range(n):
            faster = v[i] + state.free[i] * (slower * v[i] - fall) + h * state.inverse_mass[i] * f[i]
            v[i] = faster
            x[i] += h * faster
            y[i] = x[i] + ahead * faster
            f[i] = 0.0


@njit(cache=True, error_model="numpy")
def _stretch(state, elastic, world, h, damping):  # type: ignore[no-untyped-def]
    slots = state.V.shape[1]
    copy_out(state.Y, elastic.triangle_copies, slots)
    membrane.add_force(
        state.Y, state.F, elastic.triangles, elastic.S, elastic.L2, elastic.R, elastic.compression, state.forces
    )
    _add_back(state.F, elastic.triangle_copies, slots)
    _move(state, world, h, damping)


@njit(cache=True, error_model="numpy")
def _lead(state, hands, number, step):  # type: ignore[no-untyped-def]
    """Give held vertices the velocity that brings them onto their path at the end of the step."""
    for i in range(hands.vertex.shape[0]):
        v = hands.vertex[i]
        for k in range(3):
            target = hands.base[i, k] + hands.path[hands.gripper[i], number + 1, k]
            state.V[k, state.slot[v]] = (target - state.x[v, k]) / step


@njit(cache=True, error_model="numpy")
def _advance(state, elastic, mesh, lists, hands, world, first, last, pace, farthest):  # type: ignore[no-untyped-def]
    """Outer steps from number `first` up to `last`; the number reached, less when anything is too far away."""
    step, bends, stretches = pace
    kick = step / bends
    h = kick / stretches
    damping = min(MEMBRANE_DAMPING, 0.3 * h)
    total = bends * stretches
    for number in range(first, last):
        _lead(state, hands, number, step)
        lists.number[0] += 1
        every = (total + state.rounds[0] - 1) // state.rounds[0]
        done, correction = 0, 0.0
        while done < total:
            state.before[:] = state.x
            until = min(done + every, total)
            for substep in range(done, until):
                if substep % stretches == 0:
                    _bend(state, elastic, kick)
                if substep % stretches == 0 or substep == done:  # bending or contact came after the last look ahead
                    _place(state.Y, state.X, state.V, damping)
                _stretch(state, elastic, world, h, damping)
            if not rounds.gather(state.X, state.slot, state.x, state.moved) < farthest * farthest:
                return number
            correction = max(correction, rounds.collide(state, mesh, lists, world, (until - done) * h))
            done = until
        state.rounds[0] = rounds.pace(state.rounds[0], correction, mesh.reach[0], total)
    return last


@njit(cache=True, error_model="numpy", nogil=True)
def advance(state, elastic, mesh, lists, hands, world, frames, per_frame, first, last, pace, limits):  # type: ignore[no-untyped-def]
    """Outer steps from number `first` up to `last`.

    Args:
        state: Changed in place.
        elastic: Constants of the cloth.
        mesh: The mesh.
        lists: Its candidate pairs.
        hands: Held vertices.
        world: The scene.
        frames: To be filled with positions [m] in the frames after the first step, shape (f, n, 3).
        per_frame: Outer steps per frame.
        first: Number of the first step.
        last: Number of the step to stop before.
        pace: Outer step [s], bending steps in it, membrane steps in each of these.
        limits: Largest stretch, farthest distance from the origin [m].

    Returns:
        The number reached and the largest stretch there: `last`, unless the cloth went beyond a limit before.
    """
    number, stretch, begin = first, 1.0, first // per_frame + 1
    while number < last and stretch <= limits[0]:
        until = min((number // per_frame + 1) * per_frame, last)
        number = _advance(state, elastic, mesh, lists, hands, world, number, until, pace, limits[1])
        copy_out(state.X, elastic.triangle_copies, state.V.shape[1])
        stretch = membrane.largest_stretch(state.X, elastic.triangles, elastic.L2)
        if number < until:
            break
        if number % per_frame == 0:
            frames[number // per_frame - begin] = state.x
    return number, stretch
