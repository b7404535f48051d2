"""The tables of docs/notes/datasets.md: what an episode costs, what is read back, a policy that learns from one.

python -m benchmarks.datasets --out runs/datasets --write-docs
"""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy.stats import bootstrap

from benchmarks.tables import arguments, show
from tatamu import make_task
from tatamu.evaluation.disturbances import load_disturbances
from tatamu.evaluation.success import interval_of
from tatamu.folding.parameters import arched_curve
from tatamu.folding.trial_scene import scene_of
from tatamu.lerobot import LeRobotReader
from tatamu.policies.dataset import DatasetFolder, DatasetSpecification, make_dataset
from tatamu.policies.dataset.episode import Recorder, make_env, record_episode
from tatamu.policies.dataset.record import read_records
from tatamu.policies.dataset.sources import draw_fold
from tatamu.policies.dataset.states import read_states
from tatamu.policies.envs import HandsEnv
from tatamu.policies.envs.cameras import CAMERAS, Studio
from tatamu.policies.envs.hands import HandsOptions
from tatamu.simulation.simulators import simulate

SIZES: dict[str, Any] = {"width": {"low": 0.24, "high": 0.40}, "length": {"low": 0.40, "high": 0.70}, "spacing": 0.04}
"""Towels of varied size on a coarse mesh."""
RATE = 10
"""Steps per second of the episodes; this is the default."""
FOLDS, HELD_OUT = 200, 50
"""Folds to learn from, and sizes to be tried on."""
TIMED = 10
"""Number of episodes in a timing."""
PICTURES = 20
"""Number of pictures in a timing; the fastest counts."""
WANTED = 10_000
"""Number of folds that two processors must record in an hour."""

Policy = Callable[[Any, Any, int], np.ndarray]
"""From the first observation, the present one and the number of the step to an action."""


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


def pictures() -> list[dict[str, Any]]:
    """Pictures of 96 x 96 that each camera takes of a towel in a second of the processor, halfway through its fold."""
    rows = []
    for spacing in (0.02, 0.04):
        task = make_task("towel", spacing=spacing)
        scene = scene_of(task.fold, task.manipulation(arched_curve(task.fold)))
        middle = simulate(scene).positions[scene.frames // 2]
        studio = Studio(task.fold.start, task.garment.faces)
        hands = np.zeros((2, 3))
        for camera in CAMERAS:
            studio.picture(camera, middle, hands)
            take = partial(studio.picture, camera, middle, hands)
            took = min(_seconds(take) for _ in range(PICTURES))
            rows.append({"vertices": len(middle), "camera": f"`{camera}`", "pictures per second": f"{1 / took:.0f}"})
    return rows


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


def _places(hands: np.ndarray) -> np.ndarray:
    """Return the places of the hands [m], shape (n, 6), from the observation `hands`, shape (n, 8)."""
    return hands.reshape(-1, 2, 4)[:, :, :3].reshape(-1, 6)


def _jaws(numbers: np.ndarray) -> np.ndarray:
    """Return the values of the jaws, shape (n, 2), in the observation `hands` or in actions, shape (n, 8)."""
    return numbers.reshape(-1, 2, 4)[:, :, 3]


def _shown(first: Any, hands: np.ndarray, step: np.ndarray) -> np.ndarray:
    """What the policy sees: the key points at first, the hands from where they began, and the time [50 steps]."""
    size = np.tile(first["key_points"].ravel(), (len(hands), 1))
    return np.hstack([size, _places(hands) - _places(first["hands"]), _jaws(hands), step[:, None] / 50.0])


def _cloned(dataset: DatasetFolder) -> Policy:
    """A network of two layers that repeats the successful demonstrations: where the hands are next, and their jaws.

    Places, because a sum of motions would drift; from the hands' own places, because motions take whole steps.
    """
    from sklearn.compose import TransformedTargetRegressor
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.neural_network import MLPRegressor
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    seen, done = [], []
    for record in read_records(dataset.table):
        if record.success:
            states = read_states(dataset.states, record.episode, ["key_points", "hands", "action"])
            first = {name: states[name][0] for name in ("key_points", "hands")}
            seen.append(_shown(first, states["hands"][:-1], np.arange(record.frames)))
            done.append(np.hstack([_places(states["hands"][1:]) - _places(first["hands"]), _jaws(states["action"])]))
    network = MLPRegressor(hidden_layer_sizes=(64, 64), solver="lbfgs", max_iter=1000, random_state=0)
    policy = TransformedTargetRegressor(make_pipeline(StandardScaler(), network), transformer=StandardScaler())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # it ends after that many iterations
        policy.fit(np.concatenate(seen), np.concatenate(done))
    largest = HandsOptions().speed / RATE

    def act(first: Any, now: Any, step: int) -> np.ndarray:
        found = policy.predict(_shown(first, now["hands"][None], np.array([step])))[0]
        motions = (found[:6] + _places(first["hands"])[0] - _places(now["hands"])[0]) / largest
        return np.clip(np.hstack([motions.reshape(2, 3), found[6:, None]]), -1.0, 1.0).ravel()

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
    return lambda _first, _now, step: whole[step] if step < longest else still


def _try(policy: Policy, held_out: DatasetSpecification, record: Any) -> tuple[float, bool]:
    """Let a policy fold a towel in its world for as long as an episode of `tatamu/Hands-v0`."""
    env: HandsEnv = make_env(record.make_task(), held_out.model_copy(update={"formats": ["zarr"]}))
    first: Any
    first, info = env.reset(options={"world": record.world})
    now: Any = first
    for step in range(6 * RATE):
        now, _, terminated, truncated, info = env.step(policy(first, now, step))
        if terminated or truncated:
            break
    return float(info["mean_vertex_distance"]), bool(info["is_success"])


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--out", type=Path, default=Path(tempfile.gettempdir()) / "tatamu-datasets")
    names = ("speed", "pictures", "read back", "policy")
    parser.add_argument("--only", nargs="+", choices=names, default=names, help="these tables")
    chosen = parser.parse_args()
    with ThreadPoolExecutor(1) as one:
        dataset = make_dataset(specification(), chosen.out / "folds", executor=one)
    tables: dict[str, Callable[[], list[dict[str, Any]]]] = {
        "speed": speed,
        "pictures": pictures,
        "read back": lambda: read_back(dataset),
        "policy": lambda: policies(dataset),
    }
    for name in chosen.only:
        show({f"datasets: {name}": tables[name]()}, chosen.write_docs)


if __name__ == "__main__":
    main()
