"""The folder of a plan of several steps: one result, one rollout and one report for the whole."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from tatamu import __version__
from tatamu.files import read_json, write_json
from tatamu.folding.score import Score, intersection_over_union, top_views, vertex_distances
from tatamu.folding.task import Job
from tatamu.rollout import Rollout

MEASURES = tuple(Score.__dataclass_fields__)


def write_whole(job: Job, folder: Path, steps: list[Path], ideals: list[np.ndarray]) -> Path:
    """Write `result.json`, `rollout.npz` and `report.html` of a plan whose steps are learned, unless they are there.

    Args:
        job: What was folded.
        folder: Where they go.
        steps: Folders of the learned steps.
        ideals: The flat garment after each step, all ideal [m], shapes (n, 3).

    Returns:
        The report.
    """
    from tatamu.report import write_plan_report

    results = [read_json(step / "result.json") for step in steps]
    rollouts = [Rollout.load(step / "rollout.npz") for step in steps]
    result = _result(job, results, rollouts, ideals)
    files = [folder / name for name in ("result.json", "rollout.npz", "report.html")]
    if all(file.exists() for file in files) and read_json(files[0]) == result:
        return files[2]
    files[0].unlink(missing_ok=True)  # written last: it says that the others are this plan's
    joined(rollouts, ideals[-1]).save(files[1])
    write_plan_report(folder, result)
    write_json(files[0], result)
    return files[2]


def joined(rollouts: list[Rollout], target: np.ndarray) -> Rollout:
    """Rollouts that go on from one another as one; `target` is the wanted end [m], shape (n, 3)."""
    starts = np.concatenate([[0.0], np.cumsum([rollout.times[-1] for rollout in rollouts])])
    times = [rollout.times[1:] + start for rollout, start in zip(rollouts, starts[:-1], strict=True)]
    first = rollouts[0]
    info = {
        **first.info,
        "wall_seconds": sum(rollout.info["wall_seconds"] for rollout in rollouts),
        "setup_seconds": sum(rollout.info["setup_seconds"] for rollout in rollouts),
        "steps": sum(rollout.info["steps"] for rollout in rollouts),
        "warnings": sorted({warning for rollout in rollouts for warning in rollout.info["warnings"]}),
    }
    return Rollout(
        np.concatenate([first.times[:1], *times]),
        np.concatenate([first.positions[:1], *(rollout.positions[1:] for rollout in rollouts)]),
        first.faces,
        info,
        {"target": target, "step_starts": starts[:-1]},
    )


def _result(job: Job, results: list[Any], rollouts: list[Rollout], ideals: list[np.ndarray]) -> dict[str, Any]:
    """What `result.json` of a plan holds; see docs/reference/result-folder.md."""
    garment, first = job.garment, results[0]
    states = [rollout.positions[-1] for rollout in rollouts]
    assert all((after.positions[0] == before).all() for before, after in zip(states, rollouts[1:], strict=False))
    steps = [
        _step(number, job, result, against(garment.faces, ideal, state))
        for number, (result, ideal, state) in enumerate(zip(results, ideals, states, strict=True))
    ]
    return {
        "version": 1,
        "tatamu": __version__,
        "plan": {
            "garment": garment.name,
            "size": list(garment.size),
            "fold": job.plan.name,
            "material": garment.material.model_dump(),
            "spacing": garment.spacing,
            "vertices": len(garment.vertices),
            "simulator": job.simulator,
        },
        **{key: first[key] for key in ("sampler", "grasps", "seed")},
        "wall_seconds": round(sum(result["wall_seconds"] for result in results), 3),
        "steps": steps,
        "final": steps[-1]["whole"],
    }


def _step(number: int, job: Job, result: Any, whole: dict[str, float]) -> dict[str, Any]:
    """A step: how well it did its own fold, and how far the garment is from the ideal of all folds so far."""
    best = result["trials"][result["best"]]
    return {
        "folder": f"step-{number + 1}",
        "title": job.plan.steps[number].title,
        "hands": result["task"].get("hands", 2),
        "trials": len(result["trials"]),
        "best": result["best"],
        **{name: best[name] for name in MEASURES},
        "crossings": result["crossings"],
        "whole": whole,
    }


def against(faces: np.ndarray, ideal: np.ndarray, state: np.ndarray) -> dict[str, float]:
    """How far a state is from the flat garment's ideal, both of shape (n, 3) [m]."""
    reached, wanted = top_views(faces, state, ideal)
    return {
        "mean_vertex_distance": float(vertex_distances(ideal, state).mean()),
        "mask_iou": intersection_over_union(reached, wanted),
        "area_error": float(100.0 * abs(reached.sum() / wanted.sum() - 1.0)),
    }
