"""Time-optimal path parameterisation (Pham and Pham 2018) by the library toppra.

The timing of a path q(s) respects the joints' limits and an upper bound on ds/dt. If s is the simulated time and the
bound is 1, the robot is never faster than the simulated motion.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from tatamu.robots.extras import needed
from tatamu.robots.placement import Refused

KEEP = 0.98
"""Fraction of each joint limit that plans use, because toppra respects limits only at grid points."""


STILL = 1e-5
"""Minimum motion of a joint that is timed [rad]; smaller motions disturb the linear programs."""


@dataclass(frozen=True)
class Timed:
    """A path of the joints with its timing."""

    duration: float
    """Duration of the motion [s]."""
    angles: Callable[[np.ndarray], np.ndarray]
    """Function from n times between 0 and `duration` [s] to the angles of k joints [rad], shape (n, k)."""
    parameter: Callable[[np.ndarray], np.ndarray]
    """Function from n times [s] to the path parameters s at these times, shape (n,)."""

    def slowed(self, scale: float) -> Timed:
        """Return the motion along the same path, with its speed multiplied by `scale`."""
        return Timed(
            self.duration / scale,
            lambda times: self.angles(times * scale),
            lambda times: self.parameter(times * scale),
        )


class _Path:
    """The path q(s) as toppra needs it."""

    def __init__(self, spline: CubicSpline, columns: np.ndarray) -> None:
        self._spline, self._columns = spline, columns
        self.path_interval = np.array([spline.x[0], spline.x[-1]])
        self.waypoints = (spline.x, self(spline.x))

    @property
    def dof(self) -> int:
        return int(self._columns.sum()) + 1

    @property
    def duration(self) -> float:
        return float(self.path_interval[1] - self.path_interval[0])

    def __call__(self, s: np.ndarray | float, order: int = 0) -> np.ndarray:
        values = self._spline(s, order)[..., self._columns]
        clock = (np.asarray(s, dtype=float), np.ones(np.shape(s)), np.zeros(np.shape(s)))[order]
        return np.concatenate([values, clock[..., None]], axis=-1)


def timed(spline: CubicSpline, rate: float, speed: np.ndarray, acceleration: np.ndarray) -> Timed:
    """Find the fastest time parameterisation of a path that starts and ends at rest.

    Args:
        spline: The path q(s) of k joints [rad].
        rate: Upper bound on ds/dt.
        speed: Speed limit of each of the k joints [rad/s], shape (k,).
        acceleration: Acceleration limit of each of the k joints [rad/s^2], shape (k,).

    Raises:
        Refused: If no motion along the path satisfies the limits.
    """
    toppra = needed("toppra")
    logging.getLogger("toppra").setLevel(logging.CRITICAL)
    moving = np.ptp(spline(np.linspace(spline.x[0], spline.x[-1], 101)), axis=0) > STILL
    path = _Path(spline, moving)
    length = path.duration
    # The change of ds/dt is limited too. Without this limit, ds/dt would jump on a path without motion. The limit is so
    # high that it costs almost no time.
    sudden = 50 * rate * max(1.0, rate / length)
    bounds = np.append(KEEP * speed[moving], rate), np.append(KEEP * acceleration[moving], sudden)
    constraints = [
        toppra.constraint.JointVelocityConstraint(np.stack([-bounds[0], bounds[0]], axis=1)),
        toppra.constraint.JointAccelerationConstraint(np.stack([-bounds[1], bounds[1]], axis=1)),
    ]
    grid = np.unique(np.concatenate([np.linspace(spline.x[0], spline.x[-1], 301), spline.x]))
    algorithm = toppra.algorithm.TOPPRA(constraints, path, gridpoints=grid, parametrizer="ParametrizeConstAccel")
    still = bool((np.abs(path(path.path_interval, 1)[:, :-1]) < 1e-6).all())
    for ends in [rate * 0.999, 0.0] if still else [0.0]:
        result = algorithm.compute_trajectory(ends, ends)
        if result is not None:
            break
    else:
        raise Refused("the path cannot be driven within the joints' limits (time parameterisation failed)", 1.0)

    def parameter(times: np.ndarray) -> np.ndarray:
        return result(np.clip(times, 0, result.duration))[:, -1]

    return Timed(float(result.duration), lambda times: spline(parameter(times)), parameter)
