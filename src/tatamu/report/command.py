"""Makes the shell commands that repeat a learned fold."""

from __future__ import annotations

import shlex
from pathlib import Path

from tatamu.evaluation.disturbances import default_disturbances
from tatamu.folding.task import TaskOptions
from tatamu.study.folder import SCENE
from tatamu.study.inputs import kept_input
from tatamu.study.options import USUAL_QUANTILE, TaskRequest
from tatamu.study.record import ResultRecord
from tatamu.study.result import Result


def learn(fold: Result) -> str:
    """Return the command that runs the study of a learned fold again."""
    folder = (fold.folder or Path("fold")).resolve()
    if fold.record.task.step:
        folder = folder.parent
    words = request(fold.record, fold.folder).words()
    return shlex.join(["tatamu", "learn", words[0], "--out", folder.name, *words[1:]])


def request(record: ResultRecord, folder: Path | None) -> TaskRequest:
    """Return the options of the command that started a study.

    Args:
        record: Record of the study.
        folder: Folder of the study, which contains copies of the user's files; None if the study is only in memory.
    """
    task = record.task
    asked = record.asked or TaskOptions(
        garment=task.garment, fold=task.fold, size=task.size, spacing=task.spacing, hands=task.hands
    )
    return TaskRequest(
        garment=asked.garment,
        size="x".join(f"{side:g}" for side in asked.size) if asked.size else None,
        scale=asked.scale,
        fold=asked.fold,
        hands=asked.hands,
        material=asked.material,
        spacing=asked.spacing,
        simulator=task.simulator,
        robot=asked.robot or task.robot,
        trials=len(record.trials) if record.until_gain is None else "auto",
        seed=record.seed,
        sampler=record.sampler,
        grasps=record.grasps,
        disturbances=_disturbances(record, folder),
        quantile=_quantile(record),
        coarse=False if record.coarse is None and not asked.spacing and not _is_late(record) else None,
        parallel=record.parallel,
        baselines=bool(record.baselines),
    )


def _is_late(record: ResultRecord) -> bool:
    """Return whether a study belongs to the second or a later step of a plan.

    Such a study has no coarse mesh, even if the user did not exclude coarse meshes.
    """
    return record.task.step is not None and record.task.step[0] > 1


def _disturbances(record: ResultRecord, folder: Path | None) -> str | None:
    """Return the name or file that gives the disturbances of a study; None if they are the default disturbances."""
    if record.disturbances is None:
        return "none"
    if record.disturbances == default_disturbances().describe():
        return None
    kept = kept_input(folder, "disturbances") if folder else None
    return None if kept is None else f"{kept.parent.parent.parent.name}/{'/'.join(kept.parts[-3:])}"


def _quantile(record: ResultRecord) -> float | str | None:
    """Return the option for the quantile of the objective, as the user gave it; None if it is the default quantile."""
    if record.disturbances is None:
        return None
    if record.quantile is None:
        return "mean"
    return None if record.quantile == USUAL_QUANTILE else record.quantile


def simulate(fold: Result) -> str:
    """Return the command that simulates the best trial of a learned fold."""
    scene = f"{(fold.folder or Path('fold')).resolve().name}/{SCENE}"
    words = ["tatamu", "simulate", scene, "--out", "again.npz", "--simulator", fold.record.task.simulator]
    return shlex.join(words)
