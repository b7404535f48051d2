"""The folder of a learned fold, or of a plan of several: the names of its files, reading and writing them.

docs/reference/result-folder.md describes every file.
"""

from __future__ import annotations

import os
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tatamu.errors import InputError
from tatamu.files import read_json, validated, write_json
from tatamu.folding.manipulation import Manipulation
from tatamu.locks import lock_folder
from tatamu.robustness import MarginsResult
from tatamu.rollout import Rollout
from tatamu.scene import Scene
from tatamu.study.plan_record import PlanRecord
from tatamu.study.record import ResultRecord, SharedStudyRecord

RESULT = "result.json"
MANIPULATION = "manipulation.json"
SCENE = "scene.json"
ROLLOUT = "rollout.npz"
REPORT = "report.html"
STUDY = "study.db"
SHARED_STUDY = "study.json"
MARGINS = "margins"
"""Name of the folder with the margins of the fold."""

LEARNED = (RESULT, MANIPULATION, SCENE, ROLLOUT, REPORT)
"""All files of a study except its database."""
STEP = "step-"
"""Prefix of the names of the folders of a plan's steps."""


def step_name(number: int) -> str:
    """The folder of a step of a plan, the first being 0."""
    return f"{STEP}{number + 1}"


@dataclass(frozen=True)
class ResultFolder:
    """A folder whose files are read and validated at the first use, and written in one piece."""

    path: Path

    @property
    def result_file(self) -> Path:
        """The study, or the plan: `result.json`."""
        return self.path / RESULT

    @property
    def manipulation_file(self) -> Path:
        """The best trial as hands see it: `manipulation.json`."""
        return self.path / MANIPULATION

    @property
    def scene_file(self) -> Path:
        """The best trial as a scene: `scene.json`."""
        return self.path / SCENE

    @property
    def rollout_file(self) -> Path:
        """The motion of the cloth in the best trial: `rollout.npz`."""
        return self.path / ROLLOUT

    @property
    def report_file(self) -> Path:
        """The page: `report.html`."""
        return self.path / REPORT

    @property
    def study_file(self) -> Path:
        """The Optuna study: `study.db`."""
        return self.path / STUDY

    @property
    def margins_folder(self) -> Path:
        """Folder of its margins: `margins`."""
        return self.path / MARGINS

    @property
    def margins_file(self) -> Path:
        """File of its margins: `margins/margins.json`."""
        return self.margins_folder / "margins.json"

    @property
    def margins(self) -> MarginsResult | None:
        """The margins of the fold; None if they were not measured.

        Raises:
            InputError: If the file cannot be read, or a field is wrong; the message names both.
        """
        return MarginsResult.load(self.margins_file) if self.margins_file.exists() else None

    def write_margins(self, margins: MarginsResult, out: Path) -> None:
        """Write `margins.json` into a folder."""
        write_json(out / self.margins_file.name, margins.model_dump())

    def step(self, number: int) -> ResultFolder:
        """A step of a plan, the first being 0."""
        return ResultFolder(self.path / step_name(number))

    def learned_steps(self) -> list[ResultFolder]:
        """The steps of a plan that have a manipulation, in order."""
        folders = [file.parent for file in self.path.glob(f"{STEP}*/{MANIPULATION}")]
        return [ResultFolder(path) for path in sorted(folders, key=lambda path: (len(path.name), path.name))]

    @property
    def holds_plan(self) -> bool:
        """Whether a plan of several steps was started here."""
        return os.path.exists(self.path / step_name(0))

    @property
    def shared_study_file(self) -> Path:
        """File with the address of the study, if it is in a shared database: `study.json`."""
        return self.path / SHARED_STUDY

    @property
    def shared_study(self) -> SharedStudyRecord | None:
        """Location of the study in a shared database; None if there is none.

        Raises:
            InputError: If the file cannot be read, or a field is wrong; the message names both.
        """
        if not os.path.exists(self.shared_study_file):
            return None
        return validated(SharedStudyRecord, read_json(self.shared_study_file), self.shared_study_file)

    def write_shared_study(self, record: SharedStudyRecord) -> None:
        """Write `study.json`."""
        write_json(self.shared_study_file, record.model_dump())

    @property
    def has_study(self) -> bool:
        """Whether a study, or a plan of several steps, was started here."""
        return os.path.exists(self.study_file) or os.path.exists(self.shared_study_file) or self.holds_plan

    @property
    def complete(self) -> bool:
        """Whether all files of a finished study exist."""
        return all((self.path / name).exists() for name in LEARNED)

    @cached_property
    def record(self) -> ResultRecord:
        """The study and its trials.

        Raises:
            InputError: If the file cannot be read, or a field is wrong; the message names both.
        """
        return validated(ResultRecord, read_json(self.result_file), self.result_file)

    @cached_property
    def plan_record(self) -> PlanRecord:
        """The plan of several steps.

        Raises:
            InputError: If the file cannot be read, or a field is wrong; the message names both.
        """
        return validated(PlanRecord, read_json(self.result_file), self.result_file)

    @cached_property
    def manipulation(self) -> Manipulation:
        """The best manipulation.

        Raises:
            InputError: If the file cannot be read, or a field is wrong; the message names both.
        """
        return Manipulation.load(self.manipulation_file)

    @cached_property
    def scene(self) -> Scene:
        """The best trial as a scene.

        Raises:
            InputError: If the file cannot be read, or a field is wrong; the message names both.
        """
        return Scene.load(self.scene_file)

    @cached_property
    def rollout(self) -> Rollout:
        """The motion of the cloth in the best trial, or in all steps of a plan; `extra` has the `target`.

        Raises:
            InputError: If the file cannot be read or is not a rollout.
        """
        return Rollout.load(self.rollout_file)

    @property
    def target(self) -> np.ndarray:
        """The wanted shape [m], shape (n, 3).

        Raises:
            InputError: If the rollout cannot be read, or has no target.
        """
        if "target" not in self.rollout.extra:
            raise InputError(f"{self.rollout_file}: target is missing, the wanted shape (n, 3) of a learned fold")
        return self.rollout.extra["target"]

    def matches(self, result: ResultRecord | PlanRecord) -> bool:
        """Return whether `result.json` exists with exactly this content."""
        return self.result_file.exists() and read_json(self.result_file) == result.model_dump()

    def write_record(self, result: ResultRecord | PlanRecord) -> None:
        """Write `result.json`."""
        write_json(self.result_file, result.model_dump())
        self._forget("record", "plan_record")

    def write_best(self, manipulation: Manipulation, scene: Scene, rollout: Rollout) -> None:
        """Write `manipulation.json`, `scene.json` and `rollout.npz` of the best trial.

        Args:
            manipulation: The best manipulation.
            scene: The best trial as a scene.
            rollout: Its rollout; `extra` has the `target` and e_i of earlier trials (`result.MOMENTS`).
        """
        manipulation.save(self.manipulation_file)
        scene.save(self.scene_file)
        self.write_rollout(rollout)
        self._forget("manipulation", "scene")

    def write_rollout(self, rollout: Rollout) -> None:
        """Write `rollout.npz`."""
        rollout.save(self.rollout_file)
        self._forget("rollout")

    def _forget(self, *names: str) -> None:
        """Read a file again at its next use."""
        for name in names:
            self.__dict__.pop(name, None)


def locked(folder: ResultFolder) -> AbstractContextManager[object]:
    """Return a lock on a folder that ends with the process, however it ends.

    Raises:
        InputError: If the folder cannot be written, another run uses it, or it contains other files.
    """
    path = folder.path
    foreign = [name for name in LEARNED if os.path.exists(path / name)]
    if foreign and not folder.has_study:
        raise InputError(f"{path}: contains {foreign[0]} but no study; it would be overwritten, give another folder")
    return lock_folder(path, ".lock", "another run is learning here")
