"""Plays an episode with LeRobot's own replay on a robot that records; prints what it was sent as JSON.

python tests/robots/lerobot_replayed.py DATASET, in an environment with lerobot (`make lerobot`).
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from typing import Any

from lerobot.robots import RobotConfig
from lerobot.scripts import lerobot_replay

SENT: list[dict[str, float]] = []
WAITED: list[float] = []


@RobotConfig.register_subclass("recorder")
@dataclass
class RecorderConfig(RobotConfig):
    """A robot without options."""


class Recorder:
    """A robot that keeps what it is sent."""

    def connect(self) -> None:
        """Do nothing."""

    def disconnect(self) -> None:
        """Do nothing."""

    def get_observation(self) -> dict[str, Any]:
        """Return nothing that replay needs."""
        return {}

    def send_action(self, action: dict[str, Any]) -> dict[str, Any]:
        """Keep an action."""
        SENT.append({name: float(value) for name, value in action.items()})
        return action


def main() -> None:
    """Replay the episode."""
    lerobot_replay.make_robot_from_config = lambda config: Recorder()
    lerobot_replay.precise_sleep = WAITED.append
    dataset = lerobot_replay.DatasetReplayConfig(repo_id="local/plan", episode=0, root=sys.argv[1])
    lerobot_replay.replay(lerobot_replay.ReplayConfig(robot=RecorderConfig(), dataset=dataset, play_sounds=False))
    print(json.dumps({"sent": SENT, "frame": max(WAITED)}))


main()
