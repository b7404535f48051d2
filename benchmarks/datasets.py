"""The tables of docs/notes/datasets.md: what an episode costs, what is read back, a policy that learns from one.

python -m benchmarks.datasets --out runs/datasets --write-docs
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from benchmarks.tables import markdown, publish
from scipy.stats import bootstrap

from tatamu.dataset import DatasetFolder, DatasetSpecification, make_dataset
from tatamu.dataset.episode import Recorder, make_env, record_episode
from tatamu.dataset.sources import draw_fold
from tatamu.dataset.states import read_states
from tatamu.dataset.table import read_records
from tatamu.disturbances import load_disturbances
from tatamu.envs import HandsEnv
from tatamu.folding.parameters import arched_curve
from tatamu.folding.trial_scene import scene_of
from tatamu.lerobot import LeRobotReader
from tatamu.robustness.record import interval_of
from tatamu.simulators import simulate

SIZES: dict[str, Any] = {"width": {"low": 0.24, "high": 0.40}, "length": {"low": 0.40, "high": 0.70}, "spacing": 0.04}
"""Towels of varied size on a coarse mesh."""
FOLDS, HELD_OUT = 200, 50
"""Folds to learn from, and sizes to be tried on."""
TIMED = 10
"""Episodes of a timing."""
WANTED = 10_000
"""Folds that an hour on two processors has to do."""

Policy = Callable[[Any, int], np.ndarray]
"""From an observation and the number of the step to an action."""


def specification(**changes: Any) -> DatasetSpecification:
    return DatasetSpecification.model_validate({"episodes": FOLDS, "seed": 0, "garment": SIZES, **changes})


def speed() -> list[dict[str, Any]]:
    """Processor seconds of an episode beside those of `simulate` for the same folds, on one thread."""
    kinds = {
        "states": specification(formats=["zarr"]),
        "states and two cameras": specification(formats=["zarr", "lerobot"]),
    }
    known = load_disturbances("default")
    bare = kinds["states"]
    tasks = [draw_fold(bare, [], number).subject.make_task() for number in range(TIMED)]
    scenes = [scene_of(task.fold, task.manipulation(arched_curve(task.fold))) for task in tasks]
    simulate(scenes[0])
    alone = _seconds(lambda: [simulate(scene) for scene in scenes]) / TIMED
    rows = [_timed("`simulate`", alone, alone)]
    for name, each in kinds.items():
        recorder = Recorder(each, [], known, None)
        record_episode(recorder, TIMED)
        took = _seconds(lambda recorder=recorder: [record_episode(recorder, k) for k in range(TIMED)]) / TIMED  # type: ignore[misc]
        rows.append(_timed(f"an episode: {name}", took, alone))
    return rows


def _seconds(work: Callable[[], object]) -> float:
    started = process_time()
    work()
    return process_time() - started


def _timed(name: str, seconds: float, alone: float) -> dict[str, Any]:
    hours = WANTED * seconds / 2 / 3600
    return {
        "one fold": name,
        "processor [s]": f"{seconds:.2f}",
        "ratio": f"{seconds / alone:.2f}",
        "10,000 folds on 2 processors [h]": f"{hours:.2f}",
    }


def read_back(dataset: DatasetFolder) -> list[dict[str, Any]]:
    """Count and compare what both formats have of the same episodes."""
    reader = LeRobotReader(dataset.path)
    records = read_records(dataset.table)
    frames, numbers, pictures = 0, 0.0, 0
    for record in records:
        states = read_states(dataset.states, record.episode, ["action", "hands"])
        found = reader.numbers(record.episode, "action", "observation.state")
        frames += len(found["action"])
        numbers = max(numbers, float(np.abs(found["action"] - states["action"]).max()))
        numbers = max(numbers, float(np.abs(found["observation.state"] - states["hands"][:-1]).max()))
    for name in ("top", "front"):
        pictures += sum(1 for record in records for _ in reader.pictures(record.episode, f"observation.images.{name}"))
    size = {part: _megabytes(dataset.path / part) for part in ("data", "videos", "states.zarr")}
    return [
        {
            "episodes": len(records),
            "frames": frames,
            "frames of `meta/info.json`": reader.info["total_frames"],
            "pictures": pictures,
            "largest difference of numbers": f"{numbers:g}",
            "Parquet [MB]": size["data"],
            "video [MB]": size["videos"],
            "Zarr [MB]": size["states.zarr"],
        }
    ]


def _megabytes(path: Path) -> str:
    return f"{sum(file.stat().st_size for file in path.rglob('*') if file.is_file()) / 1e6:.1f}"


def policies(dataset: DatasetFolder) -> list[dict[str, Any]]:
    """Try a cloned policy, the mean motion of the hands, and the demonstrations on sizes that were not shown."""
    held_out = specification(seed=1, episodes=HELD_OUT)
    known = load_disturbances("default")
    recorder = Recorder(held_out, [], known, None)
    cloned, mean = _cloned(dataset), _mean_motion(dataset)
    expert = [record_episode(recorder, number).record for number in range(HELD_OUT)]
    rows = [_row("demonstrations", [_distance_of(each) for each in expert], [each.success for each in expert])]
    distances = {}
    for name, policy in (("cloned policy", cloned), ("mean motion", mean)):
        found = [_try(policy, held_out, record) for record in expert]
        distances[name] = np.array([distance for distance, _ in found])
        rows.append(_row(name, distances[name].tolist(), [success for _, success in found]))
    gain = 1e3 * (distances["mean motion"] - distances["cloned policy"])
    low, high = bootstrap((gain,), np.mean, rng=np.random.default_rng(0)).confidence_interval
    rows.append(
        {
            "policy": "mean motion less cloned policy",
            "median [mm]": f"{np.median(gain):.1f}",
            "mean [mm]": f"{gain.mean():.1f}, 95 % {low:.1f} to {high:.1f}",
            "succeed": "",
        }
    )
    return rows


def _distance_of(record: Any) -> float:
    return float("nan") if record.score is None else float(record.score.mean_vertex_distance)


def _row(name: str, distances: Sequence[float], successes: Sequence[bool]) -> dict[str, Any]:
    millimetres = 1e3 * np.array(distances)
    low, high = interval_of(sum(successes), len(successes))
    share = f"{sum(successes)} of {len(successes)} ({100 * low:.0f} to {100 * high:.0f} %)"
    return {
        "policy": name,
        "median [mm]": f"{np.median(millimetres):.1f}",
        "mean [mm]": f"{millimetres.mean():.1f}",
        "succeed": share,
    }


def _shown(key_points: np.ndarray, hands: np.ndarray, step: int | np.ndarray) -> np.ndarray:
    """What the policy sees: key points and hands [m], and the time in parts of 50 steps."""
    rows = len(hands)
    return np.hstack([key_points.reshape(rows, -1), hands, np.reshape(step, (-1, 1)) / 50.0 * np.ones((rows, 1))])


def _cloned(dataset: DatasetFolder) -> Policy:
    """A network of two layers that repeats the successful demonstrations."""
    from sklearn.neural_network import MLPRegressor
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    seen, done = [], []
    for record in read_records(dataset.table):
        if record.success:
            states = read_states(dataset.states, record.episode, ["key_points", "hands", "action"])
            seen.append(_shown(states["key_points"][:-1], states["hands"][:-1], np.arange(record.frames)))
            done.append(states["action"])
    network = MLPRegressor(hidden_layer_sizes=(64, 64), max_iter=100, early_stopping=True, random_state=0)
    policy = make_pipeline(StandardScaler(), network).fit(np.concatenate(seen), np.concatenate(done))

    def act(observation: Any, step: int) -> np.ndarray:
        shown = _shown(observation["key_points"][None], observation["hands"][None], step)
        return np.asarray(policy.predict(shown)[0])

    return act


def _mean_motion(dataset: DatasetFolder) -> Policy:
    """The mean of all successful demonstrations, step by step; those that have ended wait with open hands."""
    actions = [
        read_states(dataset.states, record.episode, ["action"])["action"]
        for record in read_records(dataset.table)
        if record.success
    ]
    still = np.tile([0.0, 0.0, 0.0, -1.0], 2)
    longest = max(map(len, actions))
    whole = np.mean([np.vstack([each, np.tile(still, (longest - len(each), 1))]) for each in actions], axis=0)
    return lambda _, step: whole[step] if step < longest else still


def _try(policy: Policy, held_out: DatasetSpecification, record: Any) -> tuple[float, bool]:
    """Let a policy fold a towel in its world for as long as an episode of `tatamu/Hands-v0`."""
    env: HandsEnv = make_env(record.make_task(), held_out.model_copy(update={"formats": ["zarr"]}))
    observation: Any
    observation, info = env.reset(options={"world": record.world})
    for step in range(60):
        observation, _, terminated, truncated, info = env.step(policy(observation, step))
        if terminated or truncated:
            break
    return float(info["mean_vertex_distance"]), bool(info["is_success"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path(tempfile.gettempdir()) / "tatamu-datasets")
    parser.add_argument("--write-docs", action="store_true")
    chosen = parser.parse_args()
    with ThreadPoolExecutor(1) as one:
        dataset = make_dataset(specification(), chosen.out / "folds", executor=one)
    tables: dict[str, Callable[[], list[dict[str, Any]]]] = {
        "datasets: speed": speed,
        "datasets: read back": lambda: read_back(dataset),
        "datasets: policy": lambda: policies(dataset),
    }
    for name, make in tables.items():
        table = markdown(make())
        print(f"{name}\n{table}\n", flush=True)
        if chosen.write_docs:
            publish(name, table)


if __name__ == "__main__":
    main()
