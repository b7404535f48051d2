"""The folder of a learned fold or plan: names, reading and writing of its files (docs/reference/result-folder.md)."""

from __future__ import annotations

import os
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.base.files import lock_folder, write_json
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
LEARNED = (RESULT, MANIPULATION, SCENE, ROLLOUT, REPORT)
"""Names of all files in the folder of a study, except the database."""
STEP = "step-"


def step_name(number: int) -> str:
    """Return the folder name of a step, such as "step-1" for the step with the index 0."""
    return f"{STEP}{number + 1}"


class _Place:
    """A file or folder in a `ResultFolder`, by its name."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __get__(self, folder: ResultFolder, owner: type[ResultFolder]) -> Path:
        return folder.path / self.name


@dataclass(frozen=True)
class ResultFolder:
    """A folder of a learned fold or plan.

    Files are read and validated when they are first used, once, and written as a whole or not at all. Errors name the
    file and the field.
    """

    path: Path

    result_file = _Place(RESULT)
    manipulation_file = _Place(MANIPULATION)
    scene_file = _Place(SCENE)
    rollout_file = _Place(ROLLOUT)
    report_file = _Place(REPORT)
    study_file = _Place("study.db")
    shared_study_file = _Place("study.json")
    margins_folder = _Place("margins")
    margins_file = _Place("margins/margins.json")

    @property
    def margins(self) -> MarginsRecord | None:
        """The margins; None if they were not measured."""
        return MarginsRecord.load(self.margins_file) if self.margins_file.exists() else None

    def write_margins(self, margins: MarginsRecord, out: Path) -> None:
        write_json(out / self.margins_file.name, margins.model_dump())

    def step(self, number: int) -> ResultFolder:
        return ResultFolder(self.path / step_name(number))

    def learned_steps(self) -> list[ResultFolder]:
        """The folders of the plan's steps that were learned, in order."""
        folders = [file.parent for file in self.path.glob(f"{STEP}*/{MANIPULATION}")]
        return [ResultFolder(path) for path in sorted(folders, key=lambda path: (len(path.name), path.name))]

    @property
    def holds_plan(self) -> bool:
        """Whether a plan with several steps was started here."""
        return os.path.exists(self.path / step_name(0))

    @property
    def shared_study(self) -> SharedStudyRecord | None:
        """The place of the study in a shared database; None if it is not in one."""
        return SharedStudyRecord.load(self.shared_study_file) if os.path.exists(self.shared_study_file) else None

    @property
    def has_study(self) -> bool:
        """Whether a study or a plan was started here."""
        return os.path.exists(self.study_file) or os.path.exists(self.shared_study_file) or self.holds_plan

    @property
    def complete(self) -> bool:
        """Whether all files of a finished study exist."""
        return all((self.path / name).exists() for name in LEARNED)

    @cached_property
    def record(self) -> ResultRecord:
        """The study and its trials."""
        return ResultRecord.load(self.result_file)

    @cached_property
    def plan_record(self) -> PlanRecord:
        """The learned plan with several steps."""
        return PlanRecord.load(self.result_file)

    @cached_property
    def manipulation(self) -> Manipulation:
        return Manipulation.load(self.manipulation_file)

    @cached_property
    def scene(self) -> Scene:
        return Scene.load(self.scene_file)

    @cached_property
    def rollout(self) -> Rollout:
        """The motion of the cloth in the best trial, or in all steps of a plan, with the target in `extra`."""
        return Rollout.load(self.rollout_file)

    def write_record(self, result: ResultRecord | PlanRecord) -> None:
        write_json(self.result_file, result.model_dump())

    def write_best(self, manipulation: Manipulation, scene: Scene, rollout: Rollout) -> None:
        """Write the files of the best trial. The rollout has the `target` and the arrays of `result.MOMENTS`."""
        manipulation.save(self.manipulation_file)
        scene.save(self.scene_file)
        rollout.save(self.rollout_file)


def locked(folder: ResultFolder) -> AbstractContextManager[object]:
    """Return a lock on the folder of a study, so that only one run writes there. It ends with the process.

    Raises:
        InputError: If the folder cannot be written, is used by another run, or contains other files.
    """
    path = folder.path
    foreign = [name for name in LEARNED if os.path.exists(path / name)]
    if foreign and not folder.has_study:
        raise InputError(
            f"{path}: contains {foreign[0]} but no study, so learning would overwrite this file; give another folder"
        )
    return lock_folder(path, ".lock", "another run is learning here")
