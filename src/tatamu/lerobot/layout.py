"""The files of a LeRobotDataset v3.0.

Names, sizes and columns are those of LeRobot 0.6.1, datasets/utils.py and datasets/dataset_writer.py (Apache-2.0).
"""

from __future__ import annotations

from pathlib import Path

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
