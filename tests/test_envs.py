"""Environments of Gymnasium: their contract, their seeds, what they show, and that a policy can fold."""

from __future__ import annotations

import copy
import pickle
import warnings
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv

import tatamu.policies.envs as envs
from tatamu import InputError, Nominal, make_task, simulate
from tatamu.folding.parameters import arched_curve
from tatamu.policies.envs.cameras import CAMERAS, Studio
from tatamu.policies.envs.motion import follow

SMALL: dict[str, Any] = {"size": (0.2, 0.3), "spacing": 0.04}
"""A towel of a few dozen vertices."""
EVERYTHING = ("vertices", "velocities", "key_points", "mask", "depth", *CAMERAS)
KINDS = [envs.FOLD, envs.HANDS]


def make(kind: str, **arguments: Any) -> Any:
    return gymnasium.make(f"tatamu.envs:{kind}", **{**SMALL, **arguments}).unwrapped


def folded(env: Any) -> tuple[Any, list[float], bool, dict[str, Any]]:
    """Let the hands fold: the last observation, all rewards, whether it ended in a fold, and the last information."""
    rewards = []
    for action in env.follow(arched_curve(env.task.fold)):
        observation, reward, terminated, truncated, info = env.step(action)
        rewards.append(reward)
        if terminated or truncated:
            break
    return observation, rewards, terminated, info


def played(env: Any, seed: int, steps: int = 12) -> bytes:
    """Everything that an environment answers to actions drawn from a seed."""
    env.action_space.seed(seed)
    answers = [env.reset(seed=seed)]
    for _ in range(steps):
        answers.append(env.step(env.action_space.sample()))
        if answers[-1][2] or answers[-1][3]:
            answers.append(env.reset())
    return pickle.dumps(answers)


@pytest.mark.parametrize("kind", KINDS)
def test_gymnasiums_own_checker_is_content(kind: str) -> None:
    check_env(make(kind, disturbances="default", observation=EVERYTHING, render_mode="rgb_array"))
    check_env(make(kind, observation="key_points"))


@pytest.mark.parametrize("kind", KINDS)
def test_one_seed_gives_the_same_bytes_and_another_another_scenario(kind: str) -> None:
    arguments: dict[str, Any] = {"disturbances": "default", "observation": EVERYTHING}
    first = played(make(kind, **arguments), seed=1)
    env = make(kind, **arguments)
    assert played(env, seed=1) == first
    assert played(env, seed=2) != first
    assert played(env, seed=1) == first
    assert env.reset(seed=3)[1]["world"] != env.reset(seed=4)[1]["world"]


def test_the_reward_of_a_fold_is_the_objective_that_learning_minimises() -> None:
    env = make(envs.FOLD)
    env.reset(seed=0)
    parameters = arched_curve(env.task.fold)
    action = env.action(parameters)
    assert env.parameters(action) == pytest.approx(parameters, abs=1e-6)
    _, reward, terminated, truncated, info = env.step(action)
    found = Nominal(env.task)(env.parameters(action))
    assert reward == -found.objective and terminated and not truncated
    assert found.score is not None and info["score"] == found.score.model_dump()
    assert info["is_success"] == found.score.succeeds


def test_actions_span_the_search_space() -> None:
    env = make(envs.FOLD)
    bounds = env.task.space.bounds
    low, high = env.parameters(-np.ones(6)), env.parameters(np.ones(6))
    assert low == {name: bounds[name].low for name in low} and high == {name: bounds[name].high for name in high}
    env.task.space.check(env.parameters(np.full(6, 0.3)))


@pytest.mark.parametrize("disturbances", [None, "default"])
def test_hands_that_follow_a_manipulation_fold_the_towel(disturbances: str | None) -> None:
    env = make(envs.HANDS, disturbances=disturbances, observation=("hands", "key_points"))
    env.reset(seed=1)
    observation, rewards, terminated, info = folded(env)
    assert terminated and info["is_success"] and info["score"]["mean_vertex_distance"] < 0.0125
    progress = 1.0 - info["mean_vertex_distance"] / env._untouched
    assert sum(rewards) == pytest.approx(1.0 + progress, abs=1e-6)
    assert not observation["hands"].reshape(2, 4)[:, 3].any()


