"""What the frames of a dataset contain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tatamu.base.errors import InputError

VIDEO = "video"


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
            raise InputError(f"{name}: must be pictures of 8-bit numbers, given {array.dtype}")
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            raise InputError(f"{name}: must be finite numbers")
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
