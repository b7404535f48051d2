"""Learns a task: runs one study for each step of its plan. Studies are kept in a folder or in memory."""

from __future__ import annotations

import shutil
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

import tomli_w

from tatamu.base.errors import InputError, TatamuError
from tatamu.base.version import __version__
from tatamu.evaluation import Evaluator
from tatamu.evaluation.disturbances import NOMINAL, Disturbances, default_disturbances, disturbed_scene, mean_world
from tatamu.folding.advice import UncarriedWarning, advice
from tatamu.folding.parameters import first_curves, later_curves, robust_curves, search_space, transfer
from tatamu.folding.task import Task, digest
from tatamu.garments.garmentfile import files_of
from tatamu.search import HIGH, Parameters, Schedule
from tatamu.simulation.material import is_preset
from tatamu.simulation.side_by_side import executor_of
from tatamu.study.folder import ResultFolder, locked
from tatamu.study.inputs import Sources, keep_inputs
from tatamu.study.loop import Progress, Study
from tatamu.study.options import LearnOptions
from tatamu.study.plan import PlanResult
from tatamu.study.reachable import check_reach
from tatamu.study.record import Crossings, ResultRecord, StudyRecord
from tatamu.study.result import Result
from tatamu.study.setup import check_pending, make_evaluator, make_record, make_schedule, make_search, resolve

if TYPE_CHECKING:
    from tatamu.study.database import SharedDatabase


@dataclass(frozen=True)
class Places:
    """The executor, the storage and the callbacks of a study."""

    out: Path | None = None
    """Folder of the result; None if the result is only kept in memory."""
    executor: Executor | None = None
    """Executor that runs the trials; None to run them in threads on all processors."""
    database: SharedDatabase | None = None
    """Database in which the studies are stored; None to store each study in the file `study.db` of its folder."""
    progress: Callable[[Progress], object] = field(default=lambda _: None)
    """Function that receives the progress of a study.

    It is called when the study is opened, after every trial, and when another stage starts.
    """
    written: Callable[[Result | PlanResult], object] = field(default=lambda _: None)
    """Function that is called after the folder of a result is written. It can write the page of the result."""

    def step(self, number: int) -> Places:
        """Return the executor, storage and callbacks for a step of a plan, counted from 0."""
        return self if self.out is None else replace(self, out=ResultFolder(self.out).step(number).path)

    @property
    def folder(self) -> ResultFolder | None:
        """Folder of the result; None if the result is only kept in memory."""
        return None if self.out is None else ResultFolder(self.out)


def learn(
    task: Task,
    options: LearnOptions | None = None,
    places: Places | None = None,
    evaluate: Evaluator | None = None,
    first: Sequence[Parameters] = (),
) -> Result | PlanResult:
    """Learn a task, or resume a study that was interrupted.

    If `task` is the first of several steps of a plan, all steps are learned. Each step starts from the final state of
    the previous step. Its search starts with the best folds of the earlier steps. If no hand carries a part of the
    cloth, an `UncarriedWarning` describes the part.

    Args:
        task: The fold, the garment and the simulator.
        options: Options of the study; None for the defaults.
        places: The executor, the storage and the callbacks of the study; None for this machine and storage in memory.
        evaluate: Evaluator of the manipulations; None for the evaluator that follows from the options.
        first: Parameters of further manipulations with which the search of the first step starts. If the search also
            uses a coarse mesh, the third trial on the fine mesh is the last of these manipulations.

    Raises:
        InputError: If an option is wrong, or the folder cannot be used.
        UnavailableError: If workers, the database or the disk fail. Finished trials are kept.
        TatamuError: If every trial failed.
        KeyboardInterrupt: If the user interrupts the study. Finished trials are written first.
    """
    from tatamu.study.store import load_settings  # this import takes half a second

    options = options or LearnOptions()
    if evaluate is not None:  # an evaluator that the user gives defines its own disturbances
        options = options.model_copy(update={"disturbances": "none", "quantile": None})
    places = places or Places()
    check_pending(options, task.simulator)
    steps = len(task.plan.steps) - task.number
    folder = places.folder
    if folder is not None:
        _refuse_other(folder, steps)
    for line in advice(task.garment, task.plan, task.hands):
        warnings.warn(line, UncarriedWarning, stacklevel=3)
    several = steps > 1 and task.number == 0
    held = load_settings(folder.step(0) if folder and several else folder, places.database)
    options = resolve(options, task, held)
    if isinstance(options.disturbances, Disturbances) and not task.fingers.thickness:
        task = replace(task, fingers=options.disturbances.fingers)
    if held is None:
        check_reach(task)
    study = _Learning(options, evaluate, places, tuple(first))
    if not several:
        return study.step(task, places, study.first(task))
    with locked(folder) if folder else nullcontext():
        return study.plan(task)