def test_sparse_rewards_are_for_success_alone() -> None:
    env = make(envs.HANDS, reward="sparse")
    env.reset(seed=1)
    _, rewards, *_ = folded(env)
    assert rewards[-1] == 1.0 and not any(rewards[:-1])


def test_hands_that_do_nothing_end_with_the_episode() -> None:
    env = make(envs.HANDS, seconds=0.5)
    env.reset(seed=0)
    answers = [env.step(np.zeros(8)) for _ in range(5)]
    assert [answer[3] for answer in answers] == [False] * 4 + [True]
    assert not any(answer[2] for answer in answers) and not answers[-1][4]["is_success"]
    assert abs(sum(answer[1] for answer in answers)) < 1e-3


def test_hands_stay_over_the_table_and_take_nothing_where_there_is_nothing() -> None:
    env = make(envs.HANDS, observation="hands")
    env.reset(seed=0)
    away = np.array([-1.0, 0.0, -1.0, -1.0] * 2)
    for _ in range(10):
        observation, *_ = env.step(away)
    places = observation.reshape(2, 4)
    assert places[:, 0] == pytest.approx(env.task.fold.start[:, 0].min() - env.options.beside)
    observation, *_ = env.step(np.array([0.0, 0.0, 0.0, 1.0] * 2))
    assert not observation.reshape(2, 4)[:, 3].any()
    assert env._distance == pytest.approx(env._untouched, abs=1e-5)


def test_a_torn_cloth_ends_the_episode() -> None:
    env = make(envs.HANDS, observation="key_points")
    env.reset(seed=0)
    apart = [np.array([0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 1.0])] * 10
    for action in apart:
        observation, reward, terminated, truncated, info = env.step(action)
        if terminated:
            break
    assert terminated and not truncated and reward == -1.0 and "stretched" in info["error"]
    assert env.observation_space.contains(observation)


def test_pictures_show_the_cloth_where_it_is() -> None:
    env = make(envs.HANDS, observation=("mask", "depth", "top"), pixels=64)
    observation, _ = env.reset(seed=0)
    flat = observation["mask"].sum()
    scale = 64 / (2 * env._observer.studio.radius)
    assert flat == pytest.approx(0.2 * 0.3 * scale**2, rel=0.05)
    assert observation["depth"].max() == pytest.approx(0.5 * env.task.garment.material.thickness)
    blue = observation["top"][..., 2].astype(int) > observation["top"][..., 0].astype(int) + 20
    assert (blue & (observation["mask"] == 1)).sum() > 0.9 * flat
    for action in list(env.follow(arched_curve(env.task.fold)))[:6]:
        observation, *_ = env.step(action)
    assert observation["depth"].max() > 0.03
    rows = np.flatnonzero(observation["mask"].any(axis=1))
    assert 63 - rows.max() > rows.min()  # the end at -x, below in the picture, has left its place


def test_every_camera_sees_the_hands() -> None:
    env = make(envs.HANDS)
    env.reset(seed=0)
    studio = Studio(env.task.fold.start, env.task.garment.faces)
    hands = np.array([[-0.1, 0.05, 0.1], [-0.1, -0.05, 0.1]])
    for camera in CAMERAS:
        without = studio.picture(camera, env.task.fold.start)
        assert (studio.picture(camera, env.task.fold.start, hands) != without).any(axis=2).sum() > 8


def _small_hands() -> Any:
    return make(envs.HANDS, disturbances="default", observation="vertices")


def test_the_same_answers_side_by_side_in_threads_and_in_processes() -> None:
    arguments: dict[str, Any] = {"disturbances": "default", "observation": "vertices", "seconds": 0.8}
    threads = gymnasium.make_vec(f"tatamu.envs:{envs.HANDS}", num_envs=3, **arguments, **SMALL)
    assert type(threads.unwrapped) is envs.ThreadedVectorEnv
    one = [make(envs.HANDS, **arguments) for _ in range(3)]
    seen, _ = threads.reset(seed=5)
    alone = [env.reset(seed=5 + number)[0] for number, env in enumerate(one)]
    threads.action_space.seed(0)
    for step in range(10):
        assert (seen == np.stack(alone)).all()
        actions = threads.action_space.sample()
        seen, rewards, _, truncated, infos = threads.step(actions)
        if step == 8:  # all of them ended in the step before
            alone = [env.reset()[0] for env in one]
            assert not rewards.any()
        else:
            answers = [env.step(action) for env, action in zip(one, actions, strict=True)]
            alone = [answer[0] for answer in answers]
            assert rewards.tolist() == [answer[1] for answer in answers]
            assert truncated.tolist() == [answer[3] for answer in answers] == [step == 7] * 3
            assert infos["mean_vertex_distance"].tolist() == [answer[4]["mean_vertex_distance"] for answer in answers]
    threads.close()


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of fork, in a process with threads
def test_environments_run_in_processes() -> None:
    processes = AsyncVectorEnv([_small_hands] * 2, context="spawn")
    env = _small_hands()
    seen, _ = processes.reset(seed=5)
    assert (seen[1] == env.reset(seed=6)[0]).all()
    action = np.array([0.1, 0.0, 1.0, 1.0] * 2)
    seen, *_ = processes.step(np.stack([action] * 2))
    assert (seen[1] == env.step(action)[0]).all()
    processes.close()


