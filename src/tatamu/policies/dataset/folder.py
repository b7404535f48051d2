"""The folder of a dataset: the episodes that are being recorded, then the finished files.

Each episode is a file in `.episodes` at first. Then the finished files are written in `.building`, and are moved to
their places, `dataset.json` last, so a folder without it is unfinished.
"""

from __future__ import annotations

import json
import os
import shutil
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, Literal

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import lock_folder, read_json, read_npz, validated, write_json, write_npz, writing
from tatamu.base.records import OpenRecord
from tatamu.base.version import __version__
from tatamu.lerobot.files import PARTS
from tatamu.policies.dataset.arms import Stand
from tatamu.policies.dataset.episode import Episode
from tatamu.policies.dataset.record import parsed
from tatamu.policies.dataset.specification import DatasetSpecification

VERSION = 1
"""Version of the folder's format."""
LOCK = ".dataset-lock"
"""Locked while a dataset is made."""
FINISHED = (*PARTS, "states.zarr", "episodes.parquet", "dataset.html", "dataset.json")
"""Parts of a finished dataset, in the order in which they are moved to their places."""


class DatasetRecord(OpenRecord):
    """The contents of `dataset.json`."""

    version: Literal[1] = 1
    tatamu: str = __version__
    specification: DatasetSpecification
    stand: Stand | None = None
    """None for floating hands."""
    episodes: int = 0
    frames: int = 0
    successes: int = 0


class DatasetFolder:
    """A folder that contains a dataset, or will.

    Attributes:
        path: The folder.
        file: The record of the dataset.
        table: A row for each episode.
        states: The states in the format Zarr.
        page: The page of the dataset.
        building: Where finished files are written first.
        started_file: The record of a dataset that is being recorded.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.file = path / "dataset.json"
        self.table = path / "episodes.parquet"
        self.states = path / "states.zarr"
        self.page = path / "dataset.html"
        self.building = path / ".building"
        self.started_file = path / ".episodes" / "started.json"

    def episode_file(self, number: int) -> Path:
        """Return the file of a recorded episode."""
        return self.path / ".episodes" / f"{number:06d}.npz"

    @property
    def is_finished(self) -> bool:
        """Whether the dataset is complete."""
        return self.file.exists()

    def read(self) -> DatasetRecord:
        """Return the record of a finished dataset.

        Raises:
            InputError: If there is none, or one of another version.
        """
        if not self.path.is_dir():
            raise InputError(f"{self.path}: must be the folder of a dataset, but is not a folder")
        if not self.file.exists():
            why = "has no dataset.json"
            if self.started_file.exists():
                why = "is unfinished; run the same `tatamu dataset` command again"
            raise InputError(f"{self.path}: must be the folder of a finished dataset, but {why}")
        return _read_record(self.file)

    def locked(self) -> AbstractContextManager[object]:
        """Lock the folder until the `with` statement ends.

        Raises:
            InputError: If another process writes a dataset here, or the folder cannot be written.
        """
        return lock_folder(self.path, LOCK, "another dataset is being made here")

    def start(self, record: DatasetRecord) -> None:
        """Start or resume recording.

        Raises:
            InputError: If the folder contains something else, or a dataset of another specification or version.
        """
        known = [name for name in os.listdir(self.path) if name not in (LOCK, ".episodes", ".building")]
        if self.started_file.exists():
            self.refuse_other(record, _read_record(self.started_file))
        elif known:
            raise InputError(
                f"{self.path}: must be a new folder or the folder of a dataset, but contains other files; give another "
                "--out"
            )
        else:
            write_json(self.started_file, record.model_dump(mode="json"))

    def refuse_other(self, record: DatasetRecord, before: DatasetRecord | None = None) -> None:
        """Raise an error if the dataset of `before`, or else the finished one, is not that of this record.

        Raises:
            InputError: If the specifications or the versions of an unfinished dataset differ.
        """
        before = before or self.read()
        if before.specification != record.specification:
            raise InputError(
                f"{self.path}: the dataset in this folder was made from another dataset file; give another --out"
            )
        if before.tatamu != record.tatamu and not self.is_finished:
            raise InputError(
                f"{self.path}: the dataset was started with tatamu {before.tatamu} and cannot be continued with "
                f"{record.tatamu}; install tatamu {before.tatamu}, or give another --out"
            )

    def keep(self, episode: Episode) -> None:
        """Store a recorded episode, as a whole or not at all."""
        about = np.array(episode.record.model_dump_json())
        write_npz(self.episode_file(episode.record.episode), {**episode.arrays, "record": about})

    def kept(self, number: int) -> Episode:
        """Return a stored episode."""
        file = self.episode_file(number)
        arrays = read_npz(file, "a recorded episode")
        return Episode(parsed(str(arrays.pop("record")), file, "is not a recorded episode"), arrays)

    def finish(self, record: DatasetRecord) -> None:
        """Move the finished files to their places, and remove the temporary ones."""
        write_json(self.building / self.file.name, record.model_dump(mode="json"))
        with writing(self.path):
            for name in FINISHED:
                built = self.building / name
                if built.exists():
                    _remove(self.path / name)
                    os.rename(built, self.path / name)
            shutil.rmtree(self.building)
            shutil.rmtree(self.started_file.parent)


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _read_record(file: Path) -> DatasetRecord:
    value: Any = read_json(file)
    version = value.get("version") if isinstance(value, dict) else None
    if version != VERSION:
        raise InputError(f"{file}: version: must be {VERSION}, given {json.dumps(version)}")
    return validated(DatasetRecord, value, file)
