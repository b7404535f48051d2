"""The robot's whole motion over time: its stages, and its waits while the fingers move.

The motion is sampled at the robot's own rate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from tatamu.base.records import Record
from tatamu.robots.hands import HandMotion
from tatamu.robots.model import Arm, Robot
from tatamu.robots.paths import Stage
from tatamu.robots.planfile import FingerEvent, GripperCommand, Segment
from tatamu.robots.timing import Timed, timed

PERIOD = 0.005
"""Time between two samples of a motion [s]. HIRONX is driven at this rate, 200 Hz."""
ORDER = ("lead", "approach", "lower", "enter", "close", "fold", "settle", "open", "raise", "return")
"""Names of a motion's stages and waits, in their order."""
AT_THE_TABLE = ("lower", "enter", "raise")
GENTLE = 0.25
"""Fraction of the joints' acceleration limits that is used close above the table.

Lower accelerations make the robot more accurate, because its drives follow commands with a delay.
"""
JOINT_MOVE = 20.0
"""Maximum rate ds/dt at which a stage moves from one pose (s = 0) to the next pose (s = 1) [1/s].

The rate is so high that only the joints' limits slow these stages down.
"""


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
class TimedStage:
    """A stage or a wait of the motion, with its start time."""

    name: str
    start: float
    timed: Timed


@dataclass(frozen=True)
class Motion:
    """Joint angles of the robot over time."""

    times: np.ndarray
    """Times of the n samples [s], shape (n,). PERIOD is the time from one sample to the next."""
    angles: np.ndarray
    """Angles of all nq joints at each sample [rad], shape (n, nq)."""
    parts: tuple[TimedStage, ...]
    events: tuple[FingerEvent, ...]
    speed_scale: float = 1.0

    def part(self, name: str) -> TimedStage:
        """Return the stage or the wait with this name."""
        return next(part for part in self.parts if part.name == name)

    def rows(self, name: str) -> np.ndarray:
        """Return the indices of the m samples within a stage or a wait, shape (m,)."""
        part = self.part(name)
        inside = (self.times >= part.start) & (self.times <= part.start + part.timed.duration)
        return np.flatnonzero(inside)

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
        "settle": (
            max(0.0, hands.timing.opens - hands.timing.arrives),
            by_name["fold"].spline(hands.times[-1]),
        ),
        "open": (pace.opening, by_name["fold"].spline(hands.times[-1])),
    }
    parts: list[TimedStage] = []
    start = 0.0
    for name in ORDER:
        if name in waits:
            driven = _still(*waits[name])
        else:
            stage = by_name[name]
            gently = GENTLE if name in AT_THE_TABLE else 1.0
            driven = timed(stage.spline, min(stage.rate, JOINT_MOVE), speed, gently * acceleration)
        driven = driven.slowed(pace.speed_scale)
        parts.append(TimedStage(name, start, driven))
        start += driven.duration
    times = PERIOD * np.arange(int(np.ceil(start / PERIOD)) + 1)
    angles = _sampled(parts, times)
    by_part = {part.name: part for part in parts}
    closed = 0.0 * times if hovers else closing(times, by_part["close"], by_part["open"])
    for arm in robot.folding:
        for joint, (opened, shut) in arm.jaw.fingers.items():
            angles[:, robot.finger_columns[joint]] = opened + closed * (shut - opened)
    angles = robot.followed(angles)
    return Motion(times, angles, tuple(parts), _events(robot, parts), pace.speed_scale)


def closing(times: np.ndarray, close: TimedStage, opening: TimedStage) -> np.ndarray:
    """Return how far the jaws are closed at each of n times: 0 if open, 1 if closed, shape (n,)."""
    knots = [part.start + elapsed for part in (close, opening) for elapsed in (0.0, max(part.timed.duration, 1e-6))]
    return np.interp(times, knots, [0.0, 1.0, 1.0, 0.0])


def _still(duration: float, q: np.ndarray) -> Timed:
    return Timed(duration, lambda times: np.broadcast_to(q, (len(times), len(q))), lambda times: times)


def _sampled(parts: list[TimedStage], times: np.ndarray) -> np.ndarray:
    starts = np.array([part.start for part in parts])
    which = np.searchsorted(starts, times, side="right") - 1
    angles = [part.timed.angles(times[which == number] - part.start) for number, part in enumerate(parts)]
    return np.concatenate(angles)


def _events(robot: Robot, parts: list[TimedStage]) -> tuple[FingerEvent, ...]:
    starts = {part.name: part.start for part in parts}
    return tuple(
        FingerEvent.model_validate({"time": round(starts[name], 6), "arm": arm.name, "event": name})
        for name in ("close", "open")
        for arm in robot.folding
    )


SHUT = 0.0
"""Width to which the jaws are commanded when they grip cloth, which stops them earlier [m]."""


def segments(motion: Motion, hover: float) -> tuple[Segment, ...]:
    """Return the parts of the robot's motion. A program that plays the motion can stop between two parts."""
    closing, opening = motion.part("close"), motion.part("open")
    end = max(part.start + part.timed.duration for part in motion.parts)
    spans = (
        ("approach", 0.0, closing.start, "close"),
        ("fold", closing.start + closing.timed.duration, opening.start, "open"),
        ("leave", opening.start + opening.timed.duration, end, ""),
    )
    return tuple(
        Segment.model_validate(
            {
                "name": name,
                "start": round(begins, 6),
                "duration": round(ends - begins, 6),
                "then": "" if hover else then,
            }
        )
        for name, begins, ends, then in spans
    )


def gripper_commands(motion: Motion, arms: tuple[Arm, ...], hover: float) -> tuple[GripperCommand, ...]:
    """Return the commands to the grippers in the order of time.

    The jaws open at the start, close at the event `close` and open again at the event `open`.
    """
    widths = [("lead", False)] if hover else [("lead", False), ("close", True), ("open", False)]
    return tuple(
        GripperCommand.model_validate(
            {
                "time": round(motion.part(stage).start, 6),
                "arm": arm.name,
                "width": SHUT if closed else arm.jaw.opening,
                "force": arm.jaw.force,
                "duration": round(motion.part(stage).timed.duration, 6),
            }
        )
        for stage, closed in widths
        for arm in arms
    )
