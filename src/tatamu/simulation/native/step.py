"""Time stepping: symplectic Euler at three rates (docs/theory/native.md).

In an outer step, bending changes ("kicks") the velocities once or more, and after each kick, membrane, gravity and drag
act in small substeps. (If gravity only acted once per outer step, the membrane would vibrate, and cloth would fall 0.2
% too far in half a second.) Then contact and the table correct the positions, several times if layers are crushed, and
the velocities change by the same corrections. Held vertices have an inverse mass of zero, and follow their path at
constant velocity within an outer step.

A slot is the memory position of a vertex. In arrays such as X, some slots have copies behind the last slot. Forces have
single precision, but come from edges and strains in double precision.
"""

from __future__ import annotations

import numpy as np
from numba import types

from tatamu.simulation.native import air as surroundings
from tatamu.simulation.native.addresses import Addresses
from tatamu.simulation.native.air import Air
from tatamu.simulation.native.compiled import call, inlined, kernel, unlocked
from tatamu.simulation.native.contact import gauss_seidel
from tatamu.simulation.native.geometry import copy
from tatamu.simulation.native.model import ElasticModel
from tatamu.simulation.native.system import Hands, Span, State, System


@kernel
def copy_out(X: np.ndarray, copied: np.ndarray, slots: int) -> None:
    """Copy the values of the slots `copied` behind the last slot."""
    for k in range(3):
        x = X[k]
        for i in range(copied.shape[0]):
            x[slots + i] = x[copied[i]]


@kernel
def _add_back(F: np.ndarray, copied: np.ndarray, slots: int) -> None:
    """Add the forces on copies to the forces on their slots, and clear the copies."""
    for k in range(3):
        f = F[k]
        for i in range(copied.shape[0]):
            f[copied[i]] += f[slots + i]
            f[slots + i] = 0.0


@kernel
def _look_ahead(Y: np.ndarray, X: np.ndarray, V: np.ndarray, ahead: float) -> None:
    """Set Y to the positions in the time `ahead` [s] at the present velocities."""
    n = V.shape[1]
    for k in range(3):
        y = Y[k, :n]
        x = X[k, :n]
        v = V[k, :n]
        for i in range(n):
            y[i] = x[i] + ahead * v[i]


@inlined
def _kick_by_bending(state: State, elastic: ElasticModel, air: Air, kernels: Addresses, kick: float) -> None:
    """Change the velocities by the bending forces in a time `kick` [s]."""
    slots = state.V.shape[1]
    _look_ahead(state.Y, state.X, state.V, 0.0)
    copy_out(state.Y, elastic.bending.copies, slots)
    call(kernels.bend, None, (state.Y, state.F, elastic.bending, state.hinges))
    _add_back(state.F, elastic.bending.copies, slots)
    if air.directional:
        call(kernels.resist_air, None, (state.V, state.F, state.inverse_mass, state.surface, kick, 0.0, 0.0))
    for k in range(3):
        v = state.V[k]
        f = state.F[k, :slots]
        for i in range(slots):
            v[i] += kick * state.inverse_mass[i] * f[i]
            f[i] = 0.0


@kernel
def _kick_and_drift(state: State, air: Air, h: float, ahead: float) -> None:
    """Make a substep h of symplectic Euler, and set Y to the positions in the time `ahead` after it.

    Drag depends on the velocity alone, so it does not change the shape in which cloth rests.
    """
    n = state.V.shape[1]
    slower = -h * air.drag / (1.0 + h * air.drag)
    for k in range(3):
        x = state.X[k, :n]
        v = state.V[k, :n]
        y = state.Y[k, :n]
        f = state.F[k, :n]
        fall = h * air.gravity if k == 2 else 0.0
        for i in range(n):
            faster = v[i] + state.free[i] * (slower * v[i] - fall) + h * state.inverse_mass[i] * f[i]
            v[i] = faster
            x[i] += h * faster
            y[i] = x[i] + ahead * faster
            f[i] = 0.0


@inlined
def _substep(state: State, elastic: ElasticModel, air: Air, kernels: Addresses, h: float, damping: float) -> None:
    """Make a substep with the membrane forces at Y, the positions in the damping time tau_d (Kelvin-Voigt damping)."""
    slots = state.V.shape[1]
    copy_out(state.Y, elastic.membrane.copies, slots)
    call(kernels.stretch, None, (state.Y, state.F, elastic.membrane, state.triangle_forces))
    _add_back(state.F, elastic.membrane.copies, slots)
    if air.directional:
        slower = -h * air.drag / (1.0 + h * air.drag)
        fall = h * air.gravity
        call(kernels.resist_air, None, (state.V, state.F, state.inverse_mass, state.surface, h, fall, slower))
    _kick_and_drift(state, air, h, damping)


@kernel
def _lead(state: State, hands: Hands, number: int, outer_step: float) -> None:
    """Give held vertices the velocity that brings them onto their path at the end of outer step `number`."""
    for i in range(hands.vertex.shape[0]):
        v = hands.vertex[i]
        for k in range(3):
            target = hands.base[i, k] + hands.path[hands.gripper[i], number + 1, k]
            state.V[k, state.slot[v]] = (target - state.positions.x[v, k]) / outer_step


