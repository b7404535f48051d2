"""The robot's whole motion over time: its stages, and its waits while the fingers move.

The motion is sampled at the robot's own rate. The library toppra finds the time-optimal timing of each path q(s) (Pham
and Pham 2018), which respects the joints' limits and an upper bound on ds/dt. If s is the simulated time and the bound
is 1, the robot is never faster than the simulated motion.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from pydantic import Field
from scipy.interpolate import CubicSpline

from tatamu.base.records import Record
from tatamu.robots.extras import needed
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Robot
from tatamu.robots.paths import Stage
from tatamu.robots.placement import Refused

PERIOD = 0.005
"""Time between two samples of a motion [s]. HIRONX is driven at this rate, 200 Hz."""


class Pace(Record):
    """Speeds [m/s] and waiting times [s] of the robot's motion."""

    lead: float = Field(3.0, ge=0.1)
    """Time for which the robot rests at the start, or moves exactly to its initial pose [s]."""
    closing: float = Field(1.0, ge=0.0)
    """Time in which the fingers close [s]."""
    opening: float = Field(1.5, ge=0.0)
    """Time in which the fingers open, slowly so that the cloth keeps its shape (paper, section VI-C) [s]."""
    lower_speed: float = Field(0.10, gt=0)
    raise_speed: float = Field(0.05, gt=0)
    speed_scale: float = Field(1.0, ge=0.05, le=1.0)
    """Speed of the whole motion, including waits, relative to the highest speed that the robot and the fold allow."""


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


@dataclass(frozen=True)
class TimedStage:
    """A stage or a wait of the motion, with its start time."""

    name: str
    start: float
    timed: Timed

    @property
    def end(self) -> float:
        """End of the stage or wait [s]."""
        return self.start + self.timed.duration


@dataclass(frozen=True)
class Motion:
    """Joint angles of the robot over time."""

    times: np.ndarray
    """Times of the n samples [s], shape (n,). PERIOD is the time from one sample to the next."""
    angles: np.ndarray
    """Angles of all nq joints at each sample [rad], shape (n, nq)."""
    parts: tuple[TimedStage, ...]
    speed_scale: float = 1.0

    def part(self, name: str) -> TimedStage:
        """Return the stage or the wait with this name."""
        return next(part for part in self.parts if part.name == name)

    def rows(self, name: str) -> np.ndarray:
        """Return the indices of the m samples within a stage or a wait, shape (m,)."""
        part = self.part(name)
        return np.flatnonzero((self.times >= part.start) & (self.times <= part.end))

    def simulated(self, rows: np.ndarray) -> np.ndarray:
        """Return the time in the simulation that belongs to each of m samples of the fold [s], shape (m,)."""
        fold = self.part("fold")
        return fold.timed.parameter(self.times[rows] - fold.start)


def motion(robot: Robot, hands: HandMotion, stages: list[Stage], pace: Pace, hovers: bool = False) -> Motion:
    """Return the fastest motion through all stages that the robot's limits and `pace` allow.

    Between the stages, the robot waits, for example while its fingers close. If `hovers` is true, the jaws stay open.
    """
    speed, acceleration = robot.planned()
    by_name = {stage.name: stage for stage in stages}
    waits = {
        "lead": (pace.lead, robot.initial),
        "close": (pace.closing, by_name["fold"].spline(hands.times[0])),
        "settle": (max(0.0, hands.timing.opens - hands.timing.arrives), by_name["fold"].spline(hands.times[-1])),
        "open": (pace.opening, by_name["fold"].spline(hands.times[-1])),
    }
    parts: list[TimedStage] = []
    start = 0.0
    for name in ("lead", "approach", "lower", "enter", "close", "fold", "settle", "open", "raise", "return"):
        if name in waits:
            driven = _still(*waits[name])
        else:
            # Lower accelerations close above the table make the robot more accurate, because its drives follow commands
            # with a delay. Up to a rate ds/dt of 20 / s, only the joints' limits slow a move between two poses down.
            gently = 0.25 if name in ("lower", "enter", "raise") else 1.0
            driven = timed(by_name[name].spline, min(by_name[name].rate, 20.0), speed, gently * acceleration)
        driven = driven.slowed(pace.speed_scale)
        parts.append(TimedStage(name, start, driven))
        start += driven.duration
    times = PERIOD * np.arange(int(np.ceil(start / PERIOD)) + 1)
    which = np.searchsorted([part.start for part in parts], times, side="right") - 1
    angles = np.concatenate(
        [part.timed.angles(times[which == number] - part.start) for number, part in enumerate(parts)]
    )
    fingers = [part for part in parts if part.name in ("close", "open")]
    knots = [part.start + elapsed for part in fingers for elapsed in (0.0, max(part.timed.duration, 1e-6))]
    closed = 0.0 * times if hovers else np.interp(times, knots, [0.0, 1.0, 1.0, 0.0])
    for arm in robot.folding:
        for joint, (opened, shut) in arm.jaw.fingers.items():
            angles[:, robot.finger_columns[joint]] = opened + closed * (shut - opened)
    angles = robot.followed(angles)
    return Motion(times, angles, tuple(parts), pace.speed_scale)


def _still(duration: float, q: np.ndarray) -> Timed:
    return Timed(duration, lambda times: np.broadcast_to(q, (len(times), len(q))), lambda times: times)


class _Path:
    """The path q(s) as toppra needs it."""

    def __init__(self, spline: CubicSpline, columns: np.ndarray) -> None:
        self._spline, self._columns = spline, columns
        self.path_interval = np.array([spline.x[0], spline.x[-1]])
        self.waypoints = (spline.x, self(spline.x))
        self.dof = int(columns.sum()) + 1
        self.duration = float(spline.x[-1] - spline.x[0])

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
    # Motions of a joint below 1e-5 rad are not timed, because they disturb the linear programs.
    moving = np.ptp(spline(np.linspace(spline.x[0], spline.x[-1], 101)), axis=0) > 1e-5
    path = _Path(spline, moving)
    length = path.duration
    # The change of ds/dt is limited too. Without this limit, ds/dt would jump on a path without motion. The limit is so
    # high that it costs almost no time.
    sudden = 50 * rate * max(1.0, rate / length)
    kept = 0.98  # fraction of each joint limit that plans use, because toppra respects limits only at grid points
    bounds = np.append(kept * speed[moving], rate), np.append(kept * acceleration[moving], sudden)
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
