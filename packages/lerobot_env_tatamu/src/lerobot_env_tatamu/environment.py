"""`tatamu/Hands-v0` with the observations, attributes and infos that `lerobot-eval` expects."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from tatamu.policies.envs.hands import HandsEnv

Observation = dict[str, Any]


class LeRobotHands(gymnasium.Env[Observation, np.ndarray]):
    """Hands that fold a garment step by step.

    Attributes:
        task: Garment and fold.
        task_description: The task in words, as datasets of tatamu have it.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 (Gymnasium's name and form)

    def __init__(
        self, cameras: tuple[str, ...] = ("top", "front"), render_mode: str | None = "rgb_array", **arguments: Any
    ) -> None:
        """Make the environment.

        Args:
            cameras: Cameras whose pictures are shown.
            render_mode: "rgb_array" to get pictures from `render`.
            **arguments: Those of `tatamu.policies.envs.HandsEnv`, but the observation.
        """
        self._cameras = tuple(cameras)
        names = ("key_points", "hands", *self._cameras)
        self._env = HandsEnv(observation=names, render_mode=render_mode, **arguments)
        task = self._env.task
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": self._env.rate}
        self.task = f"{task.garment.name}, {task.plan.name}"
        self.task_description = f"Fold the {task.garment.name}: {task.title}."
        self._max_episode_steps = self._env.steps
        self.action_space = self._env.action_space
        shown: Any = self._env.observation_space
        points = int(np.prod(shown["key_points"].shape))
        self.observation_space = spaces.Dict(
            {
                "agent_pos": shown["hands"],
                "environment_state": spaces.Box(-1e3, 1e3, (points,), np.float32),
                "pixels": spaces.Dict({name: shown[name] for name in self._cameras}),
            }
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Lay the garment down, in a world that is drawn anew.

        Args:
            seed: Random seed of this and the following worlds; None to draw the next one.
            options: LeRobot's own are ignored.
        """
        super().reset(seed=seed)
        observation, info = self._env.reset(seed=seed)
        return self._as_lerobot(observation), self._info(info)

    def step(self, action: np.ndarray) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Lead the hands for one step.

        Args:
            action: From -1 to 1, shape (4 hands,).
        """
        observation, reward, terminated, truncated, info = self._env.step(action)
        return self._as_lerobot(observation), reward, terminated, truncated, self._info(info)

    def render(self) -> np.ndarray | None:
        """Return what the camera `front` sees: RGB, uint8, shape (h, w, 3)."""
        return self._env.render()

    def _as_lerobot(self, observation: Any) -> Observation:
        return {
            "agent_pos": observation["hands"],
            "environment_state": observation["key_points"].ravel(),
            "pixels": {name: observation[name] for name in self._cameras},
        }

    def _info(self, info: dict[str, Any]) -> dict[str, Any]:
        """Return plain numbers alone, which vector environments can batch."""
        return {
            "is_success": bool(info["is_success"]),
            "mean_vertex_distance": float(info["mean_vertex_distance"]),
            "task": self.task,
        }
