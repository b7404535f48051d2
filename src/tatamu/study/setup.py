"""Prepares a study: replaces defaults in its options, and makes its evaluator, search, schedule and record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from tatamu.base.errors import InputError
from tatamu.evaluation import CoarseFirst, Disturbed, Evaluator, Nominal, WithinReach, ends_early
from tatamu.evaluation.disturbances import (
    NOMINAL,
    Disturbances,
    disturbances_in,
    load_disturbances,
    mean_world,
    with_calibrated,
)
from tatamu.folding.parameters import first_curves
from tatamu.folding.task import Task
from tatamu.search import Parameters, Schedule, Search, Space, TwoFidelitySearch, find_search
from tatamu.simulation.simulators import SIMULATORS, capabilities
from tatamu.study.options import USUAL_PENDING, LearnOptions
from tatamu.study.record import StudyRecord, describe_task

ROBUST_SHARE = 0.24
"""Fraction of the trials that run on the fine mesh, in studies with disturbances.

It is larger than in studies without disturbances, because a coarse mesh predicts failures less reliably.
"""
LATER_SHARE = 0.3
"""Fraction of the trials that run on the fine mesh, in the second and later steps of plans.

It is larger than in the first step, because coarse meshes rank the folds of later steps least reliably."""


def resolve(options: LearnOptions, task: Task, held: StudyRecord | None) -> LearnOptions:
    """Return options in which every default is replaced by a value.

    Args:
        options: Options as the user gave them.
        task: The fold to learn.
        held: Settings of a study that is resumed; None for a new study. They replace options that are not given.
    """
    disturbances, quantile = _disturbances(task, options, held)
    return options.model_copy(
        update={
            "parallel": options.parallel or (held.parallel if held else usual_pending(task.simulator)),
            "coarse": options.coarse if options.coarse is not None else held is None or held.coarse is not None,
            "disturbances": disturbances or "none",
            "quantile": None if disturbances is None else "mean" if quantile is None else quantile,
        }
    )


def make_evaluator(task: Task, options: LearnOptions) -> Evaluator:
    """Return the evaluator of a step, which simulates and scores the step's trials.

    Args:
        task: The step to evaluate.
        options: Options in which every default is replaced by a value (`resolve`).
    """
    centre = mean_world(options.disturbances) if isinstance(options.disturbances, Disturbances) else NOMINAL
    made: Evaluator = Nominal(task, bool(options.coarse) and ends_early(task), centre)
    if isinstance(options.disturbances, Disturbances):
        made = Disturbed(made, options.disturbances, options.chosen_quantile, seed=options.seed)
    if options.coarse:
        made = CoarseFirst(made)
    return WithinReach(made, task.reach) if task.reach else made


def _disturbances(
    task: Task, options: LearnOptions, held: StudyRecord | None
) -> tuple[Disturbances | None, float | None]:
    """Return the disturbances of a study, and the minimised quantile of the objective (None for its mean).

    They come from the options, or from the settings with which a resumed study started.
    """
    if held is not None and not options.names_disturbances:
        return None if held.disturbances is None else Disturbances.model_validate(held.disturbances), held.quantile
    found = _given_disturbances(task, options)
    material = task.asked.material if task.asked else None
    if found is not None and material is not None and not found.mean:  # means are from observed folds
        found = with_calibrated(found, Path(material), task.garment.material)
    return found, options.chosen_quantile


def _given_disturbances(task: Task, options: LearnOptions) -> Disturbances | None:
    """Return the disturbances of a study's options. If the options give none, return those of the robot.

    If the robot has none either, return the default disturbances. The result is None if the user wants no disturbances.
    """
    given = options.disturbances
    if isinstance(given, Disturbances):
        return given
    if given is None and task.reach is not None and task.reach.disturbances is not None:
        return disturbances_in(task.reach.disturbances, "robot")
    if not isinstance(given, str | Path | None):
        raise InputError(f"disturbances: must be default, none, a file, or Disturbances, given {given!r}")
    return load_disturbances("default" if given is None else str(given))


def check_pending(options: LearnOptions, simulator: str) -> None:
    """Check that the simulator can run all pending trials at the same time.

    Raises:
        InputError: If several trials are pending, and the simulator runs one trial at a time.
    """
    if options.parallel is not None and options.parallel > 1 and not capabilities(simulator).parallel:
        able = ", ".join(name for name in SIMULATORS if capabilities(name).parallel)
        given = f"{options.parallel} with {simulator}"
        raise InputError(f"parallel: only {able} runs several trials at a time, given {given}")


def usual_pending(simulator: str) -> int:
    """Return how many trials a new study evaluates at the same time, if the user gives no number."""
    return USUAL_PENDING if capabilities(simulator).parallel else 1


def make_record(task: Task, options: LearnOptions, evaluator: Evaluator, first: Sequence[Parameters]) -> StudyRecord:
    """Return the record of a study: its task and settings as they are stored."""
    robust = _robust(evaluator)
    low = evaluator.low_fidelity(first_curves(task.fold)[0])
    assert options.parallel is not None, "the options are resolved"
    return StudyRecord(
        task=describe_task(task),
        sampler=options.sampler,
        grasps=options.grasps,
        seed=options.seed,
        parallel=options.parallel,
        first=[dict(parameters) for parameters in first],
        coarse=low[0].task.garment.spacing if low else None,
        disturbances=robust.disturbances.describe() if robust else None,
        worlds=robust.worlds if robust else None,
        quantile=robust.quantile if robust else None,
    )


def _robust(evaluator: Evaluator) -> Disturbed | None:
    """Return the part of an evaluator that applies disturbances; None if the study has no disturbances.

    Evaluators can be nested, so this part may be inside other evaluators.
    """
    while not isinstance(evaluator, Disturbed):
        inner = getattr(evaluator, "inner", None)
        if inner is None:
            return None
        evaluator = inner
    return evaluator


def make_search(record: StudyRecord, space: Space, fidelities: int) -> Search:
    """Return the search of a study. If there are two fidelities (a coarse and a fine mesh), the search uses both."""
    make = find_search(record.sampler)
    if fidelities == 2:
        return TwoFidelitySearch(make, space, record.seed, record.first)
    return make(space, record.seed, record.first)


def make_schedule(task: Task, record: StudyRecord, options: LearnOptions, fidelities: int) -> Schedule:
    """Return the schedule of a study: the number of trials, and the mesh of each trial.

    More trials run on the fine mesh if coarse meshes are less reliable.
    """
    schedule = Schedule(options.trials, fidelities)
    if task.number > 0:
        return replace(schedule, high_share=LATER_SHARE)
    return schedule if record.disturbances is None else replace(schedule, high_share=ROBUST_SHARE)
