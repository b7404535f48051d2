"""The environment `tatamu/Hands-v0`: a policy moves hands step by step, and opens and closes their jaws."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from gymnasium import spaces

from tatamu.base.errors import InputError, SimulationError
from tatamu.evaluation.disturbances import Disturbances, Scenario, disturbed_scene
from tatamu.folding.fold import Fold
from tatamu.folding.manipulation import HANDS
from tatamu.folding.parameters import arched_curve
from tatamu.folding.score import Limits, Score, score, vertex_distances
from tatamu.folding.task import Task
from tatamu.garments import Garment
from tatamu.policies.envs.environment import GarmentEnv, draw_scenario
from tatamu.policies.envs.motion import follow, scene_of_led
from tatamu.policies.envs.observation import Observation, View
from tatamu.search import Parameters
from tatamu.simulation.material import Material
from tatamu.simulation.native import HandTarget, Simulation
from tatamu.simulation.scene import Gripper, Scene

RATE = 10
"""Default number of steps per second [1/s]."""


@dataclass(frozen=True)
class HandsOptions:
    """Limits of the hands, and conditions of success."""

    speed: float = 0.6
    """Largest speed along each axis [m/s], that of planned folds (De Gusseme and wyffels 2022)."""
    reach: float = 0.012
    """Distance within which closing jaws grasp vertices [m]; at least 0.6 times the spacing."""
    beside: float = 0.25
    """Largest distance beside the flat cloth [m]."""
    highest: float = 0.6
    """Largest height [m]."""
    calm: float = 0.02
    """Mean speed above which the cloth does not rest [m/s]."""
    torn: float = -1.0
    """Reward of a step in which the cloth tears or flies away, which ends the episode."""


class Jaw:
    """A hand during an episode.

    Attributes:
        place: Assumed position [m], shape (3,).
        way: Length of its path so far [m].
        held: Vertices that it holds.
    """

    def __init__(self, place: np.ndarray, error: np.ndarray, lowest: float) -> None:
        """Start open.

        Args:
            place: Assumed position [m], shape (3,).
            error: Error of it [m], shape (3,).
            lowest: Height at which the hand touches the table [m].
        """
        self.place = np.array(place)
        self.way = 0.0
        self.held: tuple[int, ...] = ()
        self._closed_at = self.place
        self._error = error
        self._lowest = lowest

    @property
    def actual(self) -> np.ndarray:
        """Actual position [m], shape (3,). The table stops the hand."""
        there = self.place + self._error
        there[2] = max(there[2], self._lowest)
        return np.asarray(there)

    def lead(self, place: np.ndarray, close: bool, near: tuple[int, ...]) -> HandTarget | None:
        """Open or close, then move, and return the target of the hand's gripper; None if it holds nothing throughout.

        Args:
            place: Next assumed position [m], shape (3,).
            close: Whether to close.
            near: Vertices that closing jaws grasp.
        """
        before = self.actual
        self.way += float(np.linalg.norm(place - self.place))
        self.place = place
        if self.held and not close:
            self.held = ()
            return HandTarget(closed=False)
        if self.held:
            return HandTarget(self.actual - self._closed_at)
        if not close or not near:
            return None
        self.held = near
        self._closed_at = before
        return HandTarget(self.actual - before, True, near)


class HandsEnv(GarmentEnv):
    """An environment in which hands fold step by step. docs/reference/env-hands.md has the spaces and the rewards."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": RATE}  # noqa: RUF012 (Gymnasium's name and form)

    def __init__(
        self,
        garment: Task | Garment | str | Path = "towel",
        *,
        fold: str = "half",
        size: tuple[float, float] | None = None,
        material: Material | Path | str | None = None,
        spacing: float | None = None,
        disturbances: Disturbances | Path | str | None = None,
        observation: str | tuple[str, ...] = ("key_points", "hands"),
        pixels: int = 96,
        reward: Literal["dense", "sparse"] = "dense",
        seconds: float = 6.0,
        rate: int = RATE,
        options: HandsOptions | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Make the environment.

        Args:
            garment: A garment, its name or file; or a task, with its fold, size, material and spacing.
            fold: Name or file of a plan, whose first fold is made.
            size: Width and length of the garment [m]; None for the garment's own.
            material: Material, its preset or file; None for the garment's own.
            spacing: Distance between vertices of the mesh [m]; None for the garment's own.
            disturbances: Disturbances that are drawn for each episode, "default" or a file; None for none.
            observation: Name of an observation, or several names.
            pixels: Height and width of masks, depths and pictures.
            reward: "dense" to reward progress and success, "sparse" to reward only success.
            seconds: Length of an episode [s].
            rate: Steps per second [1/s].
            options: Limits of the hands, and conditions of success; None for the defaults.
            render_mode: "rgb_array" to get pictures from `render`; None for no pictures.

        Raises:
            InputError: If an argument is wrong; the message names it.
        """
        if reward not in ("dense", "sparse"):
            raise InputError(f"reward: must be dense or sparse, given {reward!r}")
        if not (isinstance(rate, int) and 1 <= rate <= 60):
            raise InputError(f"rate: must be a whole number from 1 to 60, given {rate}")
        if not 1.0 / rate <= seconds <= 600.0:
            raise InputError(f"seconds: must be from {1.0 / rate:g} to 600, given {seconds}")
        which = garment, fold, size, material, spacing, disturbances
        super().__init__(*which, observation, pixels, render_mode, with_hands=True)
        self.reward = reward
        self.rate = rate
        self.metadata = {**self.metadata, "render_fps": rate}
        self.steps = round(seconds * rate)
        self.options = options or HandsOptions()
        start = self.task.fold.start
        count = self.task.fold.hands
        self.action_space = spaces.Box(-1.0, 1.0, (4 * count,), np.float32)
        self.largest = self.options.speed / rate  # motion of a hand in a step, along each axis [m]
        self._grasps = tuple(int(side[0]) for side in (self.task.fold.left, self.task.fold.right)[:count])
        self.start = start[list(self._grasps)]  # positions of the hands at the start of an episode [m]
        self.start.setflags(write=False)
        margin = np.array([self.options.beside, self.options.beside, 0.0])
        self._low = start.min(axis=0) - margin
        self._high = np.array([*(start.max(axis=0) + margin)[:2], self.options.highest])
        self._untouched = float(vertex_distances(self.task.fold.target, start).mean())

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Lay the garment down, with open hands at the corners that the fold moves.

        Args:
            seed: Seed of the disturbances from here on; None to continue the sequence.
            options: "world", the values of disturbances by name, instead of random ones.
        """
        super().reset(seed=seed)
        given = (options or {}).get("world")
        scenario = draw_scenario(self.disturbances, self.np_random) if given is None else Scenario(given)
        fold = self.task.fold
        never = 1e6  # [s], after every episode
        idle = [
            Gripper(hand=hand, vertices=[vertex], closes=never, times=[0.0], displacements=np.zeros((1, 3)))
            for hand, vertex in zip(HANDS, self._grasps, strict=False)
        ]
        touched = disturbed_scene(fold, self.task.manipulation(arched_curve(fold)), scenario)
        scene = touched.model_copy(update={"grippers": []})
        self._simulation = Simulation(scene.model_copy(update={"grippers": idle, "duration": self.steps / self.rate}))
        self._warn(self._simulation.warnings())
        errors = _hand_errors(fold, scenario)
        lowest = 0.5 * scene.material.thickness
        self._jaws = [Jaw(fold.start[v], error, lowest) for v, error in zip(self._grasps, errors, strict=True)]
        self._done = 0
        self._led: list[list[HandTarget | None]] = []
        self._scene = scene
        self._view = self._look()
        self._distance = self._measure()
        return self._observer.observe(self._view), {**self._info(False, None, ""), "world": dict(scenario.values)}

    def step(self, action: np.ndarray) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Move the hands for one step.

        Args:
            action: For each hand its motion along x, y and z, as a fraction of the largest one, and a number above 0 to
                close its jaws; from -1 to 1, shape (4 * hands,).

        Raises:
            InputError: If the action does not have this shape, or is not finite.
        """
        given = np.asarray(action, dtype=float)
        if given.shape != self.action_space.shape or not np.isfinite(given).all():
            raise InputError(f"action: must be {4 * len(self._jaws)} finite numbers, given {action}")
        moves = np.clip(given, -1.0, 1.0).reshape(-1, 4)
        return self.lead(self.hands + moves[:, :3] * self.largest, moves[:, 3] > 0.0)

    @property
    def hands(self) -> np.ndarray:
        """Assumed positions of the hands, without their errors [m], shape (hands, 3)."""
        return np.array([jaw.place for jaw in self._jaws])

    def lead(self, places: np.ndarray, closed: np.ndarray) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Move the hands in one step, however fast.

        Args:
            places: Assumed positions of the hands at the end of the step [m], shape (hands, 3).
            closed: Whether the jaws are closed from its start, shape (hands,).
        """
        self._done += 1
        targets = [
            jaw.lead(np.clip(place, self._low, self._high), bool(close), self._near(jaw))
            for jaw, place, close in zip(self._jaws, places, closed, strict=True)
        ]
        self._led.append(targets)
        try:
            self._simulation.advance(1.0 / self.rate, targets)
        except SimulationError as error:
            info = self._info(False, None, str(error))
            return self._observer.observe(self._view), self.options.torn, True, False, info
        self._view = self._look()
        before, self._distance = self._distance, self._measure()
        success = self._succeeds()
        over = success or self._done >= self.steps
        progress = (before - self._distance) / self._untouched if self.reward == "dense" else 0.0
        info = self._info(success, self._score() if over else None, "")
        return self._observer.observe(self._view), progress + float(success), success, over and not success, info

    def follow(self, parameters: Parameters) -> Iterator[np.ndarray]:
        """Yield actions that demonstrate the fold of these parameters: to the grasps, then along the curve."""
        return follow(self.task.manipulation(parameters), self.start, self.largest, self.rate, self.steps)

    def scene(self) -> Scene:
        """Return the episode so far as a scene, which ends `SETTLE` seconds after the last step."""
        return scene_of_led(self._scene, self._led, self.rate)

    def outcome(self) -> tuple[np.ndarray, Score]:
        """Return the present shape of the cloth [m], shape (n, 3), and its score."""
        return self._view.positions, self._score()

    def _near(self, jaw: Jaw) -> tuple[int, ...]:
        """Return the vertices within reach that no other jaw holds."""
        reach = max(self.options.reach, 0.6 * self.task.garment.spacing)
        near = np.flatnonzero(np.linalg.norm(self._simulation.positions - jaw.actual, axis=1) <= reach)
        held = {vertex for other in self._jaws for vertex in other.held}
        return tuple(vertex for vertex in near.tolist() if vertex not in held)

    def _look(self) -> View:
        return View(
            positions=self._simulation.positions.copy(),
            velocities=self._simulation.velocities.copy(),
            hands=self.hands,
            seen=np.array([jaw.actual for jaw in self._jaws]),
            closed=np.array([float(bool(jaw.held)) for jaw in self._jaws]),
        )

    def _measure(self) -> float:
        return float(vertex_distances(self.task.fold.target, self._view.positions).mean())

    def _succeeds(self) -> bool:
        """Return whether the score is good, the hands are open, and the cloth rests."""
        if self._view.closed.any() or np.linalg.norm(self._view.velocities, axis=1).mean() > self.options.calm:
            return False
        near = self._distance <= Limits().mean_vertex_distance  # tested first, because the view from above takes longer
        return near and self._score().succeeds

    def _score(self) -> Score:
        length = sum(jaw.way for jaw in self._jaws) / len(self._jaws)
        return score(self.task.fold, length, self._view.positions)

    def _info(self, success: bool, score: Score | None, error: str) -> dict[str, Any]:
        return {
            "is_success": success,
            "mean_vertex_distance": self._distance,
            "score": {} if score is None else score.model_dump(),
            "error": error,
        }


def _hand_errors(fold: Fold, scenario: Scenario) -> np.ndarray:
    """Return the error of each hand's assumed position in a scenario [m], shape (hands, 3)."""
    place = np.array([scenario["cloth.place.along"], scenario["cloth.place.across"], scenario["table.height"]])
    shared = scenario.vector("hands.offset") - place
    apart = 0.5 * scenario.vector("hands.difference")
    errors = [shared] if fold.hands == 1 else [shared + apart, shared - apart]
    axes = np.array([[*fold.normal, 0.0], [*fold.crease.along, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(np.array(errors) @ axes)
