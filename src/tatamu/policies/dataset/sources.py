"""Sources of a dataset's folds: folds that are drawn at random, learned folds, or the tasks of a sweep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError
from tatamu.folding.parameters import arched_curve
from tatamu.folding.task import Task
from tatamu.policies.dataset.distribution import choose, draw
from tatamu.policies.dataset.record import Subject, fields_of
from tatamu.policies.dataset.specification import DatasetSpecification
from tatamu.search import Parameters
from tatamu.study.folder import ResultFolder
from tatamu.study.inputs import kept_input
from tatamu.study.result import Result
from tatamu.sweep import SweepFolder


@dataclass(frozen=True)
class DrawnFold:
    """The names and numbers of a fold whose garment has not been made yet."""

    source: str
    """"drawn", or the folder of a learned fold."""
    subject: Subject
    middle: Parameters | None = None
    """Parameters of the middle curve, which is that of the learned fold; None for the arched curve."""
    known: tuple[int, int, str] | None = None
    """Successes of the learned fold, number of its scenarios, and their source."""
    unit: tuple[float, ...] = (0.0,) * 6
    """Deviation of each parameter from the middle curve, from -1 to 1, where 1 is the specification's `spread`."""


def read_runs(specification: DatasetSpecification) -> list[DrawnFold]:
    """Read the learned folds that a specification names; empty if its folds are drawn at random.

    Raises:
        InputError: If a folder contains no learned fold, or is broken.
    """
    folders = [found for path in _folders(specification) for found in _steps(path)]
    if len(folders) > 10_000:
        raise InputError(f"fold: must name at most 10000 learned folds, given {len(folders)}")
    return [_learned(folder) for folder in folders]


def draw_fold(
    specification: DatasetSpecification, runs: Sequence[DrawnFold], number: int, attempt: int = 0
) -> DrawnFold:
    """Draw a fold.

    Args:
        specification: The specification of the dataset.
        runs: The learned folds that it names.
        number: Index of the fold.
        attempt: Above 0 if the robot could not carry out the fold of earlier attempts.
    """
    generator = np.random.default_rng(np.random.SeedSequence([specification.seed, 0, number, attempt]))
    if runs:
        return replace(runs[number % len(runs)], unit=_unit(generator))
    garment = specification.drawn_garment
    name = choose(garment.name, generator)
    size = None
    if garment.width is not None and garment.length is not None:
        size = (draw(garment.width, generator), draw(garment.length, generator))
    material = None if garment.material is None else choose(garment.material, generator)
    subject = _subject(specification, name, choose(specification.fold.plan, generator), material, size)
    return DrawnFold("drawn", subject, unit=_unit(generator))


def parameters_of(drawn: DrawnFold, task: Task, spread: float) -> Parameters:
    """Return the parameters of a drawn fold.

    Args:
        drawn: The random numbers of the fold.
        task: The task of the fold.
        spread: Largest deviation from the middle curve, as a fraction of each parameter's range.
    """
    middle = drawn.middle or arched_curve(task.fold)
    bounds = task.space.bounds
    return {
        name: bounds[name].nearest(middle[name] + spread * each * (bounds[name].high - bounds[name].low))
        for name, each in zip(bounds, drawn.unit, strict=True)
    }


def check_names(specification: DatasetSpecification) -> None:
    """Refuse unknown garments, plans and materials, and sizes that do not fit, before any episode is recorded."""
    garment = specification.drawn_garment
    materials = [None] if garment.material is None else _listed(garment.material)
    for name in _listed(garment.name):
        for plan in _listed(specification.fold.plan):
            for material in materials:
                _subject(specification, name, plan, material, garment.largest).make_task()


def _subject(
    specification: DatasetSpecification, garment: str, plan: str, material: str | None, size: tuple[float, float] | None
) -> Subject:
    drawn = specification.drawn_garment
    return Subject(
        garment=garment,
        plan=plan,
        size=None if size is None else [*size],
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
        raise InputError(f"{sweep.path}: fold.sweep: must be a sweep with at least one finished task, given none")
    return complete


def _steps(path: Path) -> list[Path]:
    """Return the folders of a plan's steps, or the folder of a single fold."""
    folder = ResultFolder(path)
    if not path.is_dir():
        raise InputError(f"{path}: must be the folder of a learned fold, but is not a folder")
    return [step.path for step in folder.learned_steps()] if folder.holds_plan else [path]


def _learned(path: Path) -> DrawnFold:
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
    return DrawnFold(str(path), subject, dict(result.best.parameters), _known(ResultFolder(path), result))


def _known(folder: ResultFolder, result: Result) -> tuple[int, int, str] | None:
    margins = folder.margins
    rate = margins.together if margins else None
    source = "margins" if rate is not None else "study"
    rate = rate or result.success
    return None if rate is None else (rate.succeeded, rate.simulations, source)
