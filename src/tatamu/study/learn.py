"""Learning a task: one study for each step of its plan, kept in a folder or in memory."""

from __future__ import annotations

import os
import shutil
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import tomli_w
from filelock import FileLock, Timeout

from tatamu.disturbances import Disturbances, default_disturbances, disturbances_in, load_disturbances, with_calibrated
from tatamu.errors import InputError, TatamuError
from tatamu.evaluation import CoarseFirst, Disturbed, Evaluator, Nominal, WithinReach
from tatamu.files import unwritable
from tatamu.folding.advice import UncarriedWarning, advice
from tatamu.folding.parameters import first_curves, later_curves, search_space, transfer
from tatamu.folding.task import Task, digest
from tatamu.folding.trial_scene import scene_of
from tatamu.garments.garmentfile import files_of
from tatamu.material import is_preset
from tatamu.options import USUAL_PENDING, LearnOptions
from tatamu.search import HIGH, Parameters, Schedule, Search, Space, TwoFidelitySearch, find_search
from tatamu.simulators import SIMULATORS, capabilities
from tatamu.simulators.many import executor_of
from tatamu.study.database import SharedDatabase
from tatamu.study.folder import LEARNED, ResultFolder
from tatamu.study.inputs import Sources, keep_inputs
from tatamu.study.loop import Progress, Study
from tatamu.study.plan import PlanResult
from tatamu.study.reachable import check_reach
from tatamu.study.record import Crossings, ResultRecord, StudyRecord, describe_task
from tatamu.study.result import Result
from tatamu.study.store import held_store, load_settings
from tatamu.version import __version__

UNSURE_SHARE = 0.3
"""Part of the trials at high fidelity if coarser meshes rank trials less surely (docs/notes/learning.md,
docs/notes/margins.md)."""

Objective = Callable[[Parameters], float]
"""An objective of the user's, of the parameters of Eq. (9)."""


@dataclass(frozen=True)
class Places:
    """Where learning runs, is kept and is reported."""

    out: Path | None = None
    """Folder of the result; None to keep it in memory."""
    executor: Executor | None = None
    """Where trials run; None for threads on every processor."""
    database: SharedDatabase | None = None
    """Keeps the studies; None for the file `study.db` of each folder."""
    progress: Callable[[Progress], object] = field(default=lambda _: None)
    """Called when a study is opened, after every trial, and when another stage starts."""
    written: Callable[[Result | PlanResult], object] = field(default=lambda _: None)
    """Called when the folder of a result is written, to draw its page."""

    def step(self, number: int) -> Places:
        """Return the places of a step of a plan, from 0."""
        return self if self.out is None else replace(self, out=ResultFolder(self.out).step(number).path)

    @property
    def folder(self) -> ResultFolder | None:
        """The folder of the result; None to keep it in memory."""
        return None if self.out is None else ResultFolder(self.out)


def learn(
    task: Task,
    options: LearnOptions | None = None,
    places: Places | None = None,
    evaluate: Evaluator | None = None,
) -> Result | PlanResult:
    """Learn a task, or resume where it stopped.

    The first step of a plan of several learns them all, each from the state that the one before it left; its search
    starts with what the steps before it found. Cloth that no hand carries is reported by an `UncarriedWarning`.

    Args:
        task: The fold, the garment and the simulator.
        options: Options of the study; None for the defaults.
        places: Where it runs, is kept and is reported; None for this machine and memory.
        evaluate: Evaluates manipulations in place of the evaluator of the options.

    Raises:
        InputError: If an option is wrong, or the folder cannot be used.
        UnavailableError: If workers, the database or the disk fail; what was finished is kept.
        TatamuError: If every trial failed.
        KeyboardInterrupt: If the user ended it; what is finished is written before.
    """
    options = options or LearnOptions()
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
    settings = _Settings.of(task, options, held, evaluate)
    task = settings.with_fingers(task)
    if held is None:
        check_reach(task)
    if not several:
        return _learn_step(task, settings, places, settings.first(task, options.sampler), keep_in=places.out)
    with locked(folder) if folder else nullcontext():
        return _learn_plan(task, settings, places)


