"""A plan as a LeRobotDataset: the robot's own keys and units, the motion of the plan, grippers that open and close."""

from __future__ import annotations

import json
import os
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tatamu.lerobot import LeRobotReader
from tatamu.robots import RobotPlan
from tatamu.robots.arm import LeRobotNames
from tatamu.robots.episode import ACTION, FPS, STATE, add_plan, episode_writer, state
from tatamu.robots.model import state_names
from tests.commands import refused
from tests.robots.folds import folder

LEROBOT = Path(os.environ.get("TATAMU_LEROBOT", Path(__file__).parents[2] / ".venv-lerobot/bin/python"))
"""The Python that has LeRobot."""


@pytest.fixture
def plan(panda_plan: RobotPlan) -> RobotPlan:
    return panda_plan


@pytest.fixture(scope="module")
def dataset(panda_plan: RobotPlan, tmp_path_factory: pytest.TempPathFactory) -> LeRobotReader:
    root = tmp_path_factory.mktemp("data") / "episode"
    with episode_writer(panda_plan.task.robot, root) as writer:
        add_plan(writer, panda_plan)
    return LeRobotReader(root)


def test_it_is_one_episode_of_the_plan_at_thirty_frames_a_second(plan: RobotPlan, dataset: LeRobotReader) -> None:
    assert (dataset.fps, len(dataset.episodes), dataset.info["robot_type"]) == (30, 1, "panda-pair")
    names = dataset.info["features"][ACTION]["names"]
    assert names == [*state_names(plan.task.robot)]
    assert names[:8] == [*(f"left_joint{number}.pos" for number in range(1, 8)), "left_gripper.pos"]
    found = dataset.numbers(0, STATE, ACTION)
    assert len(found[STATE]) == np.ceil(plan.motion.times[-1] * FPS) + 1
    assert np.array_equal(found[ACTION][:-1], found[STATE][1:])
    columns = [plan.task.robot.columns[name] for arm in plan.task.robot.arms for name in arm.joints]
    wanted = plan.motion.angles[:, columns]
    at = np.arange(len(found[STATE])) / FPS
    angles = np.delete(found[STATE], [7, 15], axis=1)
    for number in range(len(columns)):
        assert np.allclose(angles[:, number], np.interp(at, plan.motion.times, wanted[:, number]), atol=1e-5)


def test_its_grippers_close_and_open_in_the_time_of_the_plan(plan: RobotPlan, dataset: LeRobotReader) -> None:
    width, at = dataset.numbers(0, STATE)[STATE][:, 7], np.arange(dataset.episodes[0]["length"]) / FPS
    opening = plan.task.robot.larm.jaw.opening
    close, release = (next(event.time for event in plan.events if event.event == name) for name in ("close", "open"))
    assert np.allclose(width[at < close], opening)
    assert np.allclose(width[(at > close + 1.0) & (at < release)], 0.0, atol=1e-6)
    assert np.allclose(width[at > release + 1.5], opening)
    assert 0.0 < width[int((close + 0.5) * FPS)] < opening


def test_values_are_in_the_robots_own_keys_units_and_directions(plan: RobotPlan) -> None:
    robot, times = plan.task.robot, np.array([0.0, 5.0])
    own = LeRobotNames(
        joints=[f"left_joint_{number}.pos" for number in range(1, 8)],
        unit="deg",
        zero=[0.1] * 7,
        sign=[-1, 1, 1, 1, 1, 1, 1],
        gripper="left_hand.pos",
        open=100.0,
        closed=2.0,
    )
    named = replace(robot, larm=replace(robot.larm, lerobot=own), lerobot_type="bi_arm")
    plain, turned = state(plan, times), state(replace(plan, task=replace(plan.task, robot=named)), times)
    assert state_names(named)[:1] == ("left_joint_1.pos",) and state_names(named)[7] == "left_hand.pos"
    assert turned[:, 0] == pytest.approx(-np.degrees(plain[:, 0] - 0.1))
    assert turned[:, 1] == pytest.approx(np.degrees(plain[:, 1] - 0.1))
    assert turned[0, 7] == 100.0 and np.array_equal(turned[:, 8:], plain[:, 8:])


def test_a_dataset_that_is_there_is_refused_before_any_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    learned = folder(tmp_path / "fold")
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "mine.txt").write_text("mine")
    monkeypatch.setattr("tatamu.robots.plan_fold", lambda *_: pytest.fail("planned"))
    said = refused("plan", str(learned), "--out", str(tmp_path / "plan"), "--lerobot", str(tmp_path / "data"))
    assert "must be a new folder" in said
    assert not (tmp_path / "plan").exists()


@pytest.mark.slow
@pytest.mark.skipif(not LEROBOT.exists(), reason="LeRobot is not tried: `make lerobot` installs it")
def test_lerobots_own_replay_sends_every_row_to_the_robot(dataset: LeRobotReader) -> None:
    script = Path(__file__).parent / "lerobot_replayed.py"
    done = subprocess.run(
        [LEROBOT, script, dataset.root],
        capture_output=True,
        text=True,
        timeout=600,
        env={**os.environ, "HF_HUB_OFFLINE": "1", "TOKENIZERS_PARALLELISM": "false"},
    )
    assert done.returncode == 0, done.stderr[-2000:]
    told = json.loads(done.stdout.splitlines()[-1])
    actions = dataset.numbers(0, ACTION)[ACTION]
    assert 0.9 / FPS < told["frame"] <= 1 / FPS
    assert [[*row] for row in told["sent"]] == [dataset.info["features"][ACTION]["names"]] * len(actions)
    assert np.array_equal([list(row.values()) for row in told["sent"]], actions)
