"""The file `episodes.parquet`: a row for each episode, with everything that is needed to run its actions again."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import foreign, replacing, validated
from tatamu.lerobot.extras import needed
from tatamu.policies.dataset.demonstrations import columns_of
from tatamu.policies.dataset.record import EpisodeRecord


class TableWriter:
    """A table of all episodes that is being written."""

    def __init__(self) -> None:
        self._rows: list[dict[str, Any]] = []

    def add(self, record: EpisodeRecord, final: np.ndarray) -> None:
        """Append an episode with its final positions [m], shape (n, 3)."""
        kept = {"record": record.model_dump_json(), "final": final.ravel()}
        self._rows.append({"episode": record.episode, **columns_of(record), **kept})

    def write(self, path: Path) -> None:
        """Write the table, as a whole or not at all."""
        arrow = needed("pyarrow")
        columns = {name: arrow.array([row[name] for row in self._rows]) for name in self._rows[0]}
        whole = {name: each.cast("float64") if each.type == arrow.null() else each for name, each in columns.items()}
        with replacing(path) as temporary, temporary.open("wb") as file:
            needed("pyarrow.parquet").write_table(arrow.table(whole), file)


def read_records(path: Path) -> list[EpisodeRecord]:
    """Return the record of every episode in the table."""
    with foreign(path, "a table of episodes"):
        texts: Sequence[str] = needed("pyarrow.parquet").read_table(path, columns=["record"])["record"].to_pylist()
    return [_record(path, text) for text in texts]


def read_outcome(path: Path, episode: int) -> tuple[EpisodeRecord, np.ndarray]:
    """Return the record of an episode, and its final positions [m], shape (n, 3).

    Raises:
        InputError: If the file is missing or broken, or there is no such episode.
    """
    with foreign(path, "a table of episodes"):
        parquet = needed("pyarrow.parquet")
        count = parquet.read_metadata(path).num_rows
        if not 0 <= episode < count:
            raise InputError(f"episode: must be from 0 to {count - 1}, given {episode}")
        rule = [("episode", "==", episode)]
        row = parquet.read_table(path, columns=["record", "final"], filters=rule).to_pylist()[0]
    return _record(path, row["record"]), np.array(row["final"]).reshape(-1, 3)


def _record(path: Path, text: str) -> EpisodeRecord:
    try:
        value = json.loads(text)
    except ValueError:
        raise InputError(f"{path}: record: is not valid JSON") from None
    return validated(EpisodeRecord, value, path)
