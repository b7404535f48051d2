"""The folder of a learned fold; docs/reference/result-folder.md describes every file."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from optuna.trial import FrozenTrial

from tatamu import __version__
from tatamu.crossings import crossings_over_time
from tatamu.files import write_json
from tatamu.folding.baselines import BASELINES
from tatamu.folding.manipulation import Manipulation, described, scene_of
from tatamu.folding.score import Score, vertex_distances
from tatamu.folding.task import Outcome, Task
from tatamu.rollout import Rollout

MEASURES = tuple(name for name in Score.__dataclass_fields__ if name != "objective")


def attributes_of(outcome: Outcome, trajectory_length: float, seconds: float) -> dict[str, Any]:
    """What is kept of a trial beside parameters and objective."""
    measures = outcome.score.as_dict() if outcome.score else dict.fromkeys(MEASURES)
    return {
        "state": "failed" if outcome.failed else "complete",
        "error": outcome.error,
        **{name: measures[name] for name in MEASURES},
        "trajectory_length": trajectory_length,
        "seconds": round(seconds, 3),
    }


def trial_record(trial: FrozenTrial) -> dict[str, Any]:
    """A trial as `result.json` holds it."""
    attributes = trial.user_attrs
    return {
        "number": trial.number,
        "state": attributes["state"],
        "error": attributes["error"],
        "parameters": trial.params,
        "objective": trial.value,
        **{name: attributes[name] for name in MEASURES},
        "seconds": attributes["seconds"],
    }


def best_number(trials: list[FrozenTrial], count: int | None = None) -> int | None:
    """Number of the complete trial of least objective among the first `count`; None if all failed."""
    complete = [t for t in trials[:count] if t.user_attrs["state"] == "complete"]
    return min(complete, key=lambda t: (t.value, t.number)).number if complete else None


def baseline_records(task: Task, parallel: int = 1) -> list[dict[str, Any]]:
    """Score the fixed trajectories on this task, so many at a time."""
    with ThreadPoolExecutor(parallel) as pool:
        return list(pool.map(partial(_baseline_record, task), BASELINES))


def _baseline_record(task: Task, name: str) -> dict[str, Any]:
    title, make = BASELINES[name]
    manipulation = make(task.fold)
    outcome = task.evaluate(manipulation)
    attributes = attributes_of(outcome, manipulation.trajectory_length, 0.0)
    attributes["seconds"] = outcome.rollout.info["wall_seconds"] if outcome.rollout else 0.0
    path = manipulation.paths[0][:: max(1, len(manipulation.paths[0]) // 100)]
    return {"name": name, "title": title, "objective": outcome.objective, **attributes, "path": path.tolist()}


def crossings_of(rollout: Rollout) -> dict[str, int]:
    """How many edges pass through triangles: at the end, and in the worst frame."""
    counts = crossings_over_time(rollout.positions, rollout.faces)
    return {"final": int(counts[-1]), "most": int(counts.max())}


def write_result(
    folder: Path,
    identity: dict[str, Any],
    asked: dict[str, Any],
    trials: list[FrozenTrial],
    baselines: list[Any] | None,
    best: Outcome | None,
) -> None:
    """Write `result.json`; `asked` is the task's, `best` the outcome of the best trial, None if all failed."""
    records = [trial_record(trial) for trial in trials]
    write_json(
        folder / "result.json",
        {
            "version": 1,
            "tatamu": __version__,
            **identity,
            "asked": asked,
            "wall_seconds": round(sum(record["seconds"] for record in records), 3),
            "best": best_number(trials),
            "crossings": crossings_of(best.rollout) if best and best.rollout else None,
            "trials": records,
            "baselines": baselines or [],
        },
    )


def write_best(folder: Path, task: Task, best: Manipulation, rollout: Rollout, errors: dict[str, np.ndarray]) -> None:
    """Write `manipulation.json`, `scene.json` and `rollout.npz` of the best trial.

    Args:
        folder: Where they go.
        task: What was learned.
        best: The best manipulation.
        rollout: Its rollout.
        errors: Further arrays for the rollout file: e_i of earlier trials [m], each shape (n,).
    """
    write_json(folder / "manipulation.json", described(task.fold, best))
    scene_of(task.fold, best).save(folder / "scene.json")
    extra = {"target": task.fold.target, **errors}
    Rollout(rollout.times, rollout.positions, rollout.faces, rollout.info, extra).save(folder / "rollout.npz")


def errors_of(task: Task, rollout: Rollout) -> np.ndarray:
    """e_i of a rollout's final state [m], shape (n,)."""
    return vertex_distances(task.fold.target, rollout.positions[-1])
