"""Motion of rigid plates in air, solved from first principles.

One plate falls without turning, and another plate swings.

Symbols: rho is the areal density and m_a the added mass [kg/m^2]. c is the linear drag [N s/m^3] and q the quadratic
    drag [kg/m^3]. k is the constant of the drag after the motion has reversed, and L is the length of the plate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import find_peaks

from tatamu.simulation.material import Material

MIN_TURN = 1e-9
"""Smallest angle that a plate has turned since its motion last reversed [rad]. It prevents a division by zero."""


@dataclass(frozen=True)
class Pushed:
    """A mass per area M that a constant force f pushes against drag, from rest.

    The equation of motion is M dv/dt = f - c v - q v^2, with the speed v, the linear drag c and the quadratic drag q.
    """

    mass: float
    """Mass per area M [kg/m^2]."""
    force: float
    """Force per area f [N/m^2], which is not negative."""
    linear: float
    """Linear drag c [N s/m^3]."""
    quadratic: float
    """Quadratic drag q [kg/m^3]."""

    @property
    def terminal_speed(self) -> float:
        """Terminal speed v: the positive root of f = c v + q v^2 [m/s]; infinite without drag."""
        root = np.sqrt(self.linear**2 + 4.0 * self.quadratic * self.force)
        return 2.0 * self.force / (self.linear + root) if root > 0.0 else np.inf

    def distance(self, time: float) -> float:
        """Return the distance [m] after the time t [s] from rest. The drag must not be zero.

        M is the mass, c the linear drag and q the quadratic drag. The equation f = c v + q v^2 of the force f has two
        solutions: the speeds v1 and -v2. With beta = (c + 2 q v1) / M, r = v1 / v2 and e = exp(-beta t), the speed is
        v1 (1 - e) / (1 + r e). The distance is the integral of the speed:
        v1 t - (v1 / beta) (1 + 1 / r) ln((1 + r) / (1 + r e)).
        """
        fast = self.terminal_speed
        rate = (self.linear + 2.0 * self.quadratic * fast) / self.mass
        ratio = self.quadratic * fast / (self.linear + self.quadratic * fast)  # v1 / v2
        gone = 1.0 - np.exp(-rate * time)
        if ratio < 1e-9:
            return float(fast * (time - gone / rate))
        lost = (1.0 + 1.0 / ratio) * np.log((1.0 + ratio) / (1.0 + ratio * (1.0 - gone)))
        return float(fast * (time - lost / rate))


def falling(material: Material, tilt: float, gravity: float) -> tuple[Pushed, Pushed]:
    """Return the two motions of a plate that falls without turning: along its normal, and along its surface.

    The plate has the tilt `tilt` [rad]. All parts of the plate have equal velocities and normals, so nothing turns the
    plate.
    """
    weight = material.areal_density * gravity
    linear = material.air_drag
    across = Pushed(
        material.areal_density + material.air_added_mass,
        weight * np.cos(tilt),
        linear + material.air_drag_normal,
        material.air_drag_quadratic,
    )
    along = Pushed(
        material.areal_density,
        weight * np.sin(tilt),
        linear + material.air_drag_tangential,
        material.air_drag_quadratic_tangential,
    )
    return across, along


def small_swing_period(material: Material, length: float, gravity: float) -> float:
    """Return the period of small swings without drag of a plate that hangs from its upper edge [s].

    The period is 2 pi sqrt(2 L M / (3 g rho)), with M = rho + m_a. L is the length of the plate, g the acceleration of
    gravity, rho the areal density and m_a the added mass of air.
    """
    heavier = 1.0 + material.air_added_mass / material.areal_density
    return float(2.0 * np.pi * np.sqrt(2.0 * length * heavier / (3.0 * gravity)))


def hanging(material: Material, length: float, angle: float, times: np.ndarray, gravity: float) -> np.ndarray:
    """Return the angles at k times of a plate that hangs from its upper edge and is released at `angle` [rad].

    The times are `times` [s]. Angles and times have the shape (k,).

    All velocities are along the normal. The angle a follows the equation of motion per width

        M L^3 / 3 a'' = -rho g L^2 / 2 sin(a) - c L^3 / 3 a' - int_0^L max(q, k / (r b)^(1/3)) r^3 dr |a'| a'

    M is rho + m_a, with the areal density rho and the added mass of air m_a. c is the linear and q the quadratic drag,
    and k the constant of the drag after the motion has reversed. r is the distance from the upper edge, b the angle
    since the motion of the plate last reversed, L the length of the plate, and g the acceleration of gravity.
    """
    inertia = (material.areal_density + material.air_added_mass) * length**3 / 3
    weight = material.areal_density * gravity * length**2 / 2
    linear = (material.air_drag + material.air_drag_normal) * length**3 / 3

    def rate(_: float, state: np.ndarray, turn: float) -> list[float]:
        turned, speed = state
        quadratic = _turning_moment(material, length, abs(turned - turn))
        return [speed, (-weight * np.sin(turned) - linear * speed - quadratic * abs(speed) * speed) / inertia]

    def turns_around(time: float, state: np.ndarray, turn: float) -> float:
        return -float(np.sign(turn) * state[1])

    turns_around.terminal = True  # type: ignore[attr-defined]
    turns_around.direction = -1.0  # type: ignore[attr-defined]  # at this event, the motion reverses
    angles = np.empty(len(times))
    start, turn = 0.0, angle
    while start < times[-1]:
        solution = solve_ivp(
            rate,
            (start, float(times[-1])),
            [turn, 0.0],
            args=(turn,),
            events=turns_around,
            dense_output=True,
            rtol=1e-9,
            atol=1e-11,
            max_step=0.02,
        )
        during = (times >= start) & (times <= solution.t[-1])
        if during.any():
            angles[during] = solution.sol(times[during])[0]
        start, turn = float(solution.t[-1]), float(solution.y[0, -1])
    return angles


def _turning_moment(material: Material, length: float, turned: float) -> float:
    """Return the moment of quadratic drag divided by the square of the angular speed, per width [kg m].

    `turned` is the angle since the motion of the plate last reversed [rad].
    """
    steady = material.air_drag_quadratic
    turning = material.air_drag_turning / np.cbrt(max(turned, MIN_TURN))
    if turning == 0.0:
        return steady * length**4 / 4
    near = min((turning / steady) ** 3 if steady else np.inf, length)  # turning drag is larger near the hinge
    return float(turning * near ** (11 / 3) / (11 / 3) + steady * (length**4 - near**4) / 4)


@dataclass(frozen=True)
class Swing:
    """Period and decay of a swing."""

    period: float
    """Mean time between two turning points on the same side [s]."""
    decrement: np.ndarray
    """For each swing, the logarithm of a ratio: the size of this swing divided by the size of the next swing to the
    same side [-]."""
    excursion: np.ndarray
    """Peak-to-peak size of the swing to which each item of `decrement` belongs, in the unit of the signal."""


def swing_of(times: np.ndarray, signal: np.ndarray) -> Swing:
    """Return the period and the decay of a signal that swings, from its turning points.

    The signal and its k evenly spaced times [s] have the shape (k,).

    The signal swings about zero and must pass zero at least four times. The part before the first zero crossing is
    ignored.
    """
    begin = int(np.argmax(signal * signal[0] < 0.0))
    turns, values = _turning_points(times[begin:], signal[begin:])
    spread = np.abs(np.diff(values))
    return Swing(
        period=2.0 * float(np.mean(np.diff(turns))),
        decrement=2.0 * np.log(spread[:-1] / spread[1:]),
        excursion=np.sqrt(spread[:-1] * spread[1:]),
    )


def _turning_points(times: np.ndarray, signal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    found = np.sort(np.concatenate([find_peaks(signal)[0], find_peaks(-signal)[0]]))
    before, at, after = (signal[found + k] for k in (-1, 0, 1))
    shift = 0.5 * (before - after) / (before - 2.0 * at + after)
    return times[found] + shift * (times[1] - times[0]), at - 0.25 * (before - after) * shift