@dataclass(frozen=True)
class _Settings:
    """The options with what an earlier run of the same study decided."""

    options: LearnOptions
    parallel: int
    coarse: bool
    disturbances: Disturbances | None
    quantile: float | None
    worlds: int | None
    """Number of disturbed worlds; None for the default."""
    held_first: list[Parameters] | None
    """First parameters of a study that is resumed; None of one that starts."""
    evaluate: Evaluator | None

    @classmethod
    def of(cls, task: Task, options: LearnOptions, held: StudyRecord | None, evaluate: Evaluator | None) -> _Settings:
        disturbances, quantile, worlds = _disturbances(task, options, held)
        return cls(
            options,
            parallel=options.parallel or (held.parallel if held else usual_pending(task.simulator)),
            coarse=options.coarse if options.coarse is not None else held is None or held.coarse is not None,
            disturbances=None if evaluate else disturbances,
            quantile=quantile,
            worlds=worlds,
            held_first=held.first if held else None,
            evaluate=evaluate,
        )

    def with_fingers(self, task: Task) -> Task:
        """Return the task with the fingers of the disturbances, unless it has its own."""
        if self.disturbances is None or task.fingers.thickness > 0.0:
            return task
        return replace(task, fingers=self.disturbances.fingers)

    def first(self, task: Task, sampler: str) -> list[Parameters]:
        """Return the first parameters of a first step."""
        if self.held_first is not None:
            return self.held_first
        return first_curves(task.fold) if sampler == "gp" else []

    def evaluator(self, task: Task) -> Evaluator:
        """Return the evaluator of a step."""
        if self.evaluate is not None:
            return self.evaluate.on(task)
        made: Evaluator = Nominal(task)
        if self.disturbances is not None:
            robust = Disturbed(made, self.disturbances, self.quantile, seed=self.options.seed)
            if self.worlds is not None:
                robust = replace(robust, worlds=self.worlds)
            made = robust.for_step(task.number)
        if self.coarse:
            made = CoarseFirst(made)
        return WithinReach(made, task.reach) if task.reach else made


def _disturbances(
    task: Task, options: LearnOptions, held: StudyRecord | None
) -> tuple[Disturbances | None, float | None, int | None]:
    """Return the disturbances, the quantile and the number of worlds: as given, or as the study started."""
    if held is not None and not options.names_disturbances:
        if held.disturbances is None:
            return None, None, None
        return Disturbances.model_validate(held.disturbances), held.quantile, held.worlds
    found = _given_disturbances(task, options)
    material = task.asked.material if task.asked else None
    if found is not None and material is not None:
        found = with_calibrated(found, Path(material), task.garment.material)
    return found, options.chosen_quantile, None


def _given_disturbances(task: Task, options: LearnOptions) -> Disturbances | None:
    """Return the disturbances of the options, the robot's own, or the default ones; None for none."""
    given = options.disturbances
    if isinstance(given, Disturbances):
        return given
    if given is None and task.reach is not None and task.reach.disturbances is not None:
        return disturbances_in(task.reach.disturbances, "robot")
    return load_disturbances("default" if given is None else given)


def check_pending(options: LearnOptions, simulator: str) -> None:
    """Refuse more pending trials than a simulator runs at a time.

    Raises:
        InputError: If there are more than one, and the simulator runs one at a time.
    """
    if options.parallel is not None and options.parallel > 1 and not capabilities(simulator).parallel:
        able = ", ".join(name for name in SIMULATORS if capabilities(name).parallel)
        given = f"{options.parallel} with {simulator}"
        raise InputError(f"parallel: only {able} runs several trials at a time, given {given}")


def usual_pending(simulator: str) -> int:
    """Return how many trials are pending in a study that starts, unless another number is given."""
    return USUAL_PENDING if capabilities(simulator).parallel else 1


def _learn_plan(task: Task, settings: _Settings, places: Places) -> PlanResult:
    """Learn every step of a plan."""
    results: list[Result] = []
    try:
        for number in range(len(task.plan.steps)):
            task_here = task if number == 0 else task.at(number, results[-1].final)
            here = places.step(number)
            _delete_outdated_step(task_here, here.folder, places.database)
            first = settings.first(task_here, settings.options.sampler)
            if number > 0:
                grasps = settings.options.grasps
                found = [transfer(each.best.parameters, each.task.fold, task_here.fold, grasps) for each in results]
                first = [*later_curves(task_here.fold), *found]
            results.append(_learn_step(task_here, settings, here, first, keep_in=places.out))
    except KeyboardInterrupt:
        if places.folder is not None:
            results = [Result.load(step.path) for step in places.folder.learned_steps()]
            if results:
                _finish_plan(task, results, places)
        raise
    return _finish_plan(task, results, places)


