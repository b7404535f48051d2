"""The environment `tatamu/Fold-v0`: an action is the parameters of a curve, Eq. (9), and the reward -C, Eq. (10)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from gymnasium import spaces

from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import NOMINAL, Disturbances
from tatamu.evaluation.nominal import Nominal
from tatamu.garments import Garment
from tatamu.policies.envs.environment import GarmentEnv, draw_scenario
from tatamu.policies.envs.observation import Observation, View
from tatamu.search import Parameters
from tatamu.simulation.material import Material

NAMES = ("x1", "z1", "x2", "z2", "g1", "g2")
"""Numbers of an action."""


class FoldEnv(GarmentEnv):
    """An environment with one fold per episode. docs/reference/env-fold.md has the spaces and the reward."""

    metadata = {"render_modes": ["rgb_array"], "render_fps": 1}  # noqa: RUF012 (Gymnasium's name and form)

    def __init__(
        self,
        garment: Garment | str | Path = "towel",
        *,
        fold: str = "half",
        size: tuple[float, float] | None = None,
        material: Material | Path | str | None = None,
        spacing: float | None = None,
        disturbances: Disturbances | Path | str | None = None,
        observation: str | tuple[str, ...] = "key_points",
        pixels: int = 96,
        render_mode: str | None = None,
    ) -> None:
        """Make the environment. `HandsEnv` explains the arguments.

        Raises:
            InputError: If an argument is wrong; the message names it.
        """
        which = garment, fold, size, material, spacing, disturbances
        super().__init__(*which, observation, pixels, render_mode, with_hands=False)
        self.action_space = spaces.Box(-1.0, 1.0, (len(NAMES),), np.float32)
        self._scenario = NOMINAL

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        super().reset(seed=seed)
        self._scenario = draw_scenario(self.disturbances, self.np_random)
        self._view = View.of_cloth(self.task.fold.start)
        return self._observer.observe(self._view), {"is_success": False, "world": dict(self._scenario.values)}

    def step(self, action: np.ndarray) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Make one fold, which ends the episode.

        Args:
            action: Parameters whose bounds are scaled to -1 and 1, shape (6,).

        Raises:
            InputError: If the action does not have this shape, or is not finite.
        """
        parameters = self.parameters(action)
        found = Nominal(self.task).simulate(parameters, self._scenario)
        if found.rollout is not None:
            self._warn(found.rollout.info.get("warnings") or [])
            self._view = View.of_cloth(found.rollout.positions[-1])
        info = {
            "is_success": found.score is not None and found.score.succeeds,
            "parameters": parameters,
            "score": {} if found.score is None else found.score.model_dump(),
            "error": found.error or "",
        }
        return self._observer.observe(self._view), -found.objective, True, False, info

    def parameters(self, action: np.ndarray) -> Parameters:
        """Return the parameters of an action. Values below -1 or above 1 are clipped.

        Raises:
            InputError: If the action does not have the shape (6,), or is not finite.
        """
        given = np.asarray(action, dtype=float)
        if given.shape != (len(NAMES),) or not np.isfinite(given).all():
            raise InputError(f"action: must be {len(NAMES)} finite numbers, given {action}")
        parts = 0.5 * (np.clip(given, -1.0, 1.0) + 1.0)
        bounds = [self.task.space.bounds[name] for name in NAMES]
        wanted = [each.low + part * (each.high - each.low) for each, part in zip(bounds, parts, strict=True)]
        return {name: each.nearest(value) for name, each, value in zip(NAMES, bounds, wanted, strict=True)}

    def action(self, parameters: Parameters) -> np.ndarray:
        """Return the action for parameters, shape (6,)."""
        self.task.space.check(parameters)
        pairs = [(self.task.space.bounds[name], parameters[name]) for name in NAMES]
        parts = [0.5 if each.single else (value - each.low) / (each.high - each.low) for each, value in pairs]
        return np.array(2.0 * np.array(parts) - 1.0, dtype=np.float32)
