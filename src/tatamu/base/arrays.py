"""Types for arrays in records: read-only, validated when a record is made, plain lists in files."""

from __future__ import annotations

import sys
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field, PlainSerializer

MAX_COORDINATE = 1e3
"""Maximum coordinate or displacement [m]. A larger value is probably in another unit."""


def is_finite_number(value: object) -> bool:
    """Return whether a value from a file is a number that a float can have. Integers in files have any size."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= sys.float_info.max


def _floats(value: Any) -> np.ndarray:
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ValueError("must be a list of points [x, y, z] in metres") from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise ValueError(f"must be a list of points [x, y, z], given an array of shape {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(
            f"must contain finite numbers, given nan or infinity in row {int(np.argmin(np.isfinite(array).all(1)))}"
        )
    if np.abs(array).max(initial=0.0) > MAX_COORDINATE:
        raise ValueError(f"must lie within {MAX_COORDINATE:g} m of the origin, given {np.abs(array).max():g} m")
    array.setflags(write=False)
    return array


def _indices(value: Any, width: int, what: str) -> np.ndarray:
    try:
        array = np.array(value if len(value) else np.empty((0, width)))
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"must be a list of {what}") from None
    if array.ndim != 2 or array.shape[1] != width:
        raise ValueError(f"must be a list of {what}, given an array of shape {array.shape}")
    exact = 2**53  # floating point numbers represent all whole numbers below exactly
    if array.dtype.kind not in "iuf" or not (np.abs(array) < exact).all():
        raise ValueError(f"must be a list of {what} of whole numbers")
    whole = array.astype(np.int64)
    if not (whole == array).all():
        raise ValueError(f"must be a list of {what} of whole numbers")
    whole.setflags(write=False)
    return whole


def _faces(value: Any) -> np.ndarray:
    return _indices(value, 3, "triples [i, j, k]")


def edges(value: Any) -> np.ndarray:
    """Return the e edges of a mesh as pairs of vertex indices, shape (e, 2), also of an empty list."""
    return _indices(value, 2, "pairs [i, j]")


def _plain(array: np.ndarray) -> list[Any]:
    return array.tolist()


Points = Annotated[np.ndarray, BeforeValidator(_floats), PlainSerializer(_plain)]
Triangles = Annotated[np.ndarray, BeforeValidator(_faces), PlainSerializer(_plain)]
Edges = Annotated[np.ndarray, BeforeValidator(edges), PlainSerializer(_plain)]
Index = Annotated[int, Field(ge=0, strict=True)]