def _finish_plan(task: Task, results: Sequence[Result], places: Places) -> PlanResult:
    """Join the steps, and write what belongs to the whole unless it is there."""
    whole = PlanResult.of(task, results, places.out)
    folder = places.folder
    if folder is None:
        return whole
    if not (folder.matches(whole.record) and folder.rollout_file.exists() and folder.report_file.exists()):
        whole.write_whole(folder.path)
        places.written(whole)
    return whole


def _learn_step(
    task: Task, settings: _Settings, places: Places, first: Sequence[Parameters], keep_in: Path | None
) -> Result:
    """Learn one step.

    Args:
        task: The step.
        settings: Options of the study.
        places: Where the step is kept.
        first: First parameters of the search.
        keep_in: Folder for copies of the user's files; None to keep none.
    """
    evaluator = settings.evaluator(task)
    record = _record(task, settings, evaluator, first)
    space = _space(task, settings)
    search = _search(record, space, evaluator.fidelities)
    schedule = _schedule(task, record, settings.options, evaluator.fidelities)
    folder = places.folder
    with (
        locked(folder) if folder else nullcontext(),
        held_store(folder, places.database, record) as store,
        executor_of(places.executor, record.parallel) as executor,
    ):
        if task.reach is not None:
            task.reach.forget()
        study = Study(evaluator, search, store, record, executor)
        if len(study.trials) > schedule.most:
            where = folder.path if folder else "the study"
            raise InputError(
                f"trials: {where} has {len(study.trials)} trials already, given {schedule.most}; "
                f"give {len(study.trials)} or more"
            )
        if keep_in is not None:
            keep_inputs(keep_in, _sources(task, settings))
        return _run(study, schedule, settings, places, task, space)


def _run(study: Study, schedule: Schedule, settings: _Settings, places: Places, task: Task, space: Space) -> Result:
    """Run the trials that are left, and write the folder."""
    baselines = settings.options.baselines
    folder = places.folder
    if study.is_over(schedule) and folder and folder.complete and not (baselines and study.baselines is None):
        return replace(Result.load(folder.path), made_from=task)
    if folder is not None:
        folder.report_file.unlink(missing_ok=True)  # written last: it says that the other files are this study's
    finish = partial(_finish_step, study, schedule, settings, places, task, space)
    try:
        places.progress(study.progress(schedule.most))
        for stage in study.run(schedule, baselines):
            places.progress(study.progress(schedule.most, stage))
        return finish()
    except KeyboardInterrupt:
        if study.succeeded and folder is not None:
            finish()
        raise


def _finish_step(
    study: Study, schedule: Schedule, settings: _Settings, places: Places, task: Task, space: Space
) -> Result:
    """Return the result of a study, and write its folder."""
    folder = places.folder
    best = study.best() if study.succeeded else None
    found = None if best is None else study.evaluation(best)
    judged = None
    if best is not None and settings.disturbances is not None:
        places.progress(study.progress(schedule.most, "validation"))
        judged = study.validate(settings.disturbances, study.trials[best].parameters)
    record = ResultRecord(
        **{name: getattr(study.record, name) for name in StudyRecord.model_fields},
        tatamu=__version__,
        until_gain=schedule.until_gain,
        bounds={name: [each.low, each.high] for name, each in space.bounds.items()},
        judged=judged,
        asked=task.asked,
        wall_seconds=round(sum(trial.seconds or 0.0 for trial in study.trials), 3),
        best=best,
        crossings=Crossings.of(found.rollout) if found and found.rollout else None,
        trials=study.trials,
        baselines=study.baselines or [],
    )
    if folder is not None:
        folder.write_record(record)
    if best is None or found is None or found.rollout is None:
        raise TatamuError(_all_failed(study, folder))
    manipulation = task.manipulation(study.trials[best].parameters)
    extra = {"target": task.fold.target, **study.moments()}
    rollout = replace(found.rollout, extra=extra)
    result = Result(record, manipulation, scene_of(task.fold, manipulation), rollout, places.out, task)
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


