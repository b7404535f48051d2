"""The result of learning one fold, in memory: the study, and the best manipulation with its scene and rollout."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field, replace
from functools import cached_property
from importlib import import_module
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError
from tatamu.evaluation.disturbances import Disturbances, default_disturbances
from tatamu.evaluation.success import Success
from tatamu.folding.aim import Aim
from tatamu.folding.manipulation import ArmPath, Manipulation, ManipulationFile
from tatamu.folding.score import MEASURES, Score, score, vertex_distances
from tatamu.folding.task import Task, TaskOptions, make_task
from tatamu.garments import make_garment
from tatamu.simulation.mesh.topology import facing_down
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.study.folder import ResultFolder
from tatamu.study.inputs import kept_input
from tatamu.study.record import ResultRecord, TaskDescription
from tatamu.study.trial import Trial

MOMENTS = {
    "error_first": (1, "First trial"),
    "error_10": (10, "Best after 10"),
    "error_50": (50, "Best after 50"),
}
"""Arrays of `rollout.npz` with the vertex distances e_i of the best of the first trials [m], shape (n,): so many
trials, and a title."""
FAILED = "failed: "
"""Beginning of the names of arrays of `rollout.npz` that show where the cloth ends in a fold that fails by a cause."""
PAGES = "tatamu.report"
"""Room of the pages, which stands above this one and is imported when a page is asked for."""


@dataclass(frozen=True, eq=False)
class Result:
    """A learned fold."""

    record: ResultRecord
    manipulation: Manipulation
    scene: Scene
    rollout: Rollout
    """Motion without disturbances, with the target and the distances of earlier trials in `extra`."""
    folder: Path | None = None
    """None if the result is only in memory."""
    made_from: Task | None = field(default=None, repr=False)
    """The task, if the fold was learned in this process; None if it must be made again from the record."""

    @property
    def best(self) -> Trial:
        return self.record.best_trial

    @property
    def success(self) -> Success | None:
        """How often the fold succeeds in scenarios that were not used to learn it; None without disturbances."""
        return self.record.success

    @property
    def held(self) -> Success | None:
        """Former name of `success`."""
        warnings.warn("Result.held is deprecated: use Result.success", FutureWarning, stacklevel=2)
        return self.success

    @property
    def disturbances(self) -> Disturbances:
        """The disturbances with which the fold was learned; the default ones if it was learned without."""
        kept = self.record.disturbances
        return default_disturbances() if kept is None else Disturbances.model_validate(kept)

    @property
    def trials(self) -> list[Trial]:
        return self.record.trials

    def table(self) -> dict[str, list[object]]:
        """Return the trials as columns for `pandas.DataFrame`: parameters, measures and state."""
        names = list(self.best.parameters)
        columns: dict[str, list[object]] = {"number": [trial.number for trial in self.trials]}
        columns |= {name: [trial.parameters[name] for trial in self.trials] for name in names}
        columns["minimised"] = [trial.minimised for trial in self.trials]
        for name in MEASURES:
            columns[name] = [getattr(trial.score, name, None) for trial in self.trials]
        columns["state"] = [trial.state for trial in self.trials]
        columns["scenarios"] = [trial.scenarios.simulated if trial.scenarios else 0 for trial in self.trials]
        columns["seconds"] = [trial.seconds for trial in self.trials]
        return columns

    @property
    def start(self) -> np.ndarray:
        """The cloth before the fold [m], shape (n, 3)."""
        return self.rollout.positions[0]

    @property
    def final(self) -> np.ndarray:
        """The cloth after the fold [m], shape (n, 3)."""
        return self.rollout.positions[-1]

    @property
    def target(self) -> np.ndarray:
        """Position of each vertex after a perfect fold [m], shape (n, 3)."""
        return self.rollout.extra["target"]

    @property
    def faces(self) -> np.ndarray:
        """Triangles of the mesh, shape (m, 3)."""
        return self.rollout.faces

    @property
    def lower(self) -> np.ndarray:
        """Whether each triangle belongs to the lower layer, the back of a garment of two layers, shape (m,)."""
        return facing_down(self.scene.cloth.rest, self.faces)

    @property
    def errors(self) -> np.ndarray:
        """Distances e_i of Eq. (12) from the targets [m], shape (n,)."""
        return vertex_distances(self.target, self.final)

    @property
    def failures(self) -> dict[str, np.ndarray]:
        """Where the cloth ends in one fold that fails by each cause [m], shape (n, 3)."""
        causes, kept = self.success.causes if self.success else (), self.rollout.extra
        return {cause: kept[FAILED + cause] for cause in causes if FAILED + cause in kept}

    @property
    def moments(self) -> list[tuple[str, np.ndarray]]:
        """Title and distances e_i [m], shape (n,), of the best trial at several moments, and of the learned fold."""
        known = {name: moment for name, moment in MOMENTS.items() if name in self.rollout.extra}
        titled = [(title, self.rollout.extra[name]) for name, (_, title) in known.items()]
        count = len(self.trials)
        ended = count in [after for after, _ in known.values()]
        return titled if ended else [*titled, (f"Best of all {count}", self.errors)]

    @cached_property
    def arms(self) -> list[ArmPath]:
        """The paths of the arms, left before right."""
        return self.description.arms

    @cached_property
    def description(self) -> ManipulationFile:
        """The content of `manipulation.json`."""
        return self.manipulation.describe()

    def hand(self, arm: ArmPath) -> np.ndarray:
        """Return the positions of a hand in each of the f frames [m], shape (f, 3)."""
        gripper = next((each for each in self.scene.grippers if each.hand == arm.name), None)  # moves like the hand
        if gripper is None:
            raise InputError(
                f"{self.folder or 'scene'}: grippers: must contain the gripper of the {arm.name} hand; "
                "learn the fold again"
            )
        return np.array(arm.grasp.position) + gripper.path(self.rollout.times)

    @property
    def name(self) -> str:
        """Names of garment and fold, for example "towel, half"."""
        return f"{self.record.task.garment}, {self.record.task.fold}"

    @property
    def simulator(self) -> str:
        return self.record.task.simulator

    @cached_property
    def task(self) -> Task:
        """The task that was learned, made again from the record if the result was loaded.

        Raises:
            InputError: If the task cannot be made again, or this version computes another target for it.
        """
        if self.made_from is not None:
            return self.made_from
        task = _make_task(self.record, self.folder, self.start)
        target = task.fold.target
        if target.shape != self.target.shape or not np.abs(target - self.target).max() < 1e-6:  # rounding errors
            raise InputError(
                f"{self.folder}: the target of the task has changed since the fold was learned; learn the fold again"
            )
        return task

    @property
    def score(self) -> Score:
        return self.rate(self.final)

    def rate(self, final: np.ndarray) -> Score:
        """Return the score of cloth that ends at other positions [m], shape (n, 3), after the same motion."""
        return score(self.task.fold, self.manipulation.trajectory_length, final)

    def save(self, folder: Path | str) -> ResultFolder:
        """Write `result.json`, `manipulation.json`, `scene.json` and `rollout.npz`.

        Raises:
            InputError: If the folder cannot be written.
        """
        kept = ResultFolder(Path(folder))
        kept.write_record(self.record)
        kept.write_best(self.manipulation, self.scene, self.rollout)
        return kept

    def write_report(self, file: Path | str | None = None) -> Path:
        """Write the page of the fold, by default `report.html` in its folder, and return its path.

        Raises:
            InputError: If the file cannot be written, or no file is given and the fold has no folder.
        """
        return Path(import_module(PAGES).write_report(self, None if file is None else Path(file)))

    def _repr_html_(self) -> str:
        return str(import_module(PAGES).embedded(self))

    def __repr__(self) -> str:
        sure = f", {self.success.headline}" if self.success else ""
        distance = 1e3 * self.record.best_score.mean_vertex_distance
        return f"Result({self.name}: {distance:.1f} mm from the target, {len(self.trials)} trials{sure})"

    @classmethod
    def load(cls, path: Path | str) -> Result:
        """Read the folder of a learned fold.

        Raises:
            InputError: If a file is missing, damaged, of another version, or does not fit the other files.
        """
        folder = ResultFolder(Path(path))
        if folder.holds_plan:
            raise InputError(
                f"{path}: contains a plan of several steps; give the folder of one step, such as {folder.step(0).path}"
            )
        if folder.record.best is None:
            raise InputError(f"{path}: must contain a learned fold, but all trials failed")
        result = cls(folder.record, folder.manipulation, folder.scene, folder.rollout, Path(path))
        _check_arrays(folder)
        return result


def _make_task(record: ResultRecord, folder: Path | None, start: np.ndarray) -> Task:
    """Return the task of a study. A user's own garment and plan are read from the copies in the folder."""
    description, asked = record.task, record.asked
    named: TaskOptions | TaskDescription = asked or description
    kept = {kind: kept_input(folder, kind) if folder else None for kind in ("garment", "fold")}
    garment, size = str(kept["garment"] or named.garment), (named.size[0], named.size[1]) if named.size else None
    scale = asked.scale if asked else None
    task = make_task(
        garment,
        size=size,
        fold=str(kept["fold"] or named.fold),
        material=description.material,
        spacing=named.spacing,
        scale=scale,
        simulator=description.simulator,
        hands=asked.hands if asked else 1 if description.hands == 1 else None,
        fingers=description.fingers,
    )
    if description.vertices not in (None, len(task.garment.vertices)):  # version 0.2 ended on the garment's own mesh
        own = make_garment(garment, size, description.material, named.spacing, scale)
        task = replace(task, garment=own, softening=1.0)
    task = replace(task, shift=tuple(description.shift or ()), aim=record.aim or Aim())
    number, _ = description.step or (1, 1)
    return task.at(number - 1, start if number > 1 else None)