@dataclass(frozen=True)
class _Learning:
    """Learns the steps of one task."""

    options: LearnOptions
    """The options, with all defaults replaced by values."""
    evaluate: Evaluator | None
    places: Places
    """The executor, storage and callbacks of the whole plan."""
    known: tuple[Parameters, ...] = ()
    """Parameters of further manipulations with which the search of the first step starts.

    If the search also uses a coarse mesh, the third trial on the fine mesh is the last of these manipulations.
    """

    def first(self, task: Task) -> list[Parameters]:
        """Return the parameters of the first trials in the search for a plan's first step."""
        if self.options.sampler != "gp":
            return list(self.known)
        given = first_curves if self.options.disturbances == "none" else robust_curves
        return [*given(task.fold), *self.known]

    def plan(self, task: Task) -> PlanResult:
        """Learn every step of a plan."""
        results: list[Result] = []
        try:
            for number in range(len(task.plan.steps)):
                here = task if number == 0 else task.at(number, results[-1].final)
                places = self.places.step(number)
                _delete_outdated_step(here, places.folder, self.places.database)
                results.append(self.step(here, places, self._first_of_step(here, results)))
        except KeyboardInterrupt:
            if self.places.folder is not None:
                results = [Result.load(step.path) for step in self.places.folder.learned_steps()]
                if results:
                    self._whole(task, results)
            raise
        return self._whole(task, results)

    def _first_of_step(self, task: Task, results: Sequence[Result]) -> list[Parameters]:
        """Return the parameters of the first trials in the search for a step of a plan.

        For later steps, they include the best parameters of the earlier steps, adapted to this step.
        """
        if not results:
            return self.first(task)
        grasps = self.options.grasps
        found = [transfer(each.best.parameters, each.task.fold, task.fold, grasps) for each in results]
        return [*later_curves(task.fold), *found]

    def _whole(self, task: Task, results: Sequence[Result]) -> PlanResult:
        """Return the joined result of all steps. Write the files of the whole plan that are missing."""
        whole = PlanResult.of(task, results, self.places.out)
        folder = self.places.folder
        if folder is None:
            return whole
        if not (folder.matches(whole.record) and folder.rollout_file.exists() and folder.report_file.exists()):
            whole.write_whole(folder.path)
            self.places.written(whole)
        return whole

    def step(self, task: Task, places: Places, first: Sequence[Parameters]) -> Result:
        """Learn one step.

        Args:
            task: The step to learn.
            places: The executor, storage and callbacks of the step.
            first: Parameters with which the search starts.
        """
        from tatamu.study.store import held_store

        evaluator = make_evaluator(task, self.options) if self.evaluate is None else self.evaluate.on(task)
        record = make_record(task, self.options, evaluator, first)
        space = search_space(task.fold, self.options.grasps)
        if not evaluator.contains_length:
            space = replace(space, known_part=None)
        schedule = make_schedule(task, record, self.options, evaluator.fidelities)
        folder = places.folder
        with (
            locked(folder) if folder else nullcontext(),
            held_store(folder, places.database, record) as store,
            executor_of(places.executor, record.parallel) as executor,
        ):
            if task.reach is not None:
                task.reach.forget()
            study = Study(evaluator, make_search(record, space, evaluator.fidelities), store, record, executor)
            done = len(study.trials)
            if done > schedule.most:
                where = folder.path if folder else "the study"
                raise InputError(
                    f"trials: {where} has {done} trials already, given {schedule.most}; give {done} or more"
                )
            if self.places.out is not None:
                keep_inputs(self.places.out, _sources(task, self.options))
            return self._run(study, schedule, places)

    def _run(self, study: Study, schedule: Schedule, places: Places) -> Result:
        """Run the remaining trials of a study, write its result folder, and return its result."""
        baselines = self.options.baselines
        folder = places.folder
        if study.is_over(schedule) and folder and folder.complete and not (baselines and study.baselines is None):
            return replace(Result.load(folder.path), made_from=study.evaluator.task)
        if folder is not None:
            folder.report_file.unlink(missing_ok=True)  # a report shows that the folder is complete
        try:
            places.progress(study.progress(schedule.most))
            for stage in study.run(schedule, baselines):
                places.progress(study.progress(schedule.most, stage))
            return self._finish(study, schedule, places)
        except KeyboardInterrupt:
            if study.succeeded and folder is not None:
                self._finish(study, schedule, places)
            raise

    def _finish(self, study: Study, schedule: Schedule, places: Places) -> Result:
        """Return the result of a study whose trials have run, and write its result folder."""
        folder, task = places.folder, study.evaluator.task
        best = study.best() if study.succeeded else None
        rollout = None if best is None else study.evaluation(best).rollout
        judged = None
        if best is not None and isinstance(self.options.disturbances, Disturbances):
            places.progress(study.progress(schedule.most, "validation"))
            judged = study.validate(self.options.disturbances, study.trials[best].parameters)
        record = ResultRecord(
            **{name: getattr(study.record, name) for name in StudyRecord.model_fields},
            tatamu=__version__,
            until_gain=schedule.until_gain,
            bounds={name: [each.low, each.high] for name, each in study.space.bounds.items()},
            judged=judged,
            asked=task.asked,
            wall_seconds=round(sum(trial.seconds or 0.0 for trial in study.trials), 3),
            best=best,
            crossings=None if rollout is None else Crossings.of(rollout),
            trials=study.trials,
            baselines=study.baselines or [],
        )
        if folder is not None:
            folder.write_record(record)
        if best is None or rollout is None:
            raise TatamuError(_all_failed(study, folder))
        manipulation = task.manipulation(study.trials[best].parameters)
        shown = replace(rollout, extra={"target": task.fold.target, **study.moments()})
        given = self.options.disturbances
        centre = mean_world(given) if isinstance(given, Disturbances) else NOMINAL
        scene = disturbed_scene(task.fold, manipulation, centre)
        result = Result(record, manipulation, scene, shown, places.out, task)
        if folder is not None:
            places.progress(study.progress(schedule.most, "report"))
            folder.write_best(result.manipulation, result.scene, result.rollout)
            places.written(result)
        return result


