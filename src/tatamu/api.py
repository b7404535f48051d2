"""The Python interface of tatamu. Its functions combine several packages. The command line uses the same functions."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from tatamu.after.feedback import Feedback, MeasuredFold, ruler, size_of, write_corrected
from tatamu.after.feedback import corrected as corrected_fold
from tatamu.after.feedback import observe as observe_fold
from tatamu.after.feedback.known import known_of
from tatamu.after.margins import DRAWS, Measured, measure
from tatamu.after.second_opinion import Opinion
from tatamu.after.second_opinion import check as check_result
from tatamu.base.errors import InputError
from tatamu.base.files import validated
from tatamu.base.size import parse_size
from tatamu.calibration import Calibration, Measurements, load_measurements
from tatamu.calibration import calibrate as calibrate_measurements
from tatamu.evaluation.disturbances import Disturbances, require_disturbances
from tatamu.evaluation.evaluator import Ask, Evaluation, Evaluator, Wrapper
from tatamu.evaluation.nominal import Nominal
from tatamu.evaluation.success import Success
from tatamu.folding.score import Limits
from tatamu.folding.task import Task, make_task
from tatamu.robots import RobotPlan, find_reach, plan_fold, save
from tatamu.robots import load as load_robot
from tatamu.robots.motion import Pace
from tatamu.search import Parameters
from tatamu.simulation.material import Material, load_material
from tatamu.study.database import SharedDatabase
from tatamu.study.folder import ResultFolder
from tatamu.study.learn import learn as learn_study
from tatamu.study.loop import Progress
from tatamu.study.options import FoldOptions, LearnOptions
from tatamu.study.plan import PlanResult
from tatamu.study.result import Result

if TYPE_CHECKING:
    from tatamu.cameras.reading import FoldReading


def task_of(options: FoldOptions) -> Task:
    """Return the task that the options of the command line describe.

    Raises:
        InputError: If an option is wrong. The message names the option.
    """
    return make_task(
        options.garment,
        size=None if options.size is None else parse_size(options.size),
        scale=options.scale,
        fold=options.fold,
        material=options.material,
        spacing=options.spacing,
        simulator=options.simulator,
        hands=options.hands,
        reach=None if options.robot is None else find_reach(options.robot),
    )


@dataclass(frozen=True)
class OwnObjective(Wrapper):
    """Takes the objective from a user's function of the parameters. The fold is also simulated and scored."""

    function: Callable[[Mapping[str, int | float]], float]

    @property
    def name(self) -> str:
        """Name of the function."""
        return getattr(self.function, "__name__", repr(self.function))

    def __call__(self, ask: Ask | Mapping[str, int | float]) -> Evaluation:
        found = self.inner(ask)
        return found if found.failed else replace(found, objective=float(self.function(found.parameters)))


def learn(
    task: Task,
    options: LearnOptions | None = None,
    *,
    out: Path | str | None = None,
    evaluate: Evaluator | Callable[[Mapping[str, int | float]], float] | None = None,
    after: Sequence[Result | Path | str] = (),
    executor: Executor | None = None,
    database: SharedDatabase | None = None,
    progress: Callable[[Progress], object] = lambda now: None,
) -> Result | PlanResult:
    """Learn a task, as the command `tatamu learn` does.

    Args:
        task: The fold, made by `make_task`. If it is the first of several steps of a plan, all steps are learned.
        options: Options of the study; None for the defaults.
        out: Folder that keeps the study while it runs; an unfinished study in it is resumed. None for memory.
        evaluate: Evaluator, or function of the parameters, that is minimised; None for that of the options.
        after: Measured folds of the same set-up, or their folders. The search starts from the last of them, and the
            errors that follow from them are corrected.
        executor: Executor of the simulations; None for threads on all processors.
        database: Database that keeps the study; None for the file `study.db` in the folder.
        progress: Receives a `Progress` when the study is opened, after every trial, and when a stage starts.

    Raises:
        InputError: If an option is wrong, or the folder cannot be used.
        UnavailableError: If workers, the database or the disk fail. Finished trials are kept.
        TatamuError: If every trial failed.
    """
    options = options or LearnOptions()
    first: Sequence[Parameters] = ()
    if after:
        if options.disturbances is not None:
            raise InputError(
                "disturbances: must be left out if `after` is given, because measured folds determine the disturbances"
            )
        known = known_of([_loaded(each) for each in after], task, options.grasps)
        task, first = replace(task, shift=known.shift), known.first
        options = options.model_copy(update={"disturbances": known.disturbances})
    evaluator = evaluate if isinstance(evaluate, Evaluator | None) else OwnObjective(Nominal(task), evaluate)
    place = None if out is None else Path(out)
    found = learn_study(
        task,
        options,
        out=place,
        evaluate=evaluator,
        first=first,
        executor=executor,
        database=database,
        progress=progress,
    )
    for line in found.rollout.info.get("warnings") or []:
        warnings.warn(line, stacklevel=2)
    return found


