"""Learns a task: one study for each step of its plan, kept in a folder or in memory."""

from __future__ import annotations

import shutil
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tatamu.base.errors import InputError, TatamuError
from tatamu.base.files import read_json
from tatamu.base.version import __version__
from tatamu.evaluation.disturbances import (
    NOMINAL,
    Disturbances,
    default_disturbances,
    disturbances_in,
    disturbed_scene,
    load_disturbances,
    mean_scenario,
    with_calibrated,
)
from tatamu.evaluation.disturbances.aim import aim_for
from tatamu.evaluation.evaluator import Evaluation, Evaluator
from tatamu.evaluation.nominal import Nominal
from tatamu.evaluation.scenarios import Scenarios
from tatamu.evaluation.success import Success
from tatamu.folding.advice import UncarriedWarning, advice
from tatamu.folding.fold import Fold
from tatamu.folding.parameters import initial_curves, later_curves, search_space, transfer
from tatamu.folding.task import Task, check_reach, digest
from tatamu.search import Parameters, Proposal, find_search
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.side_by_side import executor_of
from tatamu.simulation.simulators import SIMULATORS, capabilities
from tatamu.study.folder import ResultFolder, locked
from tatamu.study.inputs import keep_inputs, sources_of
from tatamu.study.loop import MIN_GAIN, Progress, Study, Tested, max_trials
from tatamu.study.options import USUAL_PENDING, LearnOptions, TaskRequest, parse_aim
from tatamu.study.plan import PlanResult
from tatamu.study.record import Crossings, ResultRecord, StudyRecord, describe_task
from tatamu.study.result import Result
from tatamu.study.trial import Trial

if TYPE_CHECKING:
    from tatamu.study.database import SharedDatabase


def learn(
    task: Task,
    options: LearnOptions | None = None,
    *,
    out: Path | None = None,
    evaluate: Evaluator | None = None,
    first: Sequence[Parameters] = (),
    executor: Executor | None = None,
    database: SharedDatabase | None = None,
    progress: Callable[[Progress], object] = lambda _: None,
) -> Result | PlanResult:
    """Learn a task, or resume a study that was interrupted.

    If `task` is the first of several steps of a plan, all steps are learned, each from the final state of the one
    before. An `UncarriedWarning` describes a part of the cloth that no hand carries.

    Args:
        task: The fold.
        options: Options of the study; None for the defaults.
        out: Folder of the result; None to keep it in memory.
        evaluate: Evaluator that is minimised; None for that of the options.
        first: Parameters with which the search of the first step starts, after the initial curves.
        executor: Executor of the trials; None for threads on all processors.
        database: Database of the studies; None for the file `study.db` in each folder.
        progress: Called when a study is opened, after every trial, and when another stage starts.

    Raises:
        InputError: If an option is wrong, or the folder cannot be used.
        UnavailableError: If workers, the database or the disk fail. Finished trials are kept.
        TatamuError: If every trial failed.
        KeyboardInterrupt: If the user interrupts the study. The best fold so far is written first.
    """
    from tatamu.study.store import load_settings  # this import takes half a second

    options = options or LearnOptions()
    if evaluate is not None:  # it has its own disturbances
        options = options.model_copy(update={"disturbances": "none"})
    check_pending(options, task.simulator)
    folder = None if out is None else ResultFolder(out)
    several = len(task.plan.steps) > 1 and task.number == 0
    if folder is not None:
        _refuse_other(folder, several)
    for line in advice(task.garment, task.plan, task.hands):
        warnings.warn(line, UncarriedWarning, stacklevel=3)
    held = load_settings(folder.step(0) if folder and several else folder, database)
    disturbances = _disturbances(task, options, held)
    if disturbances is not None and not task.fingers.stated:
        task = replace(task, fingers=disturbances.fingers)
    if options.aim is not None or disturbances is not None:
        aim = aim_for(disturbances, task.fingers) if disturbances and options.aim is None else None
        task = replace(task, aim=aim or parse_aim(options.aim or "none"))
    if held is None:
        check_reach(task)
    parallel = options.parallel or (held.parallel if held else usual_pending(task.simulator))
    if evaluate is None:
        evaluate = Nominal(task)
        if disturbances is not None:
            evaluate = Scenarios(Nominal(task, mean_scenario(disturbances)), disturbances, options.level)
    study = _Learning(folder, options, parallel, disturbances, evaluate, executor, database, progress)
    if not several:
        return study.step(task, folder, [*study.initial(task.fold), *first])
    with locked(folder) if folder else nullcontext():
        return study.plan(task, folder, first)


def check_pending(options: LearnOptions, simulator: str) -> None:
    """Refuse several trials at a time for a simulator that runs one.

    Raises:
        InputError: If the simulator cannot run several simulations at a time.
    """
    if options.parallel is not None and options.parallel > 1 and not capabilities(simulator).parallel:
        able = ", ".join(name for name in SIMULATORS if capabilities(name).parallel)
        raise InputError(
            f"parallel: must be 1 with {simulator}, given {options.parallel}; only {able} can run several trials at a "
            "time"
        )


