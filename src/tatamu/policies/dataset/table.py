"""The file `episodes.parquet`: a row for each episode, with everything that is needed to run its actions again."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.extras import needed
from tatamu.base.files import foreign, replacing
from tatamu.lerobot.files import table_of
from tatamu.policies.dataset.demonstrations import columns_of
from tatamu.policies.dataset.record import EpisodeRecord, parsed


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
