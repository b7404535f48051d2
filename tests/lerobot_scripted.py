"""Runs LeRobot's evaluation of a scripted policy in tatamu's environment; prints the outcome as JSON.

python tests/lerobot_scripted.py [DATASET], in an environment with lerobot and lerobot_env_tatamu (`make lerobot`).
With a dataset, LeRobot's own loader reads it, too.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import torch
from lerobot.configs import PreTrainedConfig
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.envs.factory import make_env, make_env_config
from lerobot.policies import PreTrainedPolicy
from lerobot.processor import PolicyProcessorPipeline
from lerobot.scripts.lerobot_eval import eval_policy
from lerobot.utils.import_utils import register_third_party_plugins

from tatamu.folding.parameters import arched_curve
from tatamu.policies.envs import HandsEnv

TOWEL: dict[str, Any] = {"width": 0.24, "length": 0.36, "spacing": 0.04, "fps": 10, "pixels": 64}


@PreTrainedConfig.register_subclass("scripted")
@dataclass
class ScriptedConfig(PreTrainedConfig):
    """A policy without parameters."""

    normalization_mapping: dict[str, Any] = field(default_factory=dict)
    observation_delta_indices = None
    action_delta_indices = None
    reward_delta_indices = None

    def get_optimizer_preset(self) -> Any:
        return None

    def get_scheduler_preset(self) -> Any:
        return None

    def validate_features(self) -> None:
        pass


class Scripted(PreTrainedPolicy):
    """Repeats the actions of a demonstration."""

    config_class = ScriptedConfig
    name = "scripted"

    def __init__(self, config: ScriptedConfig, actions: np.ndarray) -> None:
        super().__init__(config)
        self._actions = torch.from_numpy(actions)
        self.reset()

    def reset(self) -> None:
        self._step = 0

    def select_action(self, batch: dict[str, Any], **_: Any) -> torch.Tensor:
        count = len(batch["observation.state"])
        assert batch["observation.images.top"].shape == (count, 3, 64, 64)
        assert batch["observation.environment_state"].shape == (count, 12)
        assert batch["task"] == ["Fold the towel: in half across the length."] * count
        action = self._actions[min(self._step, len(self._actions) - 1)]
        self._step += 1
        return action.expand(count, -1)

    def predict_action_chunk(self, batch: dict[str, Any], **_: Any) -> torch.Tensor:
        raise NotImplementedError

    def forward(self, batch: dict[str, Any]) -> Any:
        raise NotImplementedError

    def get_optim_params(self) -> Any:
        return []


def evaluate() -> dict[str, Any]:
    """Evaluate the demonstration in four disturbed worlds, two at a time."""
    register_third_party_plugins()
    envs = make_env(make_env_config("tatamu", **TOWEL), n_envs=2)["tatamu"][0]
    hands = HandsEnv("towel", size=(TOWEL["width"], TOWEL["length"]), spacing=TOWEL["spacing"])
    actions = np.stack(list(hands.follow(arched_curve(hands.task.fold))))
    nothing = PolicyProcessorPipeline(steps=[])
    policy = Scripted(ScriptedConfig(device="cpu"), actions)
    outcome = eval_policy(envs, policy, nothing, nothing, nothing, lambda action: action, 4, start_seed=0)
    envs.close()
    return {"aggregated": outcome["aggregated"], "episodes": [each["success"] for each in outcome["per_episode"]]}


def read(root: str) -> dict[str, Any]:
    """Read a dataset by LeRobot's loader."""
    dataset = LeRobotDataset("tatamu/folds", root=root, video_backend="pyav")
    frames = [dataset[number] for number in range(len(dataset))]
    return {
        "episodes": dataset.num_episodes,
        "frames": len(frames),
        "actions": np.stack([frame["action"].numpy() for frame in frames]).astype(float).sum(axis=0).tolist(),
        "pictures": [list(frame["observation.images.top"].shape) for frame in frames[:1]],
        "lengths": [dataset.meta.episodes[number]["length"] for number in range(dataset.num_episodes)],
        "held": [dataset.meta.episodes[number]["held_share"] for number in range(dataset.num_episodes)],
        "task": frames[0]["task"],
    }


if __name__ == "__main__":
    print(json.dumps({"evaluated": evaluate(), "read": read(sys.argv[1]) if len(sys.argv) > 1 else None}))
