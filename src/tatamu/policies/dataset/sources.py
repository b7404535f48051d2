"""Sources of a dataset's folds: folds that are drawn at random, learned folds, or the tasks of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError
from tatamu.evaluation.success import Success
from tatamu.policies.dataset.distribution import choose, draw
from tatamu.policies.dataset.specification import DatasetSpecification
from tatamu.policies.dataset.subject import Subject, fields_of
from tatamu.search import Parameters
from tatamu.study.folder import ResultFolder
from tatamu.study.inputs import kept_input
from tatamu.study.result import Result
from tatamu.sweep import SweepFolder

MOST_RUNS = 10_000
"""Largest number of learned folds in a dataset."""


@dataclass(frozen=True)
class DrawnFold:
    """A fold that has been chosen at random, but whose garment has not been made yet.

    It contains the names of the garment, the plan and the material, and the random numbers for the hands' curve.
    """

    source: str
    subject: Subject
    unit: tuple[float, ...]
    """Random numbers from -1 to 1, one for each of the parameters x1, z1, x2, z2, g1 and g2 of the hands' curve.

    They are the differences between the hands' curve and the middle curve, near which it is chosen. At -1 and 1, a
    parameter has the largest difference that the specification's `spread` allows.
    """
    middle: Parameters | None = None
    """Parameters of the middle curve, near which the hands' curve is chosen at random.

    They are the parameters of the learned fold. None if the middle curve is the default curve, an arch.
    """
    known: tuple[int, int, str] | None = None
    """Number of successes of the learned fold, number of its tests, and source of these numbers; None if unknown."""


@dataclass(frozen=True)
class LearnedFold:
    """A learned fold, read from the folder of `tatamu learn`."""

    source: str
    subject: Subject
    parameters: Parameters
    known: tuple[int, int, str] | None


def read_runs(specification: DatasetSpecification) -> list[LearnedFold]:
    """Read the learned folds that a specification names; empty if its folds are drawn at random.

    Raises:
        InputError: If a folder contains no learned fold, or is broken.
    """
    folders = [found for path in _folders(specification) for found in _steps(path)]
    if len(folders) > MOST_RUNS:
        raise InputError(f"fold: must name at most {MOST_RUNS} learned folds, given {len(folders)}")
    return [_learned(folder) for folder in folders]


def draw_fold(
    specification: DatasetSpecification, runs: Sequence[LearnedFold], number: int, attempt: int = 0
) -> DrawnFold:
    """Draw a fold at random.

    Args:
        specification: The specification of the dataset.
        runs: The learned folds that the specification names.
        number: Number of the fold, from 0.
        attempt: Number of the attempt, from 0. It is above 0 if the robot could not carry out the folds of earlier
            attempts.
    """
    generator = np.random.default_rng(np.random.SeedSequence([specification.seed, 0, number, attempt]))
    if runs:
        run = runs[number % len(runs)]
        return DrawnFold(run.source, run.subject, _unit(generator), run.parameters, run.known)
    garment = specification.drawn_garment
    name = choose(garment.name, generator)
    size = None
    if garment.width is not None and garment.length is not None:
        size = [draw(garment.width, generator), draw(garment.length, generator)]
    material = None if garment.material is None else choose(garment.material, generator)
    subject = Subject(
        garment=name,
        plan=choose(specification.fold.plan, generator),
        size=size,
        spacing=garment.spacing,
        scale=garment.scale,
        hands=specification.fold.hands,
        material=material,
    )
    return DrawnFold("drawn", subject, _unit(generator))


def check_names(specification: DatasetSpecification) -> None:
    """Check the garments, plans and materials of a specification, before any episode is recorded.

    Raises:
        InputError: If a name is unknown, or a plan or a size does not fit a garment.
    """
    garment = specification.drawn_garment
    materials = [None] if garment.material is None else _listed(garment.material)
    for name in _listed(garment.name):
        for plan in _listed(specification.fold.plan):
            for material in materials:
                largest_subject(specification, name, plan, material).make_task()


def largest_subject(specification: DatasetSpecification, garment: str, plan: str, material: str | None) -> Subject:
    """Return the subject with the largest size that may be drawn at random, for a garment, a plan and a material.

    A subject is a garment and a step of a fold plan. The arguments are names.
    """
    drawn = specification.drawn_garment
    return Subject(
        garment=garment,
        plan=plan,
        size=None if drawn.largest is None else [*drawn.largest],
        spacing=drawn.spacing,
        scale=drawn.scale,
        hands=specification.fold.hands,
        material=material,
    )


def _listed(names: str | list[str]) -> list[str]:
    return names if isinstance(names, list) else [names]


def _unit(generator: np.random.Generator) -> tuple[float, ...]:
    return tuple(generator.uniform(-1.0, 1.0, 6).tolist())


def _folders(specification: DatasetSpecification) -> list[Path]:
    if specification.fold.sweep is None:
        return [Path(run) for run in specification.fold.runs or ()]
    sweep = SweepFolder(Path(specification.fold.sweep))
    complete = [sweep.of_task(record.name) for record in sweep.read() if record.state == "complete"]
    if not complete:
        raise InputError(f"{sweep.path}: fold.sweep: must be the folder of a sweep with a complete task")
    return complete


def _steps(path: Path) -> list[Path]:
    """Return the folders of the learned folds in the folder of a run.

    If a plan with several steps was learned, each step has a folder. Otherwise the folder itself is returned.
    """
    folder = ResultFolder(path)
    if not path.is_dir():
        raise InputError(f"{path}: must be the folder of a learned fold, and is no folder")
    return [step.path for step in folder.learned_steps()] if folder.holds_plan else [path]


def _learned(path: Path) -> LearnedFold:
    result = Result.load(path)
    description = result.record.task
    named = result.record.asked or description
    files = {kind: kept_input(path, kind) for kind in ("garment", "fold")}
    step = (description.step or (1, 1))[0] - 1
    subject = Subject(
        garment=str(files["garment"] or named.garment),
        plan=str(files["fold"] or named.fold),
        step=step,
        size=named.size,
        spacing=named.spacing,
        scale=result.record.asked.scale if result.record.asked else None,
        hands=1 if description.hands == 1 else None,
        material=fields_of(description.material),
        start=result.start.ravel().tolist() if step else None,
    )
    return LearnedFold(str(path), subject, dict(result.best.parameters), _known(ResultFolder(path), result))


def _known(folder: ResultFolder, result: Result) -> tuple[int, int, str] | None:
    margins = folder.margins
    rates: list[tuple[Success | None, str]] = [(margins.together if margins else None, "margins")]
    rates += [(result.success, "study")]
    return next(((rate.succeeded, rate.simulations, name) for rate, name in rates if rate is not None), None)
