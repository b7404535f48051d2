"""Trains a policy of Stable-Baselines3 in `tatamu/Fold-v0` for 400 folds; prints the reward of each as JSON.

python tests/trained_policy.py, in an environment with stable-baselines3 (`make lerobot`).
"""

from __future__ import annotations

import json

import gymnasium
from stable_baselines3 import SAC
from stable_baselines3.common.monitor import Monitor

FOLDS, DRAWN = 400, 100
"""Folds in all, and those at the start whose actions are drawn at random."""
ENTROPY = 1e-3
"""Weight of the entropy: rewards differ by hundredths, so the usual weight of 1 would leave nothing but chance."""


def train() -> list[float]:
    """Return the reward of each fold."""
    env = Monitor(gymnasium.make("tatamu.envs:tatamu/Fold-v0", size=(0.2, 0.3), spacing=0.04, observation="key_points"))
    learning = {"learning_starts": DRAWN, "learning_rate": 1e-3, "batch_size": 64, "gamma": 0.0, "ent_coef": ENTROPY}
    model = SAC("MlpPolicy", env, seed=0, device="cpu", **learning)
    model.learn(FOLDS)
    return [float(reward) for reward in env.get_episode_rewards()]


if __name__ == "__main__":
    print(json.dumps(train()))
