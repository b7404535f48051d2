"""The record of an episode. Its task is stored as names and numbers, from which it can be made again.

The file `episodes.parquet` has a row for each episode, with everything that is needed to run its actions again.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.extras import needed
from tatamu.base.files import foreign, replacing, validated
from tatamu.base.records import OpenRecord
from tatamu.evaluation.success import interval_of
from tatamu.folding.score import MEASURES, Score
from tatamu.folding.task import Task, make_task
from tatamu.lerobot.files import table_of
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


def columns_of(record: EpisodeRecord) -> dict[str, Any]:
    """Return the outcome of an episode as columns of a table, with the material and the scenario as JSON texts."""
    plain = record.model_dump(exclude={"start", "score", "parameters", "episode"})
    measures = {name: None if record.score is None else getattr(record.score, name) for name in MEASURES}
    interval = None if record.held_interval is None else [*record.held_interval]
    texts = {name: json.dumps(plain.pop(name)) for name in ("material", "world")}
    return {**plain, **measures, **record.parameters, **texts, "held_interval": interval}


def row_of(record: EpisodeRecord, final: np.ndarray) -> dict[str, Any]:
    """Return the row of an episode with the final positions [m], shape (n, 3)."""
    kept = {"record": record.model_dump_json(), "final": final.ravel()}
    return {"episode": record.episode, **columns_of(record), **kept}


def write_table(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write the table of all episodes, as a whole or not at all."""
    with replacing(path) as temporary, temporary.open("wb") as file:
        needed("pyarrow.parquet", "dataset").write_table(table_of(rows), file)


def read_records(path: Path) -> list[EpisodeRecord]:
    """Return the record of every episode in the table."""
    with foreign(path, "a table of episodes"):
        table = needed("pyarrow.parquet", "dataset").read_table(path, columns=["record"])
    return [parsed(text, path) for text in table["record"].to_pylist()]


def read_outcome(path: Path, episode: int) -> tuple[EpisodeRecord, np.ndarray]:
    """Return the record of an episode, and its final positions [m], shape (n, 3).

    Raises:
        InputError: If the file is missing or broken, or there is no such episode.
    """
    with foreign(path, "a table of episodes"):
        parquet = needed("pyarrow.parquet", "dataset")
        count = parquet.read_metadata(path).num_rows
        if not 0 <= episode < count:
            raise InputError(f"episode: must be from 0 to {count - 1}, given {episode}")
        rule = [("episode", "==", episode)]
        row = parquet.read_table(path, columns=["record", "final"], filters=rule).to_pylist()[0]
    return parsed(row["record"], path), np.array(row["final"]).reshape(-1, 3)