def usual_pending(simulator: str) -> int:
    """Return the default number of trials that are pending at a time."""
    return USUAL_PENDING if capabilities(simulator).parallel else 1


@dataclass(frozen=True)
class _Learning:
    """What the steps of a plan share."""

    home: ResultFolder | None
    options: LearnOptions
    parallel: int
    disturbances: Disturbances | None
    evaluator: Evaluator
    executor: Executor | None
    database: SharedDatabase | None
    progress: Callable[[Progress], object]

    def initial(self, fold: Fold) -> list[Parameters]:
        """Return the initial curves of a first step. Only the Gaussian process starts from them."""
        return initial_curves(fold, robust=self.disturbances is not None) if self.options.sampler == "gp" else []

    def plan(self, task: Task, folder: ResultFolder | None, first: Sequence[Parameters]) -> PlanResult:
        """Learn every step of a plan."""
        results: list[Result] = []
        try:
            for number in range(len(task.plan.steps)):
                here = task if number == 0 else task.at(number, results[-1].final)
                place = None if folder is None else folder.step(number)
                if number == 0:
                    curves = [*self.initial(here.fold), *first]
                else:  # usual curves, and the best of the earlier steps
                    if place is not None:
                        _delete_outdated_step(here, place, self.database)
                    grasps = self.options.grasps
                    best = [transfer(each.best.parameters, each.task.fold, here.fold, grasps) for each in results]
                    curves = [*later_curves(here.fold), *best]
                results.append(self.step(here, place, curves))
        except KeyboardInterrupt:
            if folder is not None and (learned := [Result.load(step.path) for step in folder.learned_steps()]):
                self._whole(task, learned, folder)
            raise
        return self._whole(task, results, folder)

    def _whole(self, task: Task, results: Sequence[Result], folder: ResultFolder | None) -> PlanResult:
        """Return the joined result of all steps, and write the files of the whole plan that are missing."""
        whole = PlanResult.of(task, results, None if folder is None else folder.path)
        if folder is not None:
            files = (folder.result_file, folder.rollout_file, folder.report_file)
            present = all(file.exists() for file in files)
            if not present or read_json(folder.result_file) != whole.record.model_dump():
                whole.write_whole(folder.path)
                whole.write_report()
        return whole

    def step(self, task: Task, folder: ResultFolder | None, first: Sequence[Parameters]) -> Result:
        """Learn one step, from these initial curves."""
        from tatamu.study.store import held_store

        options = self.options
        record = StudyRecord(
            task=describe_task(task),
            sampler=options.sampler,
            grasps=options.grasps,
            seed=options.seed,
            parallel=self.parallel,
            first=[dict(parameters) for parameters in first],
            disturbances=self.disturbances.describe() if self.disturbances else None,
            level=options.level if self.disturbances else None,
            aim=task.aim if any(task.aim.model_dump().values()) else None,
        )
        evaluator = self.evaluator.on(task)
        space = search_space(task.fold, options.grasps)
        if not evaluator.contains_length:
            space = replace(space, known_part=None)
        with (
            locked(folder) if folder else nullcontext(),
            held_store(folder, self.database, record) as store,
            executor_of(self.executor, self.parallel) as executor,
        ):
            search = find_search(record.sampler)(space, record.seed, record.first)
            study = Study(evaluator, search, store, record, executor, options.trials, self.progress)
            done, most = len(study.trials), max_trials(options.trials)
            if done > most:
                where = folder.path if folder else "the study"
                raise InputError(f"trials: must be at least {done}, given {most}; {where} already has {done} trials")
            if self.home is not None:
                keep_inputs(self.home.path, sources_of(task, self.disturbances))
            return self._run(study, folder)

    def _run(self, study: Study, folder: ResultFolder | None) -> Result:
        """Run the remaining trials of a study, write its folder, and return its result."""
        baselines = self.options.baselines
        if study.is_over and folder and folder.complete and (study.baselines is not None or not baselines):
            return replace(Result.load(folder.path), made_from=study.task)
        if folder is not None:
            folder.report_file.unlink(missing_ok=True)  # a report shows that the folder is complete
        try:
            study.report()
            study.run(baselines, None if folder is None else partial(self._write_first, study, folder))
            return self._finish(study, folder)
        except KeyboardInterrupt:
            if study.best() is not None and folder is not None:
                self._finish(study, folder)
            raise

    def _write_first(self, study: Study, folder: ResultFolder, found: Evaluation) -> None:
        """Write the result of the first initial curve, so that there is a fold to look at after seconds."""
        if not found.failed:
            trial = Trial.of(0, Proposal(found.parameters), found)
            self._result(study, folder, [trial], found)
            study.report("first", trial=trial)

    def _finish(self, study: Study, folder: ResultFolder | None) -> Result:
        """Return the result of a study whose trials have run, and write its folder."""
        best, trials = study.best(), study.trials
        found = None if best is None else study.evaluation(best)
        if best is None or found is None or found.rollout is None:
            where = f"{folder.path}: " if folder else ""
            if folder is not None:
                folder.write_record(self._record(study, trials))
            raise TatamuError(f"{where}all {len(trials)} trials failed; last error: {trials[-1].error}")
        tested: Tested = (None, {})
        if self.disturbances is not None:
            tested = study.measure_success(self.disturbances, trials[best].parameters)
        if folder is not None:
            study.report("report")
        return self._result(study, folder, trials, found, tested)

    def _result(
        self,
        study: Study,
        folder: ResultFolder | None,
        trials: list[Trial],
        found: Evaluation,
        tested: Tested = (None, {}),
    ) -> Result:
        """Return a result whose best trial was evaluated as `found`, and write it with its page."""
        rollout, task = found.rollout, study.task
        success, ends = tested
        assert rollout is not None, "the best evaluation has its rollout"
        record = self._record(study, trials, rollout, success)
        manipulation = task.manipulation(record.best_trial.parameters)
        shown = replace(rollout, extra={"target": task.fold.target, **study.moments(), **ends})
        centre = NOMINAL if self.disturbances is None else mean_scenario(self.disturbances)
        scene = disturbed_scene(task.fold, manipulation, centre)
        result = Result(record, manipulation, scene, shown, folder.path if folder else None, task)
        if folder is not None:
            result.save(folder.path)
            result.write_report()
        return result

    def _record(
        self, study: Study, trials: list[Trial], best: Rollout | None = None, success: Success | None = None
    ) -> ResultRecord:
        """Return the record of a study, whose best trial has the rollout `best`; None if all trials failed."""
        task = study.task
        return ResultRecord(
            **dict(study.record),
            tatamu=__version__,
            request=_request(task, self.options, self.disturbances, self.parallel),
            until_gain=MIN_GAIN if self.options.trials == "auto" else None,
            bounds={name: [each.low, each.high] for name, each in study.search.space.bounds.items()},
            success=success,
            asked=task.asked,
            wall_seconds=round(sum(trial.seconds or 0.0 for trial in trials), 3),
            best=None if best is None else study.best() or 0,
            crossings=None if best is None else Crossings.of(best),
            trials=trials,
            baselines=study.baselines or [],
        )


