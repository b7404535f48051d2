"""Contents of a dataset's frames: numbers with names, flags, and pictures of cameras."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.base.errors import InputError

VIDEO = "video"
"""Type of pictures that are stored as a video."""


@dataclass(frozen=True)
class Feature:
    """A feature: one entry that every frame of a dataset has, such as an action or a picture."""

    dtype: str
    """Type of the feature's numbers, by its name in NumPy; or `VIDEO`."""
    shape: tuple[int, ...]
    """Shape of the feature's array in one frame."""
    names: tuple[str, ...] | None = None
    """Names of the feature's numbers, or of the axes of a picture; None if the numbers have no names."""

    def __post_init__(self) -> None:
        """Check that the feature's shape has exactly one dimension, unless the feature is a picture."""
        if not self.is_video and len(self.shape) != 1:
            raise InputError(f"shape: must be of one dimension, given {self.shape}")

    @property
    def is_video(self) -> bool:
        """Whether the feature is a picture that is stored as a video."""
        return self.dtype == VIDEO

    def describe(self) -> dict[str, Any]:
        """Return the feature's entry in `info.json`."""
        return {"dtype": self.dtype, "shape": list(self.shape), "names": None if self.names is None else [*self.names]}

    def checked(self, name: str, given: np.ndarray, frames: int) -> np.ndarray:
        """Check the feature's values in one episode, and return them, converted to the feature's type.

        Raises:
            InputError: If the shape of the values is not (frames, *shape), or a value is not finite.
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
    """Return a feature for numbers with the given names."""
    return Feature(dtype, (len(names),), tuple(names))


def flag() -> Feature:
    """Return a feature for a flag, which is true or false."""
    return Feature("bool", (1,))


def camera(height: int, width: int | None = None) -> Feature:
    """Return a feature for a camera's pictures: RGB, uint8, (height, width, 3).

    Without a width, the pictures are square.
    """
    return Feature(VIDEO, (height, height if width is None else width, 3), ("height", "width", "channels"))
