"""The grippers of a running scene: their targets, their states, the vertices that they hold, and their motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import dist, inf, isfinite

import numpy as np

from tatamu.base.errors import InputError
from tatamu.simulation.native.led_bodies import check_speed
from tatamu.simulation.native.system import Hands
from tatamu.simulation.scene import Scene

Place = tuple[float, ...]
"""Coordinates x, y and z [m] as plain numbers, which are faster than arrays."""
NOWHERE: Place = (0.0, 0.0, 0.0)
"""Displacement of a gripper that is open or has just closed [m]."""


@dataclass(frozen=True)
class HandTarget:
    """The target of one gripper in one call of `Simulation.advance`."""

    displacement: Sequence[float] | np.ndarray | None = None
    """Displacement since the gripper closed, at the end of the call [m], shape (3,); None if it does not move."""
    closed: bool | None = None
    """True to close the gripper at the start of the call, False to open it, None to leave it unchanged."""
    vertices: Sequence[int] | np.ndarray | None = None
    """Vertices that the gripper grasps if it closes; None for the vertices that the scene gives."""

    def place(self, name: str) -> Place | None:
        """Return the displacement as plain numbers [m], None if there is none, or raise InputError."""
        if self.displacement is None:
            return None
        try:
            place = tuple(map(float, self.displacement))
        except (TypeError, ValueError):
            place = ()
        if len(place) != 3 or not isfinite(sum(place)):
            raise InputError(f"{name}.displacement: must be three finite numbers [m], given {self.displacement}")
        return place

    def held(
        self, name: str, before: tuple[int, ...] | None, usual: tuple[int, ...], count: int
    ) -> tuple[int, ...] | None:
        """Return the vertices that the gripper then holds, None if it is open, or raise InputError.

        It held `before` (None if it was open), grasps `usual` by default, and the cloth has `count` vertices.
        """
        closed = before is not None if self.closed is None else bool(self.closed)
        if not closed:
            if self.displacement is not None or self.vertices is not None:
                wrong = "vertices" if self.displacement is None else "displacement"
                raise InputError(f"{name}.{wrong}: must be left out while the gripper is open; close the gripper first")
            return None
        if self.vertices is None:
            return usual if before is None else before
        array = np.asarray(self.vertices)
        whole = array.ndim == 1 and len(array) > 0 and np.issubdtype(array.dtype, np.integer)
        if not whole or len(np.unique(array)) < len(array) or array.min() < 0 or array.max() >= count:
            raise InputError(f"{name}.vertices: must be different indices below {count}, given {self.vertices}")
        vertices = tuple(int(vertex) for vertex in array)
        if before is not None and set(vertices) != set(before):
            raise InputError(
                f"{name}.vertices: must be the vertices that the closed gripper holds; open the gripper before it "
                "grasps other vertices"
            )
        return before or vertices


@dataclass(frozen=True)
class Grip:
    """The vertices that a closed gripper holds."""

    vertices: np.ndarray
    """Indices of the vertices, shape (k,)."""
    base: np.ndarray
    """Their positions when the gripper closed [m], shape (k, 3)."""


@dataclass(frozen=True)
class Led:
    """A gripper that follows the targets of a controller instead of the scene."""

    vertices: tuple[int, ...] | None
    """Vertices that it holds; None if it is open."""
    displacement: Place
    """Its last target [m]; zero if it is open."""


@dataclass(frozen=True)
class GripperState:
    """What changes during a simulation, by index of the gripper."""

    grips: dict[int, Grip]
    led: dict[int, Led]


@lru_cache(maxsize=64)
def _parts(steps: int) -> np.ndarray:
    """Return the fraction of its path that a hand has covered after each of `steps` steps, shape (steps, 1)."""
    return np.arange(1, steps + 1)[:, None] / max(steps, 1)


class Grippers:
    """All grippers of a scene, with time counted in outer steps."""

    def __init__(self, scene: Scene, outer_step: float, steps: int) -> None:
        """Sample the paths of the grippers at `steps` outer steps of the length `outer_step` [s]."""
        self._grippers = scene.grippers
        self._vertices = len(scene.cloth.vertices)
        self._outer_step = outer_step
        self._steps = steps
        self._latest = 2 * scene.duration
        self._own = [tuple(gripper.vertices) for gripper in scene.grippers]
        self._closes = [self.step_at(gripper.closes) for gripper in scene.grippers]
        self._opens = [self.step_at(inf if gripper.opens is None else gripper.opens) for gripper in scene.grippers]
        self._grips: dict[int, Grip] = {}
        self._led: dict[int, Led] = {}
        self._hands: Hands | None = None
        self._times = np.arange(steps + 1) * outer_step
        self._paths = np.zeros((max(len(scene.grippers), 1), len(self._times), 3))
        for index in range(len(scene.grippers)):
            self._follow_scene(index)

    @property
    def closed(self) -> tuple[bool, ...]:
        return tuple(number in self._grips for number in range(len(self._grippers)))

    def displacements(self, number: int) -> np.ndarray:
        """Return the displacements at outer step `number` [m], shape (grippers, 3); zero if a gripper is open."""
        closed = np.reshape(self.closed, (-1, 1))
        return np.where(closed, self._paths[: len(closed), number], 0.0)

    def step_at(self, time: float) -> int:
        """Return the outer step in which an event at `time` [s] happens."""
        return round(min(time, self._latest) / self._outer_step)

    def events(self) -> list[int]:
        """Return the outer steps in which grippers close or open by the scene."""
        own = [index for index in range(len(self._own)) if index not in self._led]
        return [numbers[index] for numbers in (self._closes, self._opens) for index in own]

    def lead(self, hands: Sequence[HandTarget | None], number: int, stop: int, fastest: float) -> None:
        """Move grippers to targets at constant velocity from outer step `number` to `stop`; None is no new target.

        Other grippers stay at their last target, or follow the scene if they never had one. If a target is wrong,
        InputError is raised and no gripper is changed.
        """
        held = self._held(number)
        given = {index: hand for index, hand in enumerate(hands) if hand is not None}
        starts = {index: self._start(index, index in held, number) for index in {*given, *self._led}}
        led = {}
        for index, hand in given.items():
            name = f"hands[{index}]"
            vertices = hand.held(name, held.get(index), self._own[index], self._vertices)
            led[index] = Led(vertices, hand.place(name) or (NOWHERE if vertices is None else starts[index]))
        for index, target in led.items():
            length = 0.0 if target.vertices is None else dist(target.displacement, starts[index])
            check_speed(f"hands[{index}].displacement", length, (stop - number) * self._outer_step, fastest)
        if any(target.vertices is not held.get(index) for index, target in led.items()):
            self._check_held_once(led, number)
        self._led |= led
        part = _parts(stop - number)
        for index, start in starts.items():
            x, y, z = start
            to_x, to_y, to_z = self._led[index].displacement
            path = self._paths[index, number + 1 : stop + 1]
            np.multiply(part, (to_x - x, to_y - y, to_z - z), out=path)
            path += start

    def fastest(self, number: int, steps: int) -> tuple[int, float, float]:
        """Return index, speed [m/s] and time [s] of the fastest gripper in `steps` outer steps before `number`."""
        first = max(number - steps, 0)
        ways = np.linalg.norm(np.diff(self._paths[:, first : number + 1], axis=1), axis=2)
        ways[[index for index in range(len(ways)) if index not in self._grips]] = 0.0
        if not ways.size:
            return 0, 0.0, 0.0
        index, step = (int(each) for each in np.unravel_index(ways.argmax(), ways.shape))
        return index, float(ways[index, step]) / self._outer_step, (first + step) * self._outer_step

    def is_due(self, number: int) -> bool:
        """Return whether a gripper opens or closes in step `number`."""
        return self._held(number).keys() != self._grips.keys()

    def open_due(self, number: int) -> list[np.ndarray]:
        """Open the grippers that must be open in outer step `number`, and return the vertices that each held."""
        due = sorted(self._grips.keys() - self._held(number).keys())
        self._hands = None if due else self._hands
        return [self._grips.pop(gripper).vertices for gripper in due]

    def close_due(self, number: int, x: np.ndarray) -> list[np.ndarray]:
        """Close the grippers that must hold from outer step `number` on, and return the vertices that each grasps."""
        held = self._held(number)
        taken = []
        for gripper in sorted(held.keys() - self._grips.keys()):
            vertices = np.array(held[gripper])
            self._grips[gripper] = Grip(vertices, x[vertices].copy())
            self._hands = None
            taken.append(vertices)
        return taken

    def hands(self) -> Hands:
        """Return the vertices that are held now, and the paths of their grippers."""
        if self._hands is None:
            grips = self._grips.items()
            self._hands = Hands(
                vertex=np.concatenate([np.empty(0, np.int64), *(grip.vertices for _, grip in grips)]),
                base=np.concatenate([np.empty((0, 3)), *(grip.base for _, grip in grips)]),
                gripper=np.array([number for number, grip in grips for _ in grip.vertices], np.int64),
                path=self._paths,
            )
        return self._hands

    def state(self) -> GripperState:
        """Return a copy of what changes during a simulation."""
        return GripperState(dict(self._grips), dict(self._led))

    def restore(self, state: GripperState) -> None:
        """Set the grippers to a state that `state` returned for the same scene."""
        for index in self._led.keys() - state.led.keys():
            self._follow_scene(index)
        self._grips = dict(state.grips)
        self._hands = None
        self._led = dict(state.led)

    def _follow_scene(self, index: int) -> None:
        self._paths[index] = self._grippers[index].path(self._times)

    def _held(self, number: int) -> dict[int, tuple[int, ...]]:
        """Return the vertices of each gripper that holds in outer step `number`."""
        held = {}
        for index, own in enumerate(self._own):
            led = self._led.get(index)
            vertices = led.vertices if led else own if self._closes[index] <= number < self._opens[index] else None
            if vertices is not None:
                held[index] = vertices
        return held

    def _start(self, index: int, holds: bool, number: int) -> Place:
        """Return the displacement of a gripper since it closed, at outer step `number` [m]; zero if it is open."""
        if not holds:
            return NOWHERE
        led = self._led.get(index)
        return led.displacement if led else tuple(self._paths[index, number].tolist())

    def _check_held_once(self, led: dict[int, Led], number: int) -> None:
        """Check that no vertex is held by two grippers at the same time, now or later."""
        holder: dict[int, int] = {}
        for index, own in enumerate(self._own):
            target = led.get(index) or self._led.get(index)
            later = number < self._opens[index] and self._closes[index] <= self._steps
            for vertex in (target.vertices or ()) if target else own if later else ():
                other = holder.setdefault(vertex, index)
                if other != index:
                    raise InputError(
                        f"hands[{index if index in led else other}].vertices: must be held by one gripper only, but "
                        f"grippers {other} and {index} both hold vertex {vertex}"
                    )
