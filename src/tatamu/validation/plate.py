"""Rigid plates in air, solved from first principles: a plate that falls without turning, and one that swings.

Symbols: rho areal density and m_a added mass [kg/m^2], c linear [N s/m^3] and q quadratic drag [kg/m^3].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.signal import find_peaks

from tatamu.material import Material

LEAST_TURN = 1e-9
"""Least angle since a turn [rad]."""


@dataclass(frozen=True)
class Pushed:
    """A mass per area that a constant force pushes against drag: M dv/dt = f - c v - q v^2, from rest."""

    mass: float
    """M [kg/m^2]."""
    force: float
    """f [N/m^2], not negative."""
    linear: float
    """c [N s/m^3]."""
    quadratic: float
    """q [kg/m^3]."""

    @property
    def terminal_speed(self) -> float:
        """Positive root of f = c v + q v^2 [m/s]; infinite without drag."""
        root = np.sqrt(self.linear**2 + 4.0 * self.quadratic * self.force)
        return 2.0 * self.force / (self.linear + root) if root > 0.0 else np.inf

    def distance(self, time: float) -> float:
        """Return the distance after a time [s] from rest [m], for nonzero drag.

        v1 and -v2 are the roots of the right side, beta = (c + 2 q v1) / M and e = exp(-beta t). The speed is v1 (1 -
        e) / (1 + v1 / v2 e). Its integral is v1 t - (v1 / beta) (1 + 1 / r) ln(..).
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
    """Return the laws of motion of a plate falling at a tilt [rad], along its normal and along its surface.

    Every part of it has the same velocity and normal, so nothing turns it.
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
    """Period of small swings without drag of a plate hung by its upper edge [s]: 2 pi sqrt(2 L M / (3 g rho))."""
    heavier = 1.0 + material.air_added_mass / material.areal_density
    return float(2.0 * np.pi * np.sqrt(2.0 * length * heavier / (3.0 * gravity)))


def hanging(material: Material, length: float, angle: float, times: np.ndarray, gravity: float) -> np.ndarray:
    """Angles of a plate hung by its upper edge and let go at `angle` [rad], shape (k,), at times [s], shape (k,).

    Per width, with every velocity along the normal:
    M L^3 / 3 a'' = -rho g L^2 / 2 sin(a) - c L^3 / 3 a' - int_0^L max(q, k / (r b)^(1/3)) r^3 dr |a'| a',
    where b is the angle since the plate turned around.
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
    turns_around.direction = -1.0  # type: ignore[attr-defined]  # from then on it would swing up again
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
    """Moment of the quadratic drag of a plate over the square of its rate, per width [kg m]; b: `turned` [rad]."""
    steady = material.air_drag_quadratic
    turning = material.air_drag_turning / np.cbrt(max(turned, LEAST_TURN))
    if turning == 0.0:
        return steady * length**4 / 4
    near = min((turning / steady) ** 3 if steady else np.inf, length)  # nearer to the hinge the second one is more
    return float(turning * near ** (11 / 3) / (11 / 3) + steady * (length**4 - near**4) / 4)


@dataclass(frozen=True)
class Swing:
    """Period and decay of a swing."""

    period: float
    """Mean time between turning points on one side [s]."""
    decrement: np.ndarray
    """Logarithm of each excursion over the next one on the same side [-]."""
    excursion: np.ndarray
    """Peak to peak about that time, in the unit of the signal."""


def swing_of(times: np.ndarray, signal: np.ndarray) -> Swing:
    """The swing in a signal, shape (k,), at even times [s], shape (k,), by its turning points.

    The signal swings about zero and passes it at least four times; the part before the first time is left out.
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
