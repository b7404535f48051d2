"""The folder of a learned fold, or of a learned plan with several steps: names of its files, reading and writing.

Every file is described in docs/reference/result-folder.md.
"""

from __future__ import annotations

import os
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import read_json, validated, write_json
from tatamu.base.locks import lock_folder
from tatamu.evaluation.success import MarginsRecord
from tatamu.folding.manipulation import Manipulation
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.study.record import PlanRecord, ResultRecord, SharedStudyRecord

RESULT = "result.json"
MANIPULATION = "manipulation.json"
SCENE = "scene.json"
ROLLOUT = "rollout.npz"
REPORT = "report.html"
STUDY = "study.db"
SHARED_STUDY = "study.json"
MARGINS = "margins"
"""Name of the folder that contains the margins of the fold: the errors that the fold tolerates."""

LEARNED = (RESULT, MANIPULATION, SCENE, ROLLOUT, REPORT)
"""Names of all files in the folder of a study, except the database."""
STEP = "step-"
"""Beginning of the folder names of a plan's steps, such as "step-1"."""


def step_name(number: int) -> str:
    """Return the folder name of a step of a plan, such as "step-1" for the first step, whose `number` is 0."""
    return f"{STEP}{number + 1}"


@dataclass(frozen=True)
class ResultFolder:
    """A folder of a learned fold.

    Files are read and validated when they are first used. They are written as a whole or not at all.
    """

    path: Path

    @property
    def result_file(self) -> Path:
        """Path of `result.json`, which describes the study or the plan."""
        return self.path / RESULT

    @property
    def manipulation_file(self) -> Path:
        """Path of `manipulation.json`, which describes the motion of the hands in the best trial."""
        return self.path / MANIPULATION

    @property
    def scene_file(self) -> Path:
        """Path of `scene.json`, which describes the best trial as a scene."""
        return self.path / SCENE

    @property
    def rollout_file(self) -> Path:
        """Path of `rollout.npz`, which contains the motion of the cloth in the best trial."""
        return self.path / ROLLOUT

    @property
    def report_file(self) -> Path:
        """Path of the page `report.html`."""
        return self.path / REPORT

    @property
    def study_file(self) -> Path:
        """Path of the Optuna study `study.db`."""
        return self.path / STUDY

    @property
    def margins_folder(self) -> Path:
        """Path of the folder `margins`, which contains the margins of the fold."""
        return self.path / MARGINS

    @property
    def margins_file(self) -> Path:
        """Path of `margins/margins.json`, which contains the margins of the fold."""
        return self.margins_folder / "margins.json"

    @property
    def margins(self) -> MarginsRecord | None:
        """The margins of the fold: the errors that it tolerates; None if they were not measured.

        Raises:
            InputError: If the file cannot be read, or a field is wrong. The message names the file and the field.
        """
        return MarginsRecord.load(self.margins_file) if self.margins_file.exists() else None

    def write_margins(self, margins: MarginsRecord, out: Path) -> None:
        """Write `margins.json` into a folder."""
        write_json(out / self.margins_file.name, margins.model_dump())

    def step(self, number: int) -> ResultFolder:
        """Return the folder of a step of a plan. Steps are counted from 0."""
        return ResultFolder(self.path / step_name(number))

    def learned_steps(self) -> list[ResultFolder]:
        """The folders of the plan's steps that were learned, in the order of the steps."""
        folders = [file.parent for file in self.path.glob(f"{STEP}*/{MANIPULATION}")]
        return [ResultFolder(path) for path in sorted(folders, key=lambda path: (len(path.name), path.name))]

    @property
    def holds_plan(self) -> bool:
        """Whether a plan with several steps was started in this folder."""
        return os.path.exists(self.path / step_name(0))

    @property
    def shared_study_file(self) -> Path:
        """Path of `study.json`, which contains the address of a study in a shared database."""
        return self.path / SHARED_STUDY

    @property
    def shared_study(self) -> SharedStudyRecord | None:
        """The address of the study in a shared database; None if the study is not in a shared database.

        Raises:
            InputError: If the file cannot be read, or a field is wrong. The message names the file and the field.
        """
        if not os.path.exists(self.shared_study_file):
            return None
        return validated(SharedStudyRecord, read_json(self.shared_study_file), self.shared_study_file)

    def write_shared_study(self, record: SharedStudyRecord) -> None:
        """Write `study.json`."""
        write_json(self.shared_study_file, record.model_dump())

    @property
    def has_study(self) -> bool:
        """Whether a study, or a plan with several steps, was started in this folder."""
        return os.path.exists(self.study_file) or os.path.exists(self.shared_study_file) or self.holds_plan

    @property
    def complete(self) -> bool:
        """Whether all files of a finished study exist."""
        return all((self.path / name).exists() for name in LEARNED)

    @cached_property
    def record(self) -> ResultRecord:
        """The study and its trials, read from `result.json`.

        Raises:
            InputError: If the file cannot be read, or a field is wrong. The message names the file and the field.
        """
        return validated(ResultRecord, read_json(self.result_file), self.result_file)

    @cached_property
    def plan_record(self) -> PlanRecord:
        """The learned plan with several steps, read from `result.json`.

        Raises:
            InputError: If the file cannot be read, or a field is wrong. The message names the file and the field.
        """
        return validated(PlanRecord, read_json(self.result_file), self.result_file)

    @cached_property
    def manipulation(self) -> Manipulation:
        """The manipulation (motion of the hands) of the best trial.

        Raises:
            InputError: If the file cannot be read, or a field is wrong. The message names the file and the field.
        """
        return Manipulation.load(self.manipulation_file)

    @cached_property
    def scene(self) -> Scene:
        """The scene in which the best trial is simulated.

        Raises:
            InputError: If the file cannot be read, or a field is wrong. The message names the file and the field.
        """
        return Scene.load(self.scene_file)

    @cached_property
    def rollout(self) -> Rollout:
        """The motion of the cloth in the best trial, or in all steps of a plan.

        The rollout's field `extra` contains the target shape.

        Raises:
            InputError: If the file cannot be read or is not a rollout.
        """
        return Rollout.load(self.rollout_file)

    @property
    def target(self) -> np.ndarray:
        """The target shape: position of each vertex after a perfect fold [m], shape (n, 3).

        Raises:
            InputError: If the rollout cannot be read or has no target.
        """
        if "target" not in self.rollout.extra:
            raise InputError(f"{self.rollout_file}: target is missing, the wanted shape (n, 3) of a learned fold")
        return self.rollout.extra["target"]

    def matches(self, result: ResultRecord | PlanRecord) -> bool:
        """Return whether `result.json` exists and contains exactly this record."""
        return self.result_file.exists() and read_json(self.result_file) == result.model_dump()

    def write_record(self, result: ResultRecord | PlanRecord) -> None:
        """Write `result.json`, the record of the study or of the plan."""
        write_json(self.result_file, result.model_dump())
        self._forget("record", "plan_record")

    def write_best(self, manipulation: Manipulation, scene: Scene, rollout: Rollout) -> None:
        """Write `manipulation.json`, `scene.json` and `rollout.npz` of the best trial.

        Args:
            manipulation: The best manipulation.
            scene: The best trial as a scene.
            rollout: Rollout of the best trial. Its field `extra` contains the `target`, and the vertex distances e_i of
                earlier trials under the names in `result.MOMENTS`.
        """
        manipulation.save(self.manipulation_file)
        scene.save(self.scene_file)
        self.write_rollout(rollout)
        self._forget("manipulation", "scene")

    def write_rollout(self, rollout: Rollout) -> None:
        """Write `rollout.npz`, the motion of the cloth."""
        rollout.save(self.rollout_file)
        self._forget("rollout")

    def _forget(self, *names: str) -> None:
        """Remove the contents of some files from memory, so that each of these files is read again at its next use."""
        for name in names:
            self.__dict__.pop(name, None)


def locked(folder: ResultFolder) -> AbstractContextManager[object]:
    """Return a lock on the folder of a study, so that only one run writes there. The lock ends with the process.

    It ends even if the process crashes.

    Raises:
        InputError: If the folder cannot be written, is used by another run, or contains other files.
    """
    path = folder.path
    foreign = [name for name in LEARNED if os.path.exists(path / name)]
    if foreign and not folder.has_study:
        raise InputError(f"{path}: contains {foreign[0]} but no study; it would be overwritten, give another folder")
    return lock_folder(path, ".lock", "another run is learning here")
