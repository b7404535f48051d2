"""The files of a LeRobotDataset v3.0, to which episodes are appended.

Names, sizes and columns are those of LeRobot 0.6.1, datasets/utils.py and datasets/dataset_writer.py (Apache-2.0). A
file that has reached its largest size is followed by the next.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from tatamu.base.extras import needed
from tatamu.base.files import MIB, writing

VERSION = "v3.0"
FILES_IN_CHUNK = 1000
"""Files in a folder `chunk-...`."""
DATA_MIB, VIDEO_MIB = 100, 200
"""Sizes of files with numbers and of videos at which the next one is started [MiB]."""
CHUNK = "chunk-{chunk_index:03d}/file-{file_index:03d}"
DATA = f"data/{CHUNK}.parquet"
VIDEOS = "videos/{video_key}/" + CHUNK + ".mp4"
EPISODES = f"meta/episodes/{CHUNK}.parquet"
TASKS = "meta/tasks.parquet"
STATS = "meta/stats.json"
INFO = "meta/info.json"
PARTS = ("data", "videos", "meta")
"""The folders of a dataset, of which the last one is written last."""


def numbered(pattern: str, number: int, key: str = "") -> Path:
    """Return the path of the file with an index; `key` is the feature of a video."""
    chunk, file = divmod(number, FILES_IN_CHUNK)
    return Path(pattern.format(chunk_index=chunk, file_index=file, video_key=key))


class Appendable(Protocol):
    """A file to which episodes are appended."""

    size: int
    """Its size so far [bytes]."""

    def add(self, values: Any) -> Mapping[str, float]:
        """Append an episode, and return what the table of episodes says of its place in the file."""

    def close(self) -> None:
        """Write the rest."""


class Files:
    """Numbered files, of which the next is started when the last one has reached its largest size."""

    def __init__(
        self, root: Path, pattern: str, mib: float, start: Callable[[Path], Appendable], key: str = ""
    ) -> None:
        """Prepare the files.

        Args:
            root: Folder of the dataset.
            pattern: Names of the files.
            mib: Largest size [MiB].
            start: Function that creates a file.
            key: Feature of a video.
        """
        self._path = lambda number: root / numbered(pattern, number, key)
        self._largest = int(mib * MIB)
        self._start = start
        self._number = -1
        self._file: Appendable | None = None

    def add(self, values: Any) -> dict[str, float]:
        """Append an episode, and return its place as columns of the table of episodes."""
        if self._file is None or self._file.size > self._largest:
            self.close()
            self._number += 1
            self._file = self._start(self._path(self._number))
        inside = self._file.add(values)
        chunk, file = divmod(self._number, FILES_IN_CHUNK)
        return {"chunk_index": chunk, "file_index": file, **inside}

    def close(self) -> None:
        """Close the last file."""
        if self._file is not None:
            file, self._file = self._file, None
            file.close()


class NumberWriter:
    """A Parquet file with a row for each frame, and a row group for each episode.

    Attributes:
        size: Size so far [bytes].
    """

    def __init__(self, path: Path) -> None:
        """Create the file."""
        self.size = 0
        self._path = path
        self._writer: Any = None
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("wb")

    def add(self, values: Mapping[str, np.ndarray]) -> Mapping[str, float]:
        """Append an episode: values by the names of the features, shape (frames, k)."""
        table = needed("pyarrow", "dataset").table({name: _column(array) for name, array in values.items()})
        with writing(self._path):
            if self._writer is None:
                self._writer = needed("pyarrow.parquet", "dataset").ParquetWriter(self._file, table.schema)
            self._writer.write_table(table)
        self.size = self._file.tell()
        return {}

    def close(self) -> None:
        """Write the rest, and close the file."""
        with writing(self._path), self._file:
            if self._writer is not None:
                self._writer.close()


def _column(array: np.ndarray) -> Any:
    """Return numbers, shape (frames, k), as an Arrow array of numbers (k = 1) or of lists of fixed length."""
    arrow = needed("pyarrow", "dataset")
    plain, width = arrow.array(array.ravel()), array.shape[1]
    return plain if width == 1 else arrow.FixedSizeListArray.from_arrays(plain, width)


def table_of(rows: Sequence[Mapping[str, Any]]) -> Any:
    """Return rows with equal columns as an Arrow table. A column without any value is one of numbers."""
    arrow = needed("pyarrow", "dataset")
    columns = {name: arrow.array([row[name] for row in rows]) for name in rows[0]}
    empty = arrow.null()
    return arrow.table({name: each.cast("float64") if each.type == empty else each for name, each in columns.items()})
