"""Read a LeRobotDataset v3.0 with only pyarrow and PyAV."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.extras import needed
from tatamu.base.files import foreign, read_json
from tatamu.lerobot import files
from tatamu.lerobot.video import read_video


class LeRobotReader:
    """A dataset in a folder."""

    def __init__(self, root: Path | str) -> None:
        """Open a dataset.

        Raises:
            InputError: If the folder contains no dataset, or a dataset of another version.
        """
        self.root = Path(root)
        path = self.root / files.INFO
        if not path.is_file():
            raise InputError(f"{self.root}: must be the folder of a LeRobotDataset, but has no {files.INFO}")
        self.info: dict[str, Any] = read_json(path)
        version = self.info.get("codebase_version") if isinstance(self.info, dict) else None
        if version != files.VERSION:
            raise InputError(f"{path}: codebase_version: must be {files.VERSION}, given {version!r}")

    @property
    def fps(self) -> int:
        """Frames per second."""
        return int(self.info["fps"])

    @cached_property
    def episodes(self) -> list[dict[str, Any]]:
        """Rows of the table of episodes, without their statistics."""
        paths = sorted((self.root / "meta" / "episodes").glob("*/*.parquet"))
        rows: list[dict[str, Any]] = []
        for file in paths:
            with foreign(file, "a Parquet file"):
                table = needed("pyarrow.parquet", "dataset").read_table(file)
                rows += table.select([name for name in table.column_names if not name.startswith("stats/")]).to_pylist()
        return rows

    @cached_property
    def tasks(self) -> list[str]:
        """Texts of the tasks, by index."""
        file = self.root / files.TASKS
        with foreign(file, "a Parquet file"):
            rows = needed("pyarrow.parquet", "dataset").read_table(file).to_pylist()
        return [row["task"] for row in sorted(rows, key=lambda row: int(row["task_index"]))]

    def row(self, episode: int) -> dict[str, Any]:
        """Return the row of an episode in the table of episodes."""
        if not 0 <= episode < len(self.episodes):
            raise InputError(f"episode: must be from 0 to {len(self.episodes) - 1}, given {episode}")
        return self.episodes[episode]

    def numbers(self, episode: int, *names: str) -> dict[str, np.ndarray]:
        """Return features of an episode, but pictures, as arrays of shape (frames, k), or (frames,) if k is 1.

        Raises:
            InputError: If there is no such episode or feature, or a file is broken.
        """
        row = self.row(episode)
        if unknown := [name for name in names if name not in self.info["features"]]:
            raise InputError(f"{self.root}: must contain the feature {unknown[0]!r}")
        file = self._file(files.DATA, row["data/chunk_index"], row["data/file_index"])
        with foreign(file, "a Parquet file"):
            rule = [("episode_index", "==", episode)]
            table = needed("pyarrow.parquet", "dataset").read_table(file, columns=list(names), filters=rule)
            kinds = {name: self.info["features"][name]["dtype"] for name in names}
            return {name: np.array(table[name].to_pylist(), dtype=kind) for name, kind in kinds.items()}

    def pictures(self, episode: int, name: str) -> Iterator[np.ndarray]:
        """Yield the pictures of one camera in an episode: RGB, uint8, shape (h, w, 3).

        Raises:
            InputError: If there is no such episode or camera, or a file is broken.
        """
        row = self.row(episode)
        if f"videos/{name}/file_index" not in row:
            raise InputError(f"{self.root}: must contain pictures of the camera {name!r}")
        file = self._file(files.VIDEOS, row[f"videos/{name}/chunk_index"], row[f"videos/{name}/file_index"], name)
        first = round(row[f"videos/{name}/from_timestamp"] * self.fps)
        last = round(row[f"videos/{name}/to_timestamp"] * self.fps)
        yield from islice(read_video(file), first, last)

    def _file(self, pattern: str, chunk: int, file: int, key: str = "") -> Path:
        """Return a file by the names of the format, because those in `info.json` could lead anywhere."""
        return self.root / pattern.format(chunk_index=int(chunk), file_index=int(file), video_key=key)
