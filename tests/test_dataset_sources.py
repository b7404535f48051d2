"""Datasets of every source, on robots and in a second simulator, end to end; on a cluster the bytes are the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tatamu import Result
from tatamu.lerobot import LeRobotReader
from tatamu.policies.dataset import DatasetFolder, DatasetSpecification, make_dataset, replay
from tatamu.policies.dataset.record import read_records
from tatamu.sweep import SweepFolder, SweepTask, run_sweep
from tests.small_studies import bytes_in, learn_plain
from tests.small_studies import towel as coarse_towel

pytestmark = pytest.mark.slow
SMALL: dict[str, Any] = {
    "episodes": 2,
    "garment": {"width": 0.2, "length": {"low": 0.28, "high": 0.32}, "spacing": 0.04},
    "record": {"cameras": []},
}


def make(out: Path, **changes: Any) -> DatasetFolder:
    return make_dataset(DatasetSpecification.model_validate({**SMALL, **changes}), out)


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A learned fold of a small towel."""
    folder = tmp_path_factory.mktemp("learned")
    learn_plain(coarse_towel(), folder, trials=2, baselines=False)
    return folder


def test_a_learned_fold_is_recorded_in_scenarios_of_its_neighbourhood(learned: Path, tmp_path: Path) -> None:
    fold = {"source": "learned", "runs": [str(learned)]}
    made = make(tmp_path / "folds", garment=None, fold=fold, per_fold=2, outcome={"worlds": 3})
    first, second = read_records(made.table)
    assert first.source == second.source == str(learned) and first.parameters == second.parameters
    assert first.parameters == Result.load(learned).best.parameters and first.world != second.world
    assert first.held_from == second.held_from == "worlds" and first.held_draws == 3
    assert not replay(made.path, 1).differs
    spread = make(tmp_path / "spread", garment=None, fold={**fold, "spread": 0.1})
    assert all(each.parameters != first.parameters for each in read_records(spread.table))


def test_a_sweep_is_recorded(learned: Path, tmp_path: Path) -> None:
    def learn(options: dict[str, Any], path: Path, progress: Any) -> None:
        learn_plain(coarse_towel(), path, trials=2, baselines=False)

    run_sweep([SweepTask("one", {"garment": "towel"})], SweepFolder(tmp_path / "sweep"), learn, trials=2)
    made = make(tmp_path / "folds", garment=None, fold={"source": "sweep", "sweep": str(tmp_path / "sweep")})
    assert {each.source for each in read_records(made.table)} == {str(tmp_path / "sweep/one")}
    assert not replay(made.path, 0).differs


def test_scenarios_and_a_second_simulator_judge_each_fold(tmp_path: Path) -> None:
    made = make(tmp_path / "folds", episodes=1, outcome={"worlds": 4, "simulator": "mujoco"})
    (record,) = read_records(made.table)
    assert (record.held_from, record.held_draws, record.second_simulator) == ("worlds", 4, "mujoco")
    assert record.second_success is not None
    (row,) = LeRobotReader(made.path).episodes
    assert row["second_success"] == record.second_success and row["held_share"] == record.held_share


def test_arms_fold_in_joint_space(tmp_path: Path) -> None:
    from tatamu import robots
    from tatamu.robots.model import state_names

    robot = "fr3-pair"
    made = make(tmp_path / "folds", robot={"name": robot}, disturbances="none")
    reader = LeRobotReader(made.path)
    model = robots.load(robot)
    assert reader.info["robot_type"] == robot
    assert reader.info["features"]["action"]["names"] == list(state_names(model))
    speed, _ = model.planned()
    for record in read_records(made.table):
        found = reader.numbers(record.episode, "observation.state", "action")
        np.testing.assert_array_equal(found["observation.state"][1:], found["action"][:-1])
        steps = np.abs(np.diff(found["action"], axis=0)) * reader.fps
        assert np.delete(steps, [len(model.arms[0].joints), -1], axis=1).max() <= 1.001 * speed.max()
        assert record.success and not replay(made.path, record.episode).differs


def test_workers_of_a_cluster_make_the_same_bytes(tmp_path: Path) -> None:
    from tatamu.cluster import executor_at

    record = {"cameras": ["top"], "pixels": 64}
    alone = make(tmp_path / "alone", record=record)
    with executor_at("local:2") as workers:
        wanted = DatasetSpecification.model_validate({**SMALL, "record": record})
        spread = make_dataset(wanted, tmp_path / "spread", executor=workers)
    assert bytes_in(alone.path) == bytes_in(spread.path)
