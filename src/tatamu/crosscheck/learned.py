"""A learned fold with its task, made again from what its folder says."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.errors import InputError
from tatamu.files import read_json, validated
from tatamu.folding.score import Score, score
from tatamu.folding.task import Task, make_job
from tatamu.material import Material
from tatamu.report.fold import LearnedFold, read_fold

SAME = 1e-6
"""A target made again may be this far from the one in the folder [m]: another version may differ in bits."""


@dataclass(frozen=True)
class Learned:
    """A result folder, and the task whose best manipulation it holds."""

    fold: LearnedFold
    task: Task

    @property
    def name(self) -> str:
        """What was folded how: "towel, half"."""
        return f"{self.fold.result.task.garment}, {self.fold.result.task.fold}"

    @property
    def simulator(self) -> str:
        """Where it was learned."""
        return self.fold.result.task.simulator

    @property
    def score(self) -> Score:
        """How good the fold was where it was learned."""
        return self.scored(self.fold.final)

    def scored(self, outcome: np.ndarray) -> Score:
        """How good another outcome of the same manipulation is, positions of shape (n, 3) [m]."""
        way = self.fold.result.best_trial.trajectory_length
        assert way is not None, "the best trial is complete"
        return score(self.task.fold, way, outcome)


def read_learned(folder: Path) -> Learned:
    """Read a result folder and make its task again.

    Raises:
        InputError: The folder holds no learned fold, or a plan of several steps, or one that cannot be made again.
    """
    if (folder / "step-1").is_dir():
        raise InputError(f"{folder}: holds a plan of several steps; name one of them, such as {folder / 'step-1'}")
    fold = read_fold(folder)
    result = read_json(folder / "result.json")
    task = _task(folder, result["task"], result.get("asked") or {}, fold.start)
    _check_target(folder, fold, task)
    return Learned(fold, task)


def _task(folder: Path, told: dict[str, Any], asked: dict[str, Any], start: np.ndarray) -> Task:
    """The task as `result.json` tells it, of cloth that lies as it lay; files are looked for where they were."""
    named = {**told, **asked}
    job = make_job(
        named["garment"],
        size=tuple(named["size"]) if named.get("size") else None,
        scale=named.get("scale"),
        fold=named["fold"],
        material=validated(Material, told["material"], folder / "result.json"),
        spacing=named.get("spacing"),
        simulator=told["simulator"],
        hands=named.get("hands"),
    )
    number = told.get("step", [1])[0] - 1
    return job.task(number, start if number else None)


def _check_target(folder: Path, fold: LearnedFold, task: Task) -> None:
    target = task.fold.target
    if target.shape != fold.target.shape or not np.abs(target - fold.target).max() < SAME:
        raise InputError(f"{folder}: its task makes another target today than when it was learned; learn it again")
