"""The files of a LeRobotDataset v3.0, to which episodes are appended.

Names, sizes and columns are those of LeRobot 0.6.1, datasets/utils.py and datasets/dataset_writer.py (Apache-2.0). A
file that has reached its largest size is followed by the next.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.extras import needed
from tatamu.base.files import unwritable, writing
from tatamu.lerobot.video import VideoWriter

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


class NumberFiles:
    """Parquet files of all features but pictures, with a row for each frame and a row group for each episode."""

    def __init__(self, folder: Path, largest: int) -> None:
        """Prepare the files; the largest size is in bytes."""
        self._folder = folder
        self._largest = largest
        self._number = -1
        self._file: Any = None
        self._writer: Any = None

    def add(self, columns: Mapping[str, np.ndarray]) -> dict[str, int]:
        """Append an episode, and return its place as columns of the table of episodes.

        Args:
            columns: Values by the names of the features, shape (frames, k).
        """
        table = needed("pyarrow", "dataset").table({name: _column(array) for name, array in columns.items()})
        try:
            if self._file is None or self._file.tell() > self._largest:
                self._next(table.schema)
            self._writer.write_table(table)
        except OSError as error:
            raise unwritable(self._path, error) from None
        chunk, file = divmod(self._number, FILES_IN_CHUNK)
        return {"data/chunk_index": chunk, "data/file_index": file}

    def close(self) -> None:
        """Close the last file."""
        if self._file is None:
            return
        opened, self._file = self._file, None
        with writing(self._path), opened:
            self._writer.close()

    @property
    def _path(self) -> Path:
        return self._folder / numbered(DATA, max(self._number, 0))

    def _next(self, schema: Any) -> None:
        self.close()
        self._number += 1
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._file = self._path.open("wb")
        self._writer = needed("pyarrow.parquet", "dataset").ParquetWriter(self._file, schema)


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


class VideoFiles:
    """The videos of one camera, each of several episodes."""

    def __init__(self, folder: Path, name: str, fps: int, largest: int) -> None:
        """Prepare the videos; the largest size is in bytes."""
        self._folder = folder
        self._name = name
        self._fps = fps
        self._largest = largest
        self._number = -1
        self._video: VideoWriter | None = None

    def add(self, pictures: np.ndarray) -> dict[str, float]:
        """Append an episode, and return its place as columns of the table of episodes.

        Args:
            pictures: RGB, uint8, shape (frames, h, w, 3).
        """
        if self._video is None or self._video.size > self._largest:
            self.close()
            self._number += 1
            path = self._folder / numbered(VIDEOS, self._number, self._name)
            self._video = VideoWriter(path, self._fps, *pictures.shape[1:3])
        first = self._video.frames
        self._video.add(pictures)
        chunk, file = divmod(self._number, FILES_IN_CHUNK)
        place = {
            "chunk_index": chunk,
            "file_index": file,
            "from_timestamp": first / self._fps,
            "to_timestamp": self._video.frames / self._fps,
        }
        return {f"videos/{self._name}/{kind}": value for kind, value in place.items()}

    def close(self) -> None:
        """Close the last video."""
        if self._video is not None:
            video, self._video = self._video, None
            video.close()
