"""Rigid bodies of a running scene, such as fingers, that follow the targets of a controller."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from tatamu.base.errors import InputError
from tatamu.simulation.body import UNIT, slerp
from tatamu.simulation.native.contact.bodies.state import Bodies
from tatamu.simulation.scene import Scene


@dataclass(frozen=True)
class BodyTarget:
    """The target of a rigid body in one call of `Simulation.advance`."""

    position: Sequence[float] | np.ndarray | None = None
    """Centre at the end of the call [m], shape (3,); None if the body does not move."""
    orientation: Sequence[float] | np.ndarray | None = None
    """Unit quaternion (w, x, y, z) at the end of the call, from the body's frame to the scene's; None for no turn."""


@dataclass(frozen=True)
class BodyPose:
    """Position and orientation of a body."""

    position: np.ndarray
    """Centre [m], shape (3,)."""
    orientation: np.ndarray
    """Unit quaternion (w, x, y, z), shape (4,)."""


class LedBodies:
    """All rigid bodies of a scene, with time counted in outer steps."""

    def __init__(self, scene: Scene, bodies: Bodies, outer_step: float) -> None:
        """Let all bodies follow the scene; targets change the paths in `bodies`."""
        self._bodies = scene.bodies
        self._outer_step = outer_step
        self._positions = bodies.positions
        self._orientations = bodies.orientations
        self._led: dict[int, BodyPose] = {}

    def check(
        self, targets: Sequence[BodyTarget | None], number: int, stop: int, fastest: float
    ) -> dict[int, BodyPose]:
        """Return the poses that targets require at outer step `stop`, by index of the body, or raise InputError."""
        if len(targets) != len(self._bodies):
            raise InputError(f"bodies: must have one item for each of {len(self._bodies)} bodies, given {len(targets)}")
        seconds = (stop - number) * self._outer_step
        return {
            index: _pose(target, self._now(index, number), f"bodies[{index}]", seconds, fastest)
            for index, target in enumerate(targets)
            if target is not None
        }

    def lead(self, poses: Mapping[int, BodyPose], number: int, stop: int) -> None:
        """Move bodies to poses at constant velocity. Bodies without a new pose stay at their last target."""
        if not poses and not self._led:
            return
        part = np.arange(stop - number + 1)
        for index in sorted({*poses, *self._led}):
            start = self._now(index, number)
            end = poses.get(index, start)
            way = part[:, None] / max(stop - number, 1) * (end.position - start.position)
            turns = np.stack([start.orientation, end.orientation])
            self._positions[index, number : stop + 1] = start.position + way
            self._orientations[index, number : stop + 1] = slerp(part, np.array([0, max(stop - number, 1)]), turns)
        self._led |= poses

    def state(self) -> dict[int, BodyPose]:
        """Return a copy of the last target pose of each body that has had a target."""
        return dict(self._led)

    def restore(self, state: Mapping[int, BodyPose]) -> None:
        """Set the bodies to a state that `state` returned for the same scene.

        Bodies without a target get back their path in the scene. For the others, the next `lead` writes the path.
        """
        times = np.arange(self._positions.shape[1]) * self._outer_step
        for index in self._led.keys() - state.keys():
            self._positions[index], self._orientations[index] = self._bodies[index].path(times)
        self._led = dict(state)

    def _now(self, index: int, number: int) -> BodyPose:
        led = self._led.get(index)
        return led or BodyPose(self._positions[index, number].copy(), self._orientations[index, number].copy())


def _pose(target: BodyTarget, now: BodyPose, name: str, seconds: float, fastest: float) -> BodyPose:
    """Return the pose that a target requires, or raise InputError if the body cannot reach it in `seconds`."""
    position = now.position if target.position is None else _numbers(target.position, 3, f"{name}.position", "[m]")
    check_speed(f"{name}.position", float(np.linalg.norm(position - now.position)), seconds, fastest)
    if target.orientation is None:
        return BodyPose(position, now.orientation)
    turned = _numbers(target.orientation, 4, f"{name}.orientation", "(w, x, y, z)")
    length = float(np.linalg.norm(turned))
    if not abs(length - 1.0) <= UNIT:
        raise InputError(f"{name}.orientation: must be a unit quaternion (w, x, y, z), given length {length:.3g}")
    turned = turned / length
    angle = 2.0 * float(np.arccos(min(abs(float(turned @ now.orientation)), 1.0)))
    fastest_turn = 50.0  # [rad/s], at which the end of a finger of 0.2 m moves at 10 m/s
    if not angle <= fastest_turn * seconds:
        raise InputError(
            f"{name}.orientation: must be reachable at up to {fastest_turn:g} rad/s, given a turn of "
            f"{180 * angle / pi:.3g} degrees in {seconds:.3g} s"
        )
    return BodyPose(position, turned)


def check_speed(name: str, way: float, seconds: float, fastest: float) -> None:
    """Raise InputError if a way [m] cannot be covered in `seconds` at the speed `fastest` [m/s]."""
    if not way <= fastest * (1.0 + 1e-9) * seconds:
        raise InputError(
            f"{name}: must be reachable at up to {fastest:g} m/s, given a distance of {way:.3g} m in {seconds:.3g} s"
        )


def _numbers(given: Sequence[float] | np.ndarray, count: int, name: str, what: str) -> np.ndarray:
    try:
        numbers = np.array(given, dtype=float)
    except (TypeError, ValueError):
        numbers = np.empty(0)
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise InputError(f"{name}: must be {count} finite numbers {what}, given {given}")
    return numbers