def _request(task: Task, options: LearnOptions, disturbances: Disturbances | None, parallel: int) -> TaskRequest:
    """Return the options of the command that learns a task."""
    asked: dict[str, Any] = {"garment": task.garment.name, "fold": task.plan.name, "hands": task.hands}
    if task.asked is not None:
        asked = {name: value for name, value in task.asked.model_dump().items() if name in TaskRequest.model_fields}
    if asked.get("size"):
        asked["size"] = "x".join(f"{side:g}" for side in asked["size"])
    robot = asked.get("robot") or (task.reach.robot if task.reach else None)
    given = {name: getattr(options, name) for name in LearnOptions.model_fields}
    given["parallel"] = None if parallel == usual_pending(task.simulator) else parallel
    if disturbances is None:
        given["disturbances"] = "none"
    elif disturbances == default_disturbances():
        given["disturbances"] = None
    elif not isinstance(given["disturbances"], str):
        given["disturbances"] = "inputs/disturbances/disturbances.toml"
    return TaskRequest(**{**asked, "robot": robot, "simulator": task.simulator, **given})


def _disturbances(task: Task, options: LearnOptions, held: StudyRecord | None) -> Disturbances | None:
    """Return the disturbances of a study. A resumed one keeps its own, unless others are given."""
    if held is not None and options.disturbances is None:
        return None if held.disturbances is None else Disturbances.model_validate(held.disturbances)
    given = options.disturbances
    if isinstance(given, Disturbances):
        found: Disturbances | None = given
    elif given is None and task.reach is not None and task.reach.disturbances is not None:
        found = disturbances_in(task.reach.disturbances, "robot")
    elif isinstance(given, str | Path | None):
        found = load_disturbances("default" if given is None else str(given))
    else:
        raise InputError(f"disturbances: must be default, none, a .toml file or a `Disturbances`, given {given!r}")
    material = task.asked.material if task.asked else None
    if found is not None and material is not None and not found.mean:  # means are from measured folds
        found = with_calibrated(found, Path(material), task.garment.material)
    return found


def _refuse_other(folder: ResultFolder, several: bool) -> None:
    """Refuse a folder that would contain the study of a single step and a plan of several."""
    if not several and folder.holds_plan:
        raise InputError(
            f"{folder.path}: must be a new folder or the folder of a single fold, but contains a plan of several "
            "steps; give another folder"
        )
    if several and (folder.study_file.exists() or folder.shared_study_file.exists()):
        raise InputError(
            f"{folder.path}: must be a new folder or the folder of a plan of several steps, but contains a single "
            "fold; give another folder"
        )


def _delete_outdated_step(task: Task, folder: ResultFolder, database: SharedDatabase | None) -> None:
    """Delete the study of a step if the step before now ends in another state, because it got more trials."""
    from tatamu.study.store import load_settings

    held = load_settings(folder, database)
    if held is not None and held.task.start != digest(task.fold.start):
        shutil.rmtree(folder.path)
