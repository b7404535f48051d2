"""Several environments at a time, in threads, as compiled code does not hold Python's lock."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array

from tatamu.base.errors import InputError
from tatamu.policies.envs.fold import FoldEnv
from tatamu.policies.envs.hands import HandsEnv
from tatamu.simulation.side_by_side import processors

Env = gymnasium.Env[Any, Any]


class ThreadedVectorEnv(VectorEnv[Any, Any, Any]):
    """Environments that are stepped together. The step after the end of an episode resets it, with reward 0."""

    def __init__(self, make: Callable[[], Env], num_envs: int) -> None:
        """Make the environments.

        Args:
            make: Function that makes one environment.
            num_envs: Number of environments.

        Raises:
            InputError: If `num_envs` is not positive.
        """
        if not num_envs >= 1:
            raise InputError(f"num_envs: must be at least 1, given {num_envs}")
        self.envs = [make() for _ in range(num_envs)]
        self.num_envs = num_envs
        self.metadata = {**self.envs[0].metadata, "autoreset_mode": AutoresetMode.NEXT_STEP}
        self.render_mode = self.envs[0].render_mode
        self.single_observation_space = self.envs[0].observation_space
        self.single_action_space = self.envs[0].action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._ended = [False] * num_envs
        self._pool = self._threads()

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Reset all environments.

        Args:
            seed: Seed of the first environment, from which the others count on, or a list of seeds; None to go on.
            options: Options for every environment.
        """
        seeds = [seed + number for number in range(self.num_envs)] if isinstance(seed, int) else seed
        each = seeds or [None] * self.num_envs
        if len(each) != self.num_envs:
            raise InputError(f"seed: must have one item for each of {self.num_envs} environments, given {len(each)}")
        found = list(self._pool.map(lambda env, own: env.reset(seed=own, options=options), self.envs, each))
        self._ended = [False] * self.num_envs
        return self._batch([observation for observation, _ in found]), self._infos([info for _, info in found])

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Step all environments.

        Args:
            actions: One action for each environment, shape (num_envs, ...).

        Raises:
            InputError: If the number of actions is wrong, or an action is.
        """
        if len(actions) != self.num_envs:
            raise InputError(
                f"actions: must have one item for each of {self.num_envs} environments, given {len(actions)}"
            )
        found = list(self._pool.map(_step_or_reset, self.envs, actions, self._ended))
        observations, rewards, terminated, truncated, infos = zip(*found, strict=True)
        self._ended = [one or other for one, other in zip(terminated, truncated, strict=True)]
        flags = np.array(terminated, dtype=np.bool_), np.array(truncated, dtype=np.bool_)
        return self._batch(observations), np.array(rewards, dtype=np.float64), *flags, self._infos(infos)

    def render(self) -> tuple[Any, ...] | None:
        return None if self.render_mode is None else tuple(env.render() for env in self.envs)

    def close_extras(self, **kwargs: Any) -> None:
        for env in self.envs:
            env.close()
        self._pool.shutdown()

    __copy__ = deepcopy  # otherwise both would step the same environments

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_pool"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._pool = self._threads()

    def _threads(self) -> ThreadPoolExecutor:
        return ThreadPoolExecutor(min(self.num_envs, processors()))

    def _batch(self, observations: Sequence[Any]) -> Any:
        space = self.single_observation_space
        room: Any = create_empty_array(space, self.num_envs)
        return concatenate(space, observations, room)

    def _infos(self, infos: Sequence[dict[str, Any]]) -> dict[str, Any]:
        gathered: dict[str, Any] = {}
        for number, info in enumerate(infos):
            gathered = self._add_info(gathered, info, number)
        return gathered


def _step_or_reset(env: Env, action: Any, ended: bool) -> tuple[Any, float, bool, bool, dict[str, Any]]:
    if ended:
        observation, info = env.reset()
        return observation, 0.0, False, False, info
    observation, reward, terminated, truncated, info = env.step(action)
    return observation, float(reward), terminated, truncated, info


def vector_of_folds(num_envs: int = 1, **arguments: Any) -> ThreadedVectorEnv:
    """Make `FoldEnv` environments with the same arguments."""
    return ThreadedVectorEnv(lambda: FoldEnv(**arguments), num_envs)


def vector_of_hands(num_envs: int = 1, **arguments: Any) -> ThreadedVectorEnv:
    """Make `HandsEnv` environments with the same arguments."""
    return ThreadedVectorEnv(lambda: HandsEnv(**arguments), num_envs)
