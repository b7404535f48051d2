"""The result of learning a plan with several steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path

import numpy as np

from tatamu.base.version import __version__
from tatamu.folding.fold import ideal_folds
from tatamu.folding.score import intersection_over_union, top_views, vertex_distances
from tatamu.folding.task import Task
from tatamu.simulation.rollout import Rollout
from tatamu.study.folder import ResultFolder, step_name
from tatamu.study.record import FromFlat, PlanRecord, StepRecord, describe_plan
from tatamu.study.result import PAGES, Result


@dataclass(frozen=True, eq=False)
class PlanResult:
    """A learned plan with several steps."""

    record: PlanRecord
    steps: list[Result]
    rollout: Rollout
    """The motion of the cloth in all steps, with the `target` and the start of each step (`step_starts` [s]) in
    `extra`."""
    folder: Path | None = field(default=None)
    """None if the result is only in memory."""

    @property
    def final(self) -> FromFlat:
        """Deviation of the final garment from its ideal shape, which perfect folds in all steps would give."""
        return self.record.final

    def save(self, path: Path | str) -> ResultFolder:
        """Write `result.json`, `rollout.npz` and the folders of the steps."""
        for number, step in enumerate(self.steps):
            step.save(Path(path) / step_name(number))
        return self.write_whole(Path(path))

    def write_whole(self, path: Path) -> ResultFolder:
        folder = ResultFolder(path)
        folder.result_file.unlink(missing_ok=True)  # It is written last, and then shows that the rollout belongs to it.
        self.rollout.save(folder.rollout_file)
        folder.write_record(self.record)
        return folder

    def write_report(self, file: Path | str | None = None) -> Path:
        """Write the page of the plan, by default `report.html` in its folder, and return its path."""
        return Path(import_module(PAGES).write_plan_report(self, None if file is None else Path(file)))

    def _repr_html_(self) -> str:
        return "".join(step._repr_html_() for step in self.steps)

    def __repr__(self) -> str:
        away = 1e3 * self.final.mean_vertex_distance
        return f"PlanResult({self.record.plan.garment}, {self.record.plan.fold}: {away:.1f} mm from the ideal folds)"

    @classmethod
    def load(cls, path: Path | str) -> PlanResult:
        """Read the folder of a learned plan."""
        folder = ResultFolder(Path(path))
        steps = [Result.load(Path(path) / step.folder) for step in folder.plan_record.steps]
        return cls(folder.plan_record, steps, folder.rollout, Path(path))

    @classmethod
    def of(cls, task: Task, steps: Sequence[Result], folder: Path | None) -> PlanResult:
        """Return the result of at least one step, in order. `task` is the first."""
        ideals = [fold.target for fold in ideal_folds(task.garment, task.plan, task.hands)]
        faces = task.garment.faces
        records = [
            _step(number, task, step, from_flat(faces, ideals[number], step.final)) for number, step in enumerate(steps)
        ]
        first = steps[0].record
        record = PlanRecord(
            tatamu=__version__,
            plan=describe_plan(task),
            sampler=first.sampler,
            grasps=first.grasps,
            seed=first.seed,
            wall_seconds=round(sum(step.record.wall_seconds or 0.0 for step in steps), 3),
            steps=records,
            final=records[-1].whole,
        )
        return cls(record, list(steps), join([step.rollout for step in steps], ideals[len(steps) - 1]), folder)


def join(rollouts: Sequence[Rollout], target: np.ndarray) -> Rollout:
    """Join the motions of consecutive steps into one with the final target [m], shape (n, 3)."""
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


def _step(number: int, task: Task, result: Result, whole: FromFlat) -> StepRecord:
    record = result.record
    best = record.best_trial
    assert record.crossings is not None, "a trial is complete"
    return StepRecord(
        folder=step_name(number),
        title=task.plan.steps[number].title,
        hands=record.task.hands,
        trials=len(record.trials),
        best=best.number,
        crossings=record.crossings,
        whole=whole,
        objective=best.objective,
        trajectory_length=best.trajectory_length,
        score=best.score,
    )


def from_flat(faces: np.ndarray, ideal: np.ndarray, state: np.ndarray) -> FromFlat:
    """Return the deviation of a folded garment from the ideal one, both [m], shape (n, 3)."""
    reached, wanted = top_views(faces, state, ideal)
    return FromFlat(
        mean_vertex_distance=float(vertex_distances(ideal, state).mean()),
        mask_iou=intersection_over_union(reached, wanted),
        area_error=float(100.0 * abs(reached.sum() / wanted.sum() - 1.0)),
    )