def _record(task: Task, settings: _Settings, evaluator: Evaluator, first: Sequence[Parameters]) -> StudyRecord:
    """Return the settings of a study as its store has them."""
    robust = _robust(evaluator)
    low = evaluator.low_fidelity(first_curves(task.fold)[0])
    return StudyRecord(
        task=describe_task(task),
        sampler=settings.options.sampler,
        grasps=settings.options.grasps,
        seed=settings.options.seed,
        parallel=settings.parallel,
        first=[dict(parameters) for parameters in first],
        coarse=low[0].task.garment.spacing if low else None,
        disturbances=robust.disturbances.describe() if robust else None,
        worlds=robust.worlds if robust else None,
        quantile=robust.quantile if robust else None,
    )


def _robust(evaluator: Evaluator) -> Disturbed | None:
    """Return the evaluator over disturbed worlds among wrappers; None if there is none."""
    while not isinstance(evaluator, Disturbed):
        inner = getattr(evaluator, "inner", None)
        if inner is None:
            return None
        evaluator = inner
    return evaluator


def _space(task: Task, settings: _Settings) -> Space:
    space = search_space(task.fold, settings.options.grasps)
    return space if settings.evaluate is None else replace(space, known_part=None)


def _search(record: StudyRecord, space: Space, fidelities: int) -> Search:
    make = find_search(record.sampler)
    if fidelities == 2:
        return TwoFidelitySearch(make, space, record.seed, record.first)
    return make(space, record.seed, record.first)


def _schedule(task: Task, record: StudyRecord, options: LearnOptions, fidelities: int) -> Schedule:
    """Return the schedule of a study.

    More trials run at high fidelity if coarser meshes are less sure: for later steps, and for how folds of two layers
    succeed in disturbed worlds.
    """
    schedule = Schedule(options.trials, fidelities)
    unsure = task.number > 0 or (record.disturbances is not None and task.garment.layers > 1)
    return replace(schedule, high_share=UNSURE_SHARE) if unsure else schedule


def _sources(task: Task, settings: _Settings) -> dict[str, Sources]:
    """Return the user's files that a task was made from, and the plan that was found for the user's own garment."""
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
    if settings.disturbances is not None and settings.disturbances != default_disturbances():
        text = tomli_w.dumps(settings.disturbances.describe())
        found["disturbances"] = Sources(text=text, name="disturbances.toml")
    return found


def _refuse_other(folder: ResultFolder, count: int) -> None:
    """Refuse to mix one-step studies and plans in one folder."""
    if count == 1 and folder.holds_plan:
        raise InputError(f"{folder.path}: holds a plan of several steps; give another folder")
    if count > 1 and (folder.study_file.exists() or folder.shared_study_file.exists()):
        raise InputError(f"{folder.path}: holds the study of a single fold; give another folder")


def _delete_outdated_step(task: Task, folder: ResultFolder | None, database: SharedDatabase | None) -> None:
    """Delete the study of a step that started from a state that the step before it no longer leaves.

    It happens if a plan is resumed with more trials: a better first fold makes the second another task.
    """
    held = load_settings(folder, database)
    if folder is not None and held is not None and task.number > 0 and held.task.start != digest(task.fold.start):
        shutil.rmtree(folder.path)


def locked(folder: ResultFolder) -> Any:
    """Return a lock on a folder that ends with the process, however it ends.

    Raises:
        InputError: If the folder cannot be written, another run has it, or it contains such files of something else.
    """
    path = folder.path
    foreign = [name for name in LEARNED if os.path.exists(path / name)]
    if foreign and not folder.has_study:
        raise InputError(f"{path}: contains {foreign[0]} but no study; it would be overwritten, give another folder")
    try:
        path.mkdir(parents=True, exist_ok=True)
        return FileLock(path / ".lock").acquire(timeout=0)
    except Timeout:
        raise InputError(f"{path}: another run is learning here") from None
    except OSError as error:
        raise unwritable(path, error) from None