def _all_failed(study: Study, folder: ResultFolder | None) -> str:
    fine = [trial for trial in study.trials if trial.proposal(study.record.coarse).fidelity == HIGH]
    where = "" if len(fine) == len(study.trials) else " on the garment's own mesh"
    failed = fine or study.trials
    path = f"{folder.path}: " if folder else ""
    return f"{path}all {len(failed)} trials{where} failed; last error: {failed[-1].error}"


def _sources(task: Task, options: LearnOptions) -> dict[str, Sources]:
    """Return the user's files from which a task was made.

    A plan that was proposed for the user's own garment is included.
    """
    asked = task.asked
    if asked is None:
        return {}
    found = {}
    if task.garment.own:
        found["garment"] = Sources(files_of(Path(asked.garment)))
        found["fold"] = Sources(text=task.plan.to_toml(), name=f"{task.plan.name}.toml")
    if asked.fold.endswith(".toml"):
        found["fold"] = Sources([Path(asked.fold)])
    if asked.material and not is_preset(Path(asked.material)):
        found["material"] = Sources([Path(asked.material)])
    if task.reach and task.reach.files:
        found["robot"] = Sources(task.reach.files)
    if isinstance(options.disturbances, Disturbances) and options.disturbances != default_disturbances():
        text = tomli_w.dumps(options.disturbances.describe())
        found["disturbances"] = Sources(text=text, name="disturbances.toml")
    return found


def _refuse_other(folder: ResultFolder, count: int) -> None:
    """Raise an error if the same folder would contain the study of a single step and a plan with several steps."""
    if count == 1 and folder.holds_plan:
        raise InputError(f"{folder.path}: holds a plan of several steps; give another folder")
    if count > 1 and (folder.study_file.exists() or folder.shared_study_file.exists()):
        raise InputError(f"{folder.path}: holds the study of a single fold; give another folder")


def _delete_outdated_step(task: Task, folder: ResultFolder | None, database: SharedDatabase | None) -> None:
    """Delete the study of a step if the previous step now ends in another state.

    This happens if a plan is resumed with more trials. A better first fold then changes the task of the second step.
    """
    from tatamu.study.store import load_settings

    held = load_settings(folder, database)
    if folder is not None and held is not None and task.number > 0 and held.task.start != digest(task.fold.start):
        shutil.rmtree(folder.path)
