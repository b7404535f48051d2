"""Makes the shell commands that repeat a learned fold."""

from __future__ import annotations

import shlex
from pathlib import Path

from tatamu.base.files import in_shell
from tatamu.study.folder import SCENE
from tatamu.study.options import TaskRequest
from tatamu.study.record import ResultRecord
from tatamu.study.result import Result


def learn(fold: Result) -> str:
    """Return the command that runs the study of a learned fold again."""
    folder = (fold.folder or Path("fold")).resolve()
    if fold.record.task.step:
        folder = folder.parent
    words = request(fold.record).words()
    return shlex.join(["tatamu", "learn", words[0], "--out", folder.name, *words[1:]])


def request(record: ResultRecord) -> TaskRequest:
    """Return the options of `tatamu learn` that give this study. Version 0.2 did not record them."""
    if record.request is not None:
        return record.request
    task = record.task
    asked = record.asked
    size = asked.size if asked else task.size
    return TaskRequest(
        garment=asked.garment if asked else task.garment,
        size="x".join(f"{side:g}" for side in size) if size else None,
        fold=asked.fold if asked else task.fold,
        hands=asked.hands if asked else task.hands,
        material=asked.material if asked else None,
        spacing=asked.spacing if asked else task.spacing,
        simulator=task.simulator,
        robot=(asked.robot if asked else None) or task.robot,
        trials=len(record.trials),
        seed=record.seed,
        disturbances="none" if record.disturbances is None else None,
    )


def simulate(fold: Result) -> str:
    """Return the command that simulates the best trial of a learned fold."""
    scene = f"{(fold.folder or Path('fold')).resolve().name}/{SCENE}"
    words = ["--out", "again.npz", "--simulator", fold.record.task.simulator]
    return f"tatamu simulate {in_shell(scene)} {shlex.join(words)}"
