"""The files to which episodes are appended. A file that has reached its largest size is followed by the next."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.files import unwritable
from tatamu.lerobot import layout
from tatamu.lerobot.extras import needed
from tatamu.lerobot.video import VideoWriter


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
        table = needed("pyarrow").table({name: _column(array) for name, array in columns.items()})
        try:
            if self._file is None or self._file.tell() > self._largest:
                self._next(table.schema)
            self._writer.write_table(table)
        except OSError as error:
            raise unwritable(self._path, error) from None
        chunk, file = divmod(self._number, layout.FILES_IN_CHUNK)
        return {"data/chunk_index": chunk, "data/file_index": file}

    def close(self) -> None:
        """Close the last file."""
        if self._file is None:
            return
        opened, self._file = self._file, None
        try:
            with opened:
                self._writer.close()
        except OSError as error:
            raise unwritable(self._path, error) from None

    @property
    def _path(self) -> Path:
        return self._folder / layout.numbered(layout.DATA, max(self._number, 0))

    def _next(self, schema: Any) -> None:
        self.close()
        self._number += 1
        self._path.parent.mkdir(parents=True, exist_ok=True)
        self._file = self._path.open("wb")
        self._writer = needed("pyarrow.parquet").ParquetWriter(self._file, schema)


def _column(array: np.ndarray) -> Any:
    """Return numbers, shape (frames, k), as an Arrow array of numbers (k = 1) or of lists of fixed length."""
    arrow = needed("pyarrow")
    width = array.shape[1]
    plain = arrow.array(array.ravel())
    return plain if width == 1 else arrow.FixedSizeListArray.from_arrays(plain, width)


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
            path = self._folder / layout.numbered(layout.VIDEOS, self._number, self._name)
            self._video = VideoWriter(path, self._fps, *pictures.shape[1:3])
        first = self._video.frames
        self._video.add(pictures)
        chunk, file = divmod(self._number, layout.FILES_IN_CHUNK)
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
