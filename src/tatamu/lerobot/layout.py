"""The files of a LeRobotDataset v3.0, and their names.

The names, sizes and columns are the same as in LeRobot 0.6.1, datasets/utils.py and datasets/dataset_writer.py
(Apache-2.0).
"""

from __future__ import annotations

from pathlib import Path

VERSION = "v3.0"
"""Version of the format."""
FILES_IN_CHUNK = 1000
"""Largest number of files in a folder `chunk-...`."""
DATA_MIB, VIDEO_MIB = 100, 200
"""Size of a file with numbers, and of a video, at which a new file is started [MiB]."""
CHUNK = "chunk-{chunk_index:03d}/file-{file_index:03d}"
DATA = f"data/{CHUNK}.parquet"
VIDEOS = "videos/{video_key}/" + CHUNK + ".mp4"
EPISODES = f"meta/episodes/{CHUNK}.parquet"
TASKS = "meta/tasks.parquet"
STATS = "meta/stats.json"
INFO = "meta/info.json"
PARTS = ("data", "videos", "meta")
"""The folders of a dataset. The last folder is written after the others."""


def numbered(pattern: str, number: int, key: str = "") -> Path:
    """Return the path of a file in a dataset by its number, which counts from 0.

    `key` is the name of a video's feature.
    """
    chunk, file = divmod(number, FILES_IN_CHUNK)
    return Path(pattern.format(chunk_index=chunk, file_index=file, video_key=key))
