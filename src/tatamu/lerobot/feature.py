"""Contents of a dataset's frames: numbers with names, flags, pictures of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.errors import InputError

VIDEO = "video"
"""The type of pictures that are kept as a video."""


@dataclass(frozen=True)
class Feature:
    """One entry of every frame."""

    dtype: str
    """NumPy's name of the type of its numbers, or `VIDEO`."""
    shape: tuple[int, ...]
    """Shape in one frame."""
    names: tuple[str, ...] | None = None
    """Names of its numbers, or of the axes of a picture; None if they have none."""

    def __post_init__(self) -> None:
        """Refuse numbers that are neither single nor in a row."""
        if not self.is_video and len(self.shape) != 1:
            raise InputError(f"shape: must be of one dimension, given {self.shape}")

    @property
    def is_video(self) -> bool:
        """Whether it is a picture that is kept as a video."""
        return self.dtype == VIDEO

    def describe(self) -> dict[str, Any]:
        """Return the entry of `info.json`."""
        return {"dtype": self.dtype, "shape": list(self.shape), "names": None if self.names is None else [*self.names]}

    def checked(self, name: str, given: np.ndarray, frames: int) -> np.ndarray:
        """Return the values of an episode in the feature's type.

        Raises:
            InputError: If their shape is not (frames, *shape), or one is not finite.
        """
        array = np.asarray(given)
        if array.shape != (frames, *self.shape):
            raise InputError(f"{name}: must have the shape {(frames, *self.shape)}, given {array.shape}")
        if self.is_video and array.dtype != np.uint8:
            raise InputError(f"{name}: must be pictures of bytes, given {array.dtype}")
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise InputError(f"{name}: must be finite numbers")
        return array if self.is_video else array.astype(self.dtype)


def vector(names: Sequence[str], dtype: str = "float32") -> Feature:
    """Return the feature of numbers with names."""
    return Feature(dtype, (len(names),), tuple(names))


def flag() -> Feature:
    """Return the feature of yes or no."""
    return Feature("bool", (1,))


def camera(height: int, width: int | None = None) -> Feature:
    """Return the feature of a camera's pictures: RGB, uint8, (height, width, 3); square without a width."""
    return Feature(VIDEO, (height, height if width is None else width, 3), ("height", "width", "channels"))