@pytest.mark.parametrize(
    ("kind", "arguments", "message"),
    [
        (
            envs.FOLD,
            {"observation": "hands"},
            "^observation: must be one or more of vertices, .*, each at most once, given 'hands'",
        ),
        (envs.HANDS, {"observation": ("top", "top")}, "^observation"),
        (envs.HANDS, {"observation": ()}, "^observation"),
        (envs.HANDS, {"pixels": 0}, "^pixels"),
        (envs.HANDS, {"reward": "shaped"}, "^reward: must be dense or sparse, given 'shaped'"),
        (envs.HANDS, {"seconds": 0.0}, "^seconds"),
        (envs.HANDS, {"rate": 0}, "^rate: must be a whole number from 1 to 60, given 0"),
        (envs.HANDS, {"seconds": float("nan")}, "^seconds"),
        (envs.HANDS, {"disturbances": 3}, "^disturbances: .* given '3'"),
        (envs.HANDS, {"disturbances": "loud"}, "^disturbances"),
        (envs.FOLD, {"garment": "sock"}, "^garment"),
        (envs.FOLD, {"fold": "twice"}, "^fold"),
    ],
)
def test_a_wrong_argument_is_named(kind: str, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make(kind, **arguments)


@pytest.mark.parametrize("action", [np.zeros(5), np.full(6, np.nan), np.zeros((2, 3))])
def test_a_wrong_action_is_named(action: np.ndarray) -> None:
    env = make(envs.FOLD)
    env.reset(seed=0)
    with pytest.raises(InputError, match=r"^action: must be 6 finite numbers"):
        env.step(action)


def test_a_demonstration_of_inner_grasps_goes_there_first() -> None:
    env = make(envs.HANDS, size=(0.34, 0.4))
    env.reset(seed=0)
    parameters = {**arched_curve(env.task.fold), "g1": 1, "g2": 1}
    wanted = env.task.manipulation(parameters)
    for action in env.follow(parameters):
        before = env.hands
        observation, *_ = env.step(action)
        if observation["hands"].reshape(2, 4)[:, 3].any():
            break
        assert (action.reshape(2, 4)[:, 3] == -1.0).all()
    assert before == pytest.approx(np.array(wanted.positions), abs=1e-6)
    assert {int(vertex) for jaw in env._jaws for vertex in jaw.held} >= set(wanted.grasps)


def test_what_hands_did_is_a_scene_that_ends_the_same() -> None:
    env = make(envs.HANDS, disturbances="default")
    env.reset(seed=3)
    folded(env)
    scene = env.scene()
    assert [gripper.hand for gripper in scene.grippers] == ["left", "right"]
    final, _ = env.outcome()
    again = simulate(scene).positions[-1]
    assert np.linalg.norm(again - final, axis=1).mean() < 1e-3 < 0.02 < np.linalg.norm(final - scene.cloth.vertices)


def test_a_scenario_that_is_given_is_not_drawn() -> None:
    env = make(envs.HANDS, disturbances="default", observation="key_points")
    _, info = env.reset(seed=5)
    drawn = [env.step(np.ones(8))[0] for _ in range(3)]
    _, again = env.reset(options={"world": info["world"]})
    assert again["world"] == info["world"]
    assert (np.array([env.step(np.ones(8))[0] for _ in range(3)]) == drawn).all()


def test_more_steps_a_second_lead_to_the_same_fold() -> None:
    env = make(envs.HANDS, rate=20)
    assert env.metadata["render_fps"] == 20 and env.steps == 120
    env.reset(seed=0)
    _, _, terminated, info = folded(env)
    assert terminated and info["is_success"]


def test_a_task_is_its_garment_and_fold() -> None:
    task = make_task("towel", **SMALL)
    env = envs.HandsEnv(task)
    assert env.task is task
    with pytest.raises(InputError, match=r"^fold, size, material, spacing: must be left out if garment is a Task"):
        envs.HandsEnv(task, spacing=0.04)


def test_hands_that_are_slow_take_longer_along_the_same_path() -> None:
    env = make(envs.HANDS)
    manipulation = env.task.manipulation(arched_curve(env.task.fold))
    start = np.array(manipulation.positions)
    quick, slow = (np.array(list(follow(manipulation, start, largest, 10.0, 80))) for largest in (0.06, 0.02))
    for actions, largest in ((quick, 0.06), (slow, 0.02)):
        assert np.abs(actions).max() <= 1.0
        ends = actions.reshape(80, 2, 4)[..., :3].sum(axis=0) * largest
        assert ends == pytest.approx(np.stack([path[-1] for path in manipulation.paths]), abs=1e-5)
    assert (slow[:, 3] > 0).sum() > 2 * (quick[:, 3] > 0).sum()


@pytest.mark.parametrize("kind", KINDS)
def test_coarse_cells_are_told_once(kind: str) -> None:
    env = make(kind, disturbances="default")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for seed in (1, 2):
            env.reset(seed=seed)
            env.step(np.zeros(env.action_space.shape, np.float32))
    assert len(told) == 1 and "the cloth may drape too stiffly" in str(told[0].message)


@pytest.mark.parametrize("fabric", ["cotton", "denim", "terry"])
def test_the_spacing_that_is_advised_for_coarse_cells_is_fine_enough(fabric: str) -> None:
    def told(spacing: float) -> list[str]:
        with warnings.catch_warnings(record=True) as lines:
            warnings.simplefilter("always")
            make(envs.HANDS, size=(0.3, 0.4), spacing=spacing, material=fabric).reset()
        return [str(line.message) for line in lines]

    (line,) = told(0.06)
    assert told(1e-3 * float(line.partition("give a spacing of ")[2].split()[0])) == []


def flat(value: Any) -> Any:
    """Return a value with bytes in place of its arrays."""
    if isinstance(value, dict):
        return {name: flat(each) for name, each in value.items()}
    if isinstance(value, tuple | list):
        return [flat(each) for each in value]
    return (value.shape, value.tobytes()) if isinstance(value, np.ndarray) else value


COPIED = {"deep": copy.deepcopy, "shallow": copy.copy, "pickle": lambda env: pickle.loads(pickle.dumps(env))}


@pytest.mark.parametrize("copied", COPIED.values(), ids=COPIED)
@pytest.mark.parametrize("kind", KINDS)
def test_a_copy_goes_on_as_its_original_would(kind: str, copied: Callable[[Any], Any]) -> None:
    """As tree search copies environments: in the middle of an episode, and the copy moves first."""
    env = make(kind, disturbances="default", observation=EVERYTHING)
    env.reset(seed=1)
    lift = np.array([0.3, 0.0, 0.5, 1.0] * 2 if kind == envs.HANDS else [0.0] * 6, np.float32)
    if kind == envs.HANDS:
        for _ in range(4):
            env.step(lift)
    other = copied(env)
    first = [other.step(lift), other.reset(), other.step(lift)]
    assert flat(first) == flat([env.step(lift), env.reset(), env.step(lift)])
    assert copied(make(kind)).reset(seed=2)[1]["world"] == make(kind).reset(seed=2)[1]["world"]


@pytest.mark.parametrize("copied", COPIED.values(), ids=COPIED)
def test_environments_side_by_side_are_copied_together(copied: Callable[[Any], Any]) -> None:
    env = gymnasium.make_vec(f"tatamu.envs:{envs.HANDS}", 2, **SMALL)
    env.reset(seed=0)
    lift = np.array([[0.3, 0.0, 0.5, 1.0] * 2] * 2, np.float32)
    env.step(lift)
    other = copied(env)
    np.testing.assert_equal(other.step(lift), env.step(lift))
    env.close()
    assert other.step(lift)[0]["hands"].shape == (2, 8)
    other.close()
