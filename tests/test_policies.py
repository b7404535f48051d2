"""LeRobot's loader and evaluation, and Stable-Baselines3's training, in an environment that `make lerobot` makes."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

PYTHON = Path(__file__).parent.parent / ".venv-lerobot/bin/python"
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not PYTHON.exists(), reason="LeRobot and Stable-Baselines3 are not tried: `make lerobot`"),
]


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What the script prints of a dataset of 200 episodes, and the dataset's folder."""
    from tatamu.policies.dataset import make_dataset

    root = tmp_path_factory.mktemp("lerobot") / "folds"
    garment = {"width": 0.24, "length": 0.36, "spacing": 0.04}
    make_dataset(
        _specification(episodes=200, garment=garment, formats=["lerobot"], record={"cameras": ["top"], "pixels": 64}),
        root,
    )
    return {**printed("lerobot_scripted.py", str(root)), "root": str(root)}


def printed(script: str, *arguments: str) -> Any:
    """What a script beside this file prints at its end, as JSON."""
    done = subprocess.run(
        [PYTHON, Path(__file__).parent / script, *arguments],
        capture_output=True,
        text=True,
        timeout=3600,
        env={**os.environ, "HF_HUB_OFFLINE": "1", "TOKENIZERS_PARALLELISM": "false"},
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout.splitlines()[-1])


def _specification(**given: Any) -> Any:
    from tatamu.policies.dataset import DatasetSpecification

    return DatasetSpecification.model_validate(given)


def test_lerobots_loader_reads_what_was_written(told: dict[str, Any]) -> None:
    from tatamu.lerobot import LeRobotReader
    from tatamu.policies.dataset.record import read_records

    records = read_records(Path(told["root"]) / "episodes.parquet")
    reader = LeRobotReader(told["root"])
    read = told["read"]
    assert (read["episodes"], read["frames"]) == (200, sum(record.frames for record in records))
    assert read["lengths"] == [record.frames for record in records]
    assert read["held"] == [record.held_share for record in records]
    assert read["pictures"] == [[3, 64, 64]] and read["task"] == records[0].task
    total = np.sum([reader.numbers(k, "action")["action"].astype(float).sum(axis=0) for k in range(200)], axis=0)
    np.testing.assert_allclose(read["actions"], total, rtol=1e-6, atol=1e-6)


def test_lerobots_evaluation_sees_the_demonstration_succeed(told: dict[str, Any]) -> None:
    evaluated = told["evaluated"]
    assert len(evaluated["episodes"]) == 4 and any(evaluated["episodes"])
    assert evaluated["aggregated"]["pc_success"] == 100.0 * np.mean(evaluated["episodes"])


def test_stable_baselines_learns_to_fold() -> None:
    rewards = np.array(printed("trained_policy.py"))
    assert len(rewards) == 400
    drawn, learned = rewards[:100], rewards[-100:]
    assert learned.mean() > drawn.mean() + 2.0 * drawn.std() / 10.0
    assert learned.mean() > np.quantile(drawn, 0.7)