def _check_arrays(folder: ResultFolder) -> None:
    """Check that the rollout fits the scene, that times increase, and that faces contain existing vertices."""
    rollout, file = folder.rollout, folder.rollout_file
    if "target" not in rollout.extra:
        raise InputError(f"{file}: must contain the array target, with the positions (n, 3) after a perfect fold")
    times, faces, count = rollout.times, rollout.faces, len(folder.scene.cloth.vertices)
    arrays = {
        "positions": (rollout.positions, (len(times), count, 3)),
        "target": (rollout.extra["target"], (count, 3)),
        **{name: (rollout.extra[name], (count,)) for name in MOMENTS if name in rollout.extra},
        **{name: (ends, (count, 3)) for name, ends in rollout.extra.items() if name.startswith(FAILED)},
    }
    for name, (array, shape) in arrays.items():
        if array.shape != shape or not len(times):
            raise InputError(f"{file}: {name} must have shape {shape} to fit scene.json, given {array.shape}")
        if array.dtype.kind != "f" or not np.isfinite(array).all():
            raise InputError(f"{file}: {name} must be finite numbers in metres")
    if times.ndim != 1 or not (np.diff(times) > 0).all() or not np.isfinite(times).all():
        raise InputError(f"{file}: times must increase from frame to frame")
    if faces.ndim != 2 or faces.shape[1] != 3 or faces.dtype.kind not in "iu" or not len(faces):
        raise InputError(f"{file}: faces must be integers of shape (m, 3), given {faces.dtype} of shape {faces.shape}")
    if faces.min() < 0 or faces.max() >= count:
        raise InputError(f"{file}: faces must be vertex indices from 0 to {count - 1}")
