"""The record of an episode. Its task is stored as names and numbers, from which it can be made again."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import validated
from tatamu.base.records import OpenRecord
from tatamu.evaluation.success import interval_of
from tatamu.folding.score import Score
from tatamu.folding.task import Task, make_task
from tatamu.simulation.material import Material


class Subject(OpenRecord):
    """A garment, and a step of a plan."""

    garment: str
    plan: str
    step: int = 0
    """Index of the step."""
    size: list[float] | None = None
    """[m]; None for the garment's own."""
    spacing: float | None = None
    """[m]; None for the garment's own."""
    scale: float | None = None
    """Metres per unit of the garment's file; None if the file contains its unit."""
    hands: int | None = None
    """None for the plan's number."""
    material: dict[str, float] | str | None = None
    """Its fields, name or file; None for the garment's own."""
    start: list[float] | None = None
    """x, y, z of each vertex before the fold [m]; None if the cloth lies flat."""

    def make_task(self) -> Task:
        """Return the task. The last ones are kept in memory.

        Raises:
            InputError: If a file does not exist, or the names and numbers do not fit.
        """
        return _made(self.model_dump_json(include=set(Subject.model_fields)))


@lru_cache(maxsize=4)
def _made(text: str) -> Task:
    subject = Subject.model_validate_json(text)
    material = subject.material
    task = make_task(
        subject.garment,
        fold=subject.plan,
        size=None if subject.size is None else (subject.size[0], subject.size[1]),
        material=Material(**material) if isinstance(material, dict) else material,
        spacing=subject.spacing,
        scale=subject.scale,
        hands=subject.hands,
    )
    start = None if subject.start is None else np.array(subject.start).reshape(-1, 3)
    return task.at(subject.step, start) if subject.step else task


def fields_of(material: Material) -> dict[str, float]:
    """Return the fields of a material that are set, as arguments of `Material`."""
    return {name: value for name, value in material.model_dump().items() if value is not None}


class EpisodeRecord(Subject):
    """One episode, with everything that is needed to run its actions again."""

    episode: int
    """Index of the episode."""
    fold: int
    """Index of the fold."""
    task: str
    """The task as text."""
    source: str
    """"drawn", or the folder of a learned fold."""
    parameters: dict[str, float]
    """Parameters x1, z1, x2, z2 [m], g1 and g2 of the hands' curve, Eq. (9)."""
    world: dict[str, float]
    """Values of the disturbances that are not 0."""
    frames: int
    """Number of actions in the episode."""
    vertices: int
    """Number of vertices of the cloth."""
    success: bool
    """Whether the fold succeeds as `Score` defines it."""
    error: str = ""
    """Reason why the simulation failed; empty if it did not fail."""
    score: Score | None
    """All measures of the outcome; None if the simulation failed."""
    held_draws: int = 0
    """Number of scenarios that were simulated with this fold."""
    held: int = 0
    """Number of scenarios in which it succeeded."""
    held_from: str = ""
    """Where the scenarios are from; empty if there are none.

    "worlds" are those that the specification asks for, "margins" and "study" those of a learned fold, and "episodes"
    the episodes with the same fold.
    """
    held_share: float | None = None
    """Success rate of the fold in the scenarios, from 0 to 1; None if there are none."""
    held_interval: tuple[float, float] | None = None
    """Its 95 % interval (Clopper and Pearson 1934)."""
    second_simulator: str = ""
    """Empty if there is none."""
    second_success: bool | None = None
    second_mean_vertex_distance: float | None = None
    """[m]; None if there is no second simulator, or it failed."""

    def with_share(self, held: int, draws: int, source: str) -> EpisodeRecord:
        """Return the record with the success rate of its fold."""
        share = {"held_share": held / draws, "held_interval": interval_of(held, draws)}
        return self.model_copy(update={"held": held, "held_draws": draws, "held_from": source, **share})


def parsed(text: str, path: Path, wrong: str = "record: is not valid JSON") -> EpisodeRecord:
    """Return the record of an episode from its JSON text in a file, of which `wrong` is said if it is no JSON."""
    try:
        value = json.loads(text)
    except ValueError:
        raise InputError(f"{path}: {wrong}") from None
    return validated(EpisodeRecord, value, path)


def with_shares(records: Sequence[EpisodeRecord], disturbed: bool) -> list[EpisodeRecord]:
    """Return the records with the success rate of each fold.

    The rate is that of the scenarios that the specification asks for, or else of the episodes with the same fold, if
    there are several.

    Args:
        records: Records of all episodes.
        disturbed: Whether the episodes have disturbances.
    """
    folds: dict[int, list[EpisodeRecord]] = {}
    for record in records:
        folds.setdefault(record.fold, []).append(record)

    def shared(record: EpisodeRecord) -> EpisodeRecord:
        siblings = folds[record.fold]
        known = next((each for each in siblings if each.held_draws), None)
        if known is not None:
            return record.with_share(known.held, known.held_draws, known.held_from)
        if not disturbed or len(siblings) == 1:  # one episode would give a rate of 0 or 1
            return record
        return record.with_share(sum(each.success for each in siblings), len(siblings), "episodes")

    return [shared(record) for record in records]
