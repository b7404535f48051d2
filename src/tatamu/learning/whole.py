"""The folder of a plan of several steps: one result, one rollout and one report for the whole."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tatamu import __version__
from tatamu.folding.score import Score, intersection_over_union, top_views, vertex_distances
from tatamu.folding.task import Job
from tatamu.results import FromFlat, PlanResult, ResultFolder, StepResult, describe_plan
from tatamu.rollout import Rollout

MEASURES = tuple(Score.__dataclass_fields__)


def write_whole(job: Job, folder: ResultFolder, ideals: Sequence[np.ndarray]) -> Path:
    """Write `result.json`, `rollout.npz` and `report.html` of a plan whose steps are learned, unless they are there.

    Args:
        job: The garment and the plan that folded it.
        folder: The folder of the plan, which holds those of the steps.
        ideals: The flat garment after each step, all ideal [m], shapes (n, 3).

    Returns:
        The report.
    """
    from tatamu.report import write_plan_report

    steps = [folder.step(number) for number in range(len(ideals))]
    result = _result(job, steps, ideals)
    if folder.holds(result) and folder.rollout_file.exists() and folder.report_file.exists():
        return folder.report_file
    folder.result_file.unlink(missing_ok=True)  # written last: it says that the others are this plan's
    whole = joined([step.rollout for step in steps], ideals[-1])
    folder.write_rollout(whole, whole.extra)
    write_plan_report(folder.path, result)
    folder.write_result(result)
    return folder.report_file


def joined(rollouts: Sequence[Rollout], target: np.ndarray) -> Rollout:
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


def _result(job: Job, folders: Sequence[ResultFolder], ideals: Sequence[np.ndarray]) -> PlanResult:
    first = folders[0].result
    rollouts = [folder.rollout for folder in folders]
    states = [rollout.positions[-1] for rollout in rollouts]
    assert all((after.positions[0] == before).all() for before, after in zip(states, rollouts[1:], strict=False))
    steps = [
        _step(number, job, folder, from_flat(job.garment.faces, ideal, state))
        for number, (folder, ideal, state) in enumerate(zip(folders, ideals, states, strict=True))
    ]
    return PlanResult(
        version=1,
        tatamu=__version__,
        plan=describe_plan(job),
        sampler=first.sampler,
        grasps=first.grasps,
        seed=first.seed,
        wall_seconds=round(sum(folder.result.wall_seconds or 0.0 for folder in folders), 3),
        steps=steps,
        final=steps[-1].whole,
    )


def _step(number: int, job: Job, folder: ResultFolder, whole: FromFlat) -> StepResult:
    result = folder.result
    best = result.best_trial
    assert result.crossings is not None, "a trial is complete"
    return StepResult(
        folder=folder.path.name,
        title=job.plan.steps[number].title,
        hands=result.task.hands,
        trials=len(result.trials),
        best=best.number,
        crossings=result.crossings,
        whole=whole,
        **{name: getattr(best, name) for name in MEASURES},
    )


def from_flat(faces: np.ndarray, ideal: np.ndarray, state: np.ndarray) -> FromFlat:
    """How far a state is from the flat garment's ideal, both of shape (n, 3) [m]."""
    reached, wanted = top_views(faces, state, ideal)
    return FromFlat(
        mean_vertex_distance=float(vertex_distances(ideal, state).mean()),
        mask_iou=intersection_over_union(reached, wanted),
        area_error=float(100.0 * abs(reached.sum() / wanted.sum() - 1.0)),
    )
