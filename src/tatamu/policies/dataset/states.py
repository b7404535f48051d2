"""States in the format Zarr 3.

Arrays are padded to the longest episode and the largest cloth. A shard, which is one file, contains whole episodes and
is written once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil, prod
from pathlib import Path
from typing import Any

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.extras import needed
from tatamu.base.files import foreign, writing
from tatamu.policies.dataset.episode import Episode

SHARD = 16 << 20
"""Largest size of a shard before compression [bytes]."""
MAX_IN_SHARD = 64
FRAMES = 16
"""Frames in a chunk, which is read at once."""
GAP: Mapping[str, Any] = {"f": np.nan, "i": -1, "b": False, "u": 0}
"""Values of padding, by the kind of numbers."""
PER_FRAME = ("positions", "key_points", "hands", "mask", "state", "action", "reward")
"""Arrays with a row for each frame or action."""


@dataclass(frozen=True)
class Extent:
    """A shape that is large enough for an array of every episode, and its type."""

    shape: tuple[int, ...]
    dtype: np.dtype[Any]


def extend(extents: dict[str, Extent], episode: Episode) -> None:
    """Enlarge the extents of all arrays for another episode."""
    for name in (*PER_FRAME, "faces"):
        if name in episode.arrays:
            array = episode.arrays[name]
            known = extents.get(name, Extent(array.shape, array.dtype))
            extents[name] = Extent(tuple(map(max, known.shape, array.shape)), known.dtype)


class StateWriter:
    """A Zarr group that is being written."""

    def __init__(self, root: Path, count: int, extents: Mapping[str, Extent], about: Mapping[str, Any]) -> None:
        """Create the arrays of `count` episodes, in a group with the attributes `about`.

        Raises:
            InputError: If the folder cannot be written, or zarr is not installed.
        """
        self._root = root
        self._extents = extents
        self._count = count
        self._lengths: list[int] = []
        self._successes: list[bool] = []
        self._waiting: dict[str, list[np.ndarray]] = {name: [] for name in extents}
        zarr = needed("zarr", "dataset")
        with writing(root):
            self._group = zarr.create_group(store=str(root), attributes=dict(about))
            self._arrays = {name: _create(self._group, name, count, extent) for name, extent in extents.items()}

    def add(self, episode: Episode) -> None:
        """Append an episode. The last one completes the group."""
        self._lengths.append(episode.record.frames)
        self._successes.append(episode.record.success)
        done = len(self._lengths)
        with writing(self._root):
            for name, array in self._arrays.items():
                waiting = self._waiting[name]
                waiting.append(_padded(episode.arrays[name], self._extents[name]))
                if len(waiting) == array.shards[0] or done == self._count:
                    array[done - len(waiting) : done] = np.stack(waiting)
                    waiting.clear()
            if done == self._count:
                self._group.create_array("length", data=np.array(self._lengths))
                self._group.create_array("success", data=np.array(self._successes))


def read_states(root: Path, episode: int, names: Sequence[str]) -> dict[str, np.ndarray]:
    """Return arrays of an episode without their padding.

    Raises:
        InputError: If there is no such array or episode, or the group is broken.
    """
    zarr = needed("zarr", "dataset")
    with foreign(root, "a Zarr 3 group"):
        # the codecs of Zarr 2 can run code, and consolidated metadata can describe arrays of Zarr 2
        group = zarr.open_group(store=str(root), mode="r", zarr_format=3, use_consolidated=False)
        if missing := [name for name in names if name not in group]:
            raise InputError(f"{root}: must contain the array {missing[0]!r}")
        for name in ("length", *names):
            _refuse_large(root, name, group[name])
        frames = int(group["length"][episode])
        return {name: _cut(group[name][episode], name, frames) for name in names}


def _refuse_large(root: Path, name: str, array: Any) -> None:
    """Raise an InputError if an episode has so many numbers or chunks that reading it would take minutes."""
    numbers, chunks = prod(array.shape[1:]), prod(map(ceil, np.divide(array.shape[1:], array.chunks[1:])))
    if numbers > 1_000_000_000 or chunks > 20_000:
        limits = "at most 1000000000 numbers and 20000 chunks"
        raise InputError(f"{root}: {name}: an episode must have {limits}, given {numbers} numbers and {chunks} chunks")


def _create(group: Any, name: str, count: int, extent: Extent) -> Any:
    size = extent.dtype.itemsize * int(np.prod(extent.shape))
    episodes = int(np.clip(SHARD // max(size, 1), 1, min(count, MAX_IN_SHARD)))
    frames = extent.shape[0]
    chunk = min(frames, FRAMES) if name in PER_FRAME else frames
    return group.create_array(
        name,
        shape=(count, *extent.shape),
        dtype=extent.dtype,
        chunks=(1, chunk, *extent.shape[1:]),
        shards=(episodes, -(-frames // chunk) * chunk, *extent.shape[1:]),
        fill_value=GAP[extent.dtype.kind],
    )


def _padded(array: np.ndarray, extent: Extent) -> np.ndarray:
    whole = np.full(extent.shape, GAP[extent.dtype.kind], extent.dtype)
    whole[tuple(map(slice, array.shape))] = array
    return whole


def _cut(array: np.ndarray, name: str, frames: int) -> np.ndarray:
    if name in PER_FRAME:
        array = array[: frames + (name not in ("action", "reward"))]
    if name in ("positions", "key_points"):
        array = array[:, np.isfinite(array[0, :, 0])]
    return array[array[:, 0] >= 0] if name == "faces" else array
