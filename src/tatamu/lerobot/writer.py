"""Write a LeRobotDataset v3.0, episode by episode. Its folder appears when the dataset is complete."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.extras import needed
from tatamu.base.files import sibling, write_json, writing
from tatamu.lerobot import files
from tatamu.lerobot.feature import Feature, Statistics, joined, statistics
from tatamu.lerobot.files import Files, NumberWriter, table_of
from tatamu.lerobot.video import VideoWriter, check_codec

USUAL: Mapping[str, Feature] = {
    "timestamp": Feature("float32", (1,)),
    **{name: Feature("int64", (1,)) for name in ("frame_index", "episode_index", "index", "task_index")},
}
"""Features that every dataset has. The writer sets their values."""


class LeRobotWriter:
    """A dataset that is being written.

    A `with` statement finishes it at its end, or removes it after an error.
    """

    def __init__(
        self,
        root: Path | str,
        fps: int,
        features: Mapping[str, Feature],
        robot: str | None = None,
        *,
        data_mib: float = files.DATA_MIB,
        video_mib: float = files.VIDEO_MIB,
    ) -> None:
        """Start a dataset.

        Args:
            root: Folder of the dataset. It must be empty or not exist.
            fps: Frames per second.
            features: Contents of each frame by LeRobot's names, such as "observation.state", "action" and
                "observation.images.top". The features in `USUAL` are added.
            robot: Type of the robot; None if there is no robot.
            data_mib: Size of a file with numbers at which the next file is started [MiB].
            video_mib: Size of a video at which the next video is started [MiB].

        Raises:
            InputError: If the folder contains something or cannot be written, or a package or an encoder is missing.
        """
        self.root = Path(root)
        self.fps = fps
        self.features = {**features, **USUAL}
        self.episodes = 0
        self.frames = 0
        self._robot = robot
        needed("pyarrow", "dataset")
        if any(feature.is_video for feature in features.values()):
            check_codec()
        if self.root.exists() and (not self.root.is_dir() or any(self.root.iterdir())):
            raise InputError(f"{self.root}: must be a new folder, but already exists; give another folder")
        self._building = sibling(self.root)
        self._tasks: dict[str, int] = {}
        self._rows: list[dict[str, Any]] = []
        self._statistics: list[dict[str, Statistics]] = []
        self._numbers = Files(self._building, files.DATA, data_mib, NumberWriter)
        self._videos: dict[str, Files] = {}
        for name, feature in features.items():
            if feature.is_video:
                start = partial(VideoWriter, fps=fps, height=feature.shape[0], width=feature.shape[1])
                self._videos[name] = Files(self._building, files.VIDEOS, video_mib, start, name)

    def add_episode(self, values: Mapping[str, np.ndarray], task: str, about: Mapping[str, Any] | None = None) -> None:
        """Append an episode.

        Args:
            values: Values of each feature, shape (frames, *shape of the feature); pictures are uint8.
            task: The task as text, such as "Fold the towel in half."
            about: Additional columns of the table of episodes, with plain values or None. Every episode must have the
                same columns.

        Raises:
            InputError: If a feature is missing or unknown, has another shape, or a file cannot be written.
        """
        own = {name: feature for name, feature in self.features.items() if name not in USUAL}
        if set(values) != set(own):
            raise InputError(f"values: must have the features {', '.join(own)}, given {', '.join(values) or 'none'}")
        frames = len(next(iter(values.values())))
        if not frames:
            raise InputError("values: must have at least one frame, given none")
        numbers = np.arange(frames)
        usual = {
            "timestamp": numbers / self.fps,
            "frame_index": numbers,
            "episode_index": np.full(frames, self.episodes),
            "index": self.frames + numbers,
            "task_index": np.full(frames, self._tasks.setdefault(task, len(self._tasks))),
        }
        given = {**values, **{name: column[:, None] for name, column in usual.items()}}
        whole = {name: feature.checked(name, given[name], frames) for name, feature in self.features.items()}
        row: dict[str, Any] = {
            "episode_index": self.episodes,
            "tasks": [task],
            "length": frames,
            "dataset_from_index": self.frames,
            "dataset_to_index": self.frames + frames,
            "meta/episodes/chunk_index": 0,
            "meta/episodes/file_index": 0,
        }
        places = {"data": self._numbers.add({name: whole[name] for name in whole if name not in self._videos})}
        places |= {f"videos/{name}": video.add(whole[name]) for name, video in self._videos.items()}
        row |= {f"{kind}/{name}": value for kind, place in places.items() for name, value in place.items()}
        found = {name: statistics(feature, whole[name]) for name, feature in self.features.items()}
        row |= {f"stats/{name}/{kind}": value.tolist() for name in found for kind, value in found[name].items()}
        self._rows.append({**row, **(about or {})})
        self._statistics.append(found)
        self.episodes += 1
        self.frames += frames

    def finish(self) -> Path:
        """Write the tables, move the dataset to its final folder, and return this folder.

        Raises:
            InputError: If there is no episode, or a file cannot be written.
        """
        if not self.episodes:
            raise InputError(f"{self.root}: must have at least one episode, given none")
        self._close()
        self._write_tasks()
        self._write_table(files.numbered(files.EPISODES, 0), table_of(self._rows))
        whole = {name: joined([each[name] for each in self._statistics]) for name in self.features}
        write_json(
            self._building / files.STATS,
            {name: {kind: value.tolist() for kind, value in found.items()} for name, found in whole.items()},
        )
        write_json(self._building / files.INFO, self._info())
        with writing(self.root):
            self.root.parent.mkdir(parents=True, exist_ok=True)
            if self.root.exists():
                self.root.rmdir()
            os.rename(self._building, self.root)
        return self.root

    def __enter__(self) -> Self:
        """Return the writer itself."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None) -> None:
        """Finish the dataset, or remove it after an error."""
        try:
            if kind is None:
                self.finish()
        finally:  # remove an unfinished dataset; a finished one has another place
            with suppress(InputError):
                self._close()
            shutil.rmtree(self._building, ignore_errors=True)

    def _close(self) -> None:
        for each in (self._numbers, *self._videos.values()):
            each.close()

    def _info(self) -> dict[str, Any]:
        features = {name: feature.describe() for name, feature in self.features.items()}
        for name in self._videos:
            height, width, channels = self.features[name].shape
            features[name]["info"] = {
                "video.height": height,
                "video.width": width,
                "video.channels": channels,
                "video.fps": self.fps,
                "video.codec": "av1",
                "video.pix_fmt": "yuv420p",
                "is_depth_map": False,
                "has_audio": False,
            }
        return {
            "codebase_version": files.VERSION,
            "robot_type": self._robot,
            "total_episodes": self.episodes,
            "total_frames": self.frames,
            "total_tasks": len(self._tasks),
            "chunks_size": files.FILES_IN_CHUNK,
            "data_files_size_in_mb": files.DATA_MIB,
            "video_files_size_in_mb": files.VIDEO_MIB,
            "fps": self.fps,
            "splits": {"train": f"0:{self.episodes}"},
            "data_path": files.DATA,
            "video_path": files.VIDEOS if self._videos else None,
            "features": features,
        }

    def _write_tasks(self) -> None:
        """Write the table of tasks in the format of pandas. The column `task` is the index of the table."""
        columns = {"task_index": list(self._tasks.values()), "task": list(self._tasks)}
        kinds = {"task_index": ("int64", "int64"), "task": ("unicode", "object")}
        described = [
            {"name": name, "field_name": name, "pandas_type": kind, "numpy_type": numpy, "metadata": None}
            for name, (kind, numpy) in kinds.items()
        ]
        pandas = {"index_columns": ["task"], "column_indexes": [], "columns": described, "pandas_version": "2.0.0"}
        table = needed("pyarrow", "dataset").table(columns).replace_schema_metadata({"pandas": json.dumps(pandas)})
        self._write_table(Path(files.TASKS), table)

    def _write_table(self, file: Path, table: Any) -> None:
        path, parquet = self._building / file, needed("pyarrow.parquet", "dataset")
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            with path.open("wb") as opened:
                parquet.write_table(table, opened)
