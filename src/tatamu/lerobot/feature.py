"""What the frames of a dataset contain, and its statistics, by which policies scale observations and actions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.base.errors import InputError

VIDEO = "video"
Statistics = Mapping[str, np.ndarray]
"""min, max, mean, std and quantiles in the feature's shape, and count, shape (1,)."""
QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}


@dataclass(frozen=True)
class Feature:
    """What every frame has, such as an action or a picture."""

    dtype: str
    """Name of a type in NumPy, or `VIDEO`."""
    shape: tuple[int, ...]
    """Shape in one frame."""
    names: tuple[str, ...] | None = None
    """Names of the numbers, or of a picture's axes; None if they have none."""

    def __post_init__(self) -> None:
        """Refuse numbers of several dimensions."""
        if not self.is_video and len(self.shape) != 1:
            raise InputError(f"shape: must have one dimension, given {self.shape}")

    @property
    def is_video(self) -> bool:
        """Whether the feature is a picture."""
        return self.dtype == VIDEO

    def describe(self) -> dict[str, Any]:
        """Return the feature's entry in `info.json`."""
        return {"dtype": self.dtype, "shape": list(self.shape), "names": None if self.names is None else [*self.names]}

    def checked(self, name: str, given: np.ndarray, frames: int) -> np.ndarray:
        """Return the values of one episode, converted to the feature's type.

        Raises:
            InputError: If their shape is not (frames, *shape), or a value is not finite.
        """
        array = np.asarray(given)
        if array.shape != (frames, *self.shape):
            raise InputError(f"{name}: must have the shape {(frames, *self.shape)}, given {array.shape}")
        if self.is_video and array.dtype != np.uint8:
            raise InputError(f"{name}: pictures must be arrays of uint8, given {array.dtype}")
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise InputError(f"{name}: must contain finite numbers only")
        return array if self.is_video else array.astype(self.dtype)


def vector(names: Sequence[str], dtype: str = "float32") -> Feature:
    """Return a feature of named numbers."""
    return Feature(dtype, (len(names),), tuple(names))


def flag() -> Feature:
    """Return a feature that is true or false."""
    return Feature("bool", (1,))


def camera(height: int, width: int | None = None) -> Feature:
    """Return a feature of pictures: RGB, uint8, (height, width, 3), square without a width."""
    return Feature(VIDEO, (height, height if width is None else width, 3), ("height", "width", "channels"))


def statistics(feature: Feature, values: np.ndarray) -> Statistics:
    """Return the statistics of values of shape (frames, *shape); of pictures, for each colour, from 0 to 1."""
    frames = len(values)
    # of pictures, every fourth pixel along both sides counts
    rows = values[:, ::4, ::4].reshape(-1, 3) / 255.0 if feature.is_video else values.astype(np.float64)
    shape = (3, 1, 1) if feature.is_video else feature.shape
    found = {"min": rows.min(axis=0), "max": rows.max(axis=0), "mean": rows.mean(axis=0), "std": rows.std(axis=0)}
    found |= zip(QUANTILES, np.quantile(rows, list(QUANTILES.values()), axis=0), strict=True)
    return {**{name: np.asarray(value).reshape(shape) for name, value in found.items()}, "count": np.array([frames])}


def joined(episodes: Sequence[Statistics]) -> Statistics:
    """Return the statistics of episodes together. Quantiles are weighted means of the episodes' quantiles."""
    counts = np.array([int(each["count"][0]) for each in episodes])
    weights = counts / counts.sum()

    def mean(name: str) -> np.ndarray:
        return np.asarray(np.tensordot(weights, np.stack([each[name] for each in episodes]), axes=1))

    middle = mean("mean")
    spread = np.stack([each["std"] ** 2 + (each["mean"] - middle) ** 2 for each in episodes])
    return {
        "min": np.min([each["min"] for each in episodes], axis=0),
        "max": np.max([each["max"] for each in episodes], axis=0),
        "mean": middle,
        "std": np.sqrt(np.tensordot(weights, spread, axes=1)),
        **{name: mean(name) for name in QUANTILES},
        "count": np.array([int(counts.sum())]),
    }