@kernel
def _gather(X: np.ndarray, slot: np.ndarray, x: np.ndarray, predicted: np.ndarray) -> float:
    """Copy positions from slots to `x` and `predicted`, and return the sum of their squares [m^2]."""
    row_x, row_y, row_z = X[0], X[1], X[2]
    square = 0.0
    for v in range(slot.shape[0]):
        s = slot[v]
        px, py, pz = row_x[s], row_y[s], row_z[s]
        x[v, 0] = px
        x[v, 1] = py
        x[v, 2] = pz
        predicted[v, 0] = px
        predicted[v, 1] = py
        predicted[v, 2] = pz
        square += px * px + py * py + pz * pz
    return square


@kernel
def _scatter(x: np.ndarray, predicted: np.ndarray, slot: np.ndarray, X: np.ndarray, V: np.ndarray, rate: float) -> None:
    """Copy corrected positions back to slots, and add the corrections times `rate` [1/s] to the velocities."""
    row_x, row_y, row_z = X[0], X[1], X[2]
    row_u, row_v, row_w = V[0], V[1], V[2]
    for i in range(slot.shape[0]):
        s = slot[i]
        row_x[s] = x[i, 0]
        row_y[s] = x[i, 1]
        row_z[s] = x[i, 2]
        row_u[s] += rate * (x[i, 0] - predicted[i, 0])
        row_v[s] += rate * (x[i, 1] - predicted[i, 1])
        row_w[s] += rate * (x[i, 2] - predicted[i, 2])


@inlined
def _outer_step(system: System, hands: Hands, number: int) -> bool:
    """Make one outer step, and return whether the cloth stayed finite and close enough to the origin."""
    state = system.state
    sizes = system.sizes
    kernels = system.kernels
    positions = state.positions
    counters = system.contact.counters
    total = sizes.kicks * sizes.substeps_per_kick
    farthest = system.limits.farthest
    _lead(state, hands, number, sizes.outer_step)
    if system.air.directional and number % surroundings.EVERY == 0:
        seconds = surroundings.EVERY * sizes.outer_step
        surface = (state.V, state.surface, system.air, positions)
        call(kernels.meet_air, None, (*surface, system.mesh.faces, state.slot, state.free, seconds))
    counters.outer_step += 1
    per_round = (total + counters.rounds - 1) // counters.rounds
    longest = 0.0
    done = 0
    rigid_bodies = system.bodies.radius.shape[0] > 0
    near_bodies = False
    while done < total:
        copy(positions.x, positions.start)
        until = min(done + per_round, total)
        if rigid_bodies:
            near_bodies = call(kernels.near_bodies, types.boolean, (system, number, done, until, total))
        for substep in range(done, until):
            kicked = substep % sizes.substeps_per_kick == 0
            if kicked:
                _kick_by_bending(state, system.elastic, system.air, kernels, sizes.kick)
            if kicked or substep == done:  # Y is not valid after bending or contact
                _look_ahead(state.Y, state.X, state.V, sizes.damping)
            _substep(state, system.elastic, system.air, kernels, sizes.substep, sizes.damping)
            if near_bodies:
                call(kernels.meet_bodies, None, (system, number, substep, total))
        if not _gather(state.X, state.slot, positions.x, positions.predicted) < farthest * farthest:
            return False
        elapsed = (until - done) * sizes.substep
        if rigid_bodies:
            call(kernels.place_bodies, None, (system.bodies, number, done / total, until / total))
        correction = gauss_seidel.resolve(
            positions, system.mesh, system.contact, system.bodies, system.plane, system.options, kernels, elapsed
        )
        _scatter(positions.x, positions.predicted, state.slot, state.X, state.V, 1.0 / elapsed)
        longest = max(longest, correction)
        done = until
    counters.rounds = gauss_seidel.rounds_of_next_step(
        counters.rounds, longest, system.mesh.thickness, total, system.options
    )
    return True


@unlocked
def advance(system: System, hands: Hands, frames: np.ndarray, span: Span) -> tuple[int, float]:
    """Make outer steps, and return the step that was reached and the largest stretch in the last frame.

    `frames` receives the positions in the frames after the first step [m], shape (f, n, 3). The step is `span.last`, or
    less if the cloth exceeded a limit.
    """
    state = system.state
    stretching = system.elastic.membrane
    number = span.first
    stretch = 1.0
    begin = span.first // span.per_frame + 1
    while number < span.last and stretch <= system.limits.largest_stretch:
        until = min((number // span.per_frame + 1) * span.per_frame, span.last)
        near = True
        while near and number < until:
            near = _outer_step(system, hands, number)
            if near:
                number += 1
        framed = number % span.per_frame == 0
        if framed or number < until:  # only here, so that the result does not depend on where a run is cut
            copy_out(state.X, stretching.copies, state.V.shape[1])
            stretch = call(system.kernels.largest_stretch, types.float64, (state.X, stretching))
        if number < until:
            break
        if framed:
            copy(state.positions.x, frames[number // span.per_frame - begin])
    return number, stretch