def load(folder: Path | str) -> Result | PlanResult:
    """Read the folder of a learned fold, or of a learned plan with several steps.

    Raises:
        InputError: If a file is missing, damaged, of another version, or does not fit the other files.
    """
    is_plan = ResultFolder(Path(folder)).holds_plan
    return PlanResult.load(folder) if is_plan else Result.load(folder)


def measure_margins(
    result: Result | Path | str,
    draws: int = DRAWS,
    *,
    disturbances: Disturbances | str | None = None,
    seed: int = 0,
    limits: Limits | None = None,
    simulator: str | None = None,
    out: Path | str | None = None,
    alone: bool = True,
    executor: Executor | None = None,
    progress: Callable[[int, int], object] = lambda done, total: None,
    together: Callable[[Success], object] = lambda success: None,
) -> Measured:
    """Measure how large each disturbance may be before a fold fails, and how often the fold succeeds.

    Args:
        result: The learned fold, or its folder.
        draws: Number of draws. In each draw, all disturbances have random values.
        disturbances: `Disturbances`, "default", or a file; None for the disturbances of the study, or the defaults.
        seed: Random seed of the draws.
        limits: Limits of a successful fold; None for the usual ones.
        simulator: Name of the simulator; None for the simulator in which the fold was learned.
        out: Folder in which the results of simulations are kept; None if they are not kept.
        alone: Whether to measure the range of each disturbance alone, too.
        executor: Executor of the simulations; None for threads on all processors.
        progress: Called after every simulation, with the numbers of finished and of all simulations.
        together: Called with the success rate, before the ranges are found.

    Raises:
        InputError: If an argument is out of range.
    """
    given = require_disturbances(disturbances) if isinstance(disturbances, str) else disturbances
    learned = _loaded(result)
    return measure(
        learned,
        given or learned.disturbances,
        out=None if out is None else Path(out),
        draws=draws,
        seed=seed,
        limits=limits,
        simulator=simulator,
        alone=alone,
        executor=executor,
        progress=progress,
        together=together,
    )


def observe(
    result: Result | Path | str,
    *,
    left: Sequence[float] | None = None,
    right: Sequence[float] | None = None,
    slip: Sequence[float] | None = None,
    deviation: float | None = None,
    failed: bool = False,
    turned_in: Sequence[str] = (),
    measured: MeasuredFold | None = None,
    reading: FoldReading | None = None,
    executor: Executor | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Feedback:
    """Infer the errors of a set-up from how a real fold ended. The result has `.posterior` and `.correction`.

    If the fold has a folder, the numbers, the simulations and a page are kept there. Without numbers, the folds that
    were measured before are evaluated again.

    Args:
        result: The learned fold that was carried out, or its folder.
        left: Deviation of the left corner of the moved hem from its target, along the fold and across it [m].
        right: Deviation of the right corner of the moved hem from its target, along the fold and across it [m].
        slip: Displacement of the lower hem, along the fold and across it [m].
        deviation: Standard deviation of the errors of these numbers [m]; None for 1.5 mm.
        failed: Whether the real fold failed.
        turned_in: Corners that are turned in, "left" or "right". These corners are not measured.
        measured: The measured fold, instead of the six arguments before.
        reading: What was read from the photograph of `measured`, to be drawn beside it.
        executor: Executor of the simulations; None for threads on all processors.
        progress: Function that is called after every simulation, with the numbers of finished and of all simulations.

    Raises:
        InputError: If a number is out of range, or no fold was measured.
    """
    learned = _loaded(result)
    given = {"left": left, "right": right, "slip": slip}
    pairs = {place: pair for place, pair in given.items() if pair is not None}
    if pairs or failed or turned_in:
        if measured is not None:
            raise InputError("measured: must be given without left, right, slip, failed and turned_in")
        size = size_of(learned.task.fold)
        measured = ruler(pairs, size, deviation=deviation, failed=failed, turned_in=turned_in)

    def show(found: Feedback, file: Path) -> None:
        from tatamu.after.feedback.page import write_page

        write_page(found, file, reading)

    return observe_fold(learned, measured, executor=executor, progress=progress, show=show)


def correct(observed: Feedback | Result | Path | str, *, out: Path | str | None = None) -> Result:
    """Return the fold with corrected grasps, releases and heights, which undo the expected errors of the set-up.

    Args:
        observed: The result of `observe`, or a learned fold or folder with measured folds.
        out: Folder to write, which the command `tatamu plan` can read; None to write no folder.

    Raises:
        InputError: If no fold was measured, or the folder cannot be written.
    """
    found = observed if isinstance(observed, Feedback) else observe_fold(_loaded(observed))
    made = corrected_fold(found.learned, found.correction, found.posterior.disturbances)
    if out is not None:
        write_corrected(made, found.correction, Path(out))
        made = replace(made, folder=Path(out))
    return made


def check(
    result: Result | Path | str,
    simulator: str,
    *,
    material: Material | Path | str | None = None,
    halved: bool = False,
) -> Opinion:
    """Simulate a learned fold, or that of a folder, in another simulator. The result has `.score` and `.holds`.

    Args:
        result: The learned fold, or its folder.
        simulator: Name of the other simulator.
        material: The cloth in the other simulator, or its file; None for the material of the learned fold.
        halved: Whether to simulate on a mesh of half the spacing.

    Raises:
        InputError: If the simulator does not exist or cannot run on this machine, or a file is wrong.
    """
    learned = _loaded(result)
    cloth = material if isinstance(material, Material | None) else load_material(Path(material))
    return check_result(learned, simulator, cloth, halved)


def calibrate(
    measurements: Measurements | Path | str,
    simulator: str = "native",
    *,
    spacing: float | None = None,
    progress: Callable[[str], None] = lambda test: None,
) -> Calibration:
    """Find the material with which a simulator reproduces measurements. The result has `.material` and `.save(file)`.

    Args:
        measurements: The measurements, or their file.
        simulator: Name of the simulator.
        spacing: Mesh spacing of the simulated tests [m]; None for one that is fine enough not to matter.
        progress: Function that receives the name of a test before each of its simulations.

    Raises:
        InputError: If the file is wrong, or the simulator cannot reproduce a reading.
    """
    if spacing is not None and not 1e-3 <= spacing <= 0.1:
        raise InputError(f"spacing: must be from 0.001 to 0.1 m, given {spacing:g} m")
    given = measurements if isinstance(measurements, Measurements) else load_measurements(Path(measurements))
    return calibrate_measurements(given, simulator, spacing, progress)


@dataclass(frozen=True)
class FoldPlan:
    """A robot's motion that carries out a learned fold. It has passed all checks."""

    plan: RobotPlan
    result: Result

    def __repr__(self) -> str:
        checks = self.plan.checks.values()
        return (
            f"<FoldPlan for {self.plan.task.robot.name}: {self.plan.motion.times[-1]:.1f} s, "
            f"{sum(check.ok for check in checks)} of {len(checks)} checks passed>"
        )

    def export(self, folder: Path | str) -> Path:
        """Write the folder of the plan with joint trajectories, ROS bags and checks, and return the folder.

        Raises:
            InputError: If the folder cannot be written, or contains other files.
        """
        save(self.plan, Path(folder))
        return Path(folder)


def plan_for(
    result: Result | Path | str,
    robot: str = "hironx",
    *,
    place: tuple[float, float, float] | None = None,
    table_height: float | None = None,
    speed_scale: float = 1.0,
    hover: float = 0.0,
) -> FoldPlan:
    """Plan a learned fold for a robot.

    Args:
        result: The learned fold, or its folder.
        robot: Name of a robot, or a .toml file that describes a robot.
        place: Position and angle of the fold's frame in the robot's base [m, m, rad]; None to search for them.
        table_height: Height of the table's top in the robot's base [m]; None to search for it.
        speed_scale: Factor of the motion's speed, from 0.05 to 1. Waiting times are divided by this factor.
        hover: Height above the table at which the robot makes the motion with open jaws, without folding cloth [m]; 0
            to fold the cloth.

    Raises:
        InputError: If the robot does not exist, or the fold is out of its reach.
    """
    pace = validated(Pace, {"speed_scale": speed_scale}, "pace")
    learned = _loaded(result)
    return FoldPlan(plan_fold(learned, load_robot(robot), place, table_height, pace, hover), learned)


def _loaded(result: Result | Path | str) -> Result:
    return result if isinstance(result, Result) else Result.load(result)
