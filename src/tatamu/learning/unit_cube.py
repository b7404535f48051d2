"""The search space as the unit cube, in which samplers think."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from optuna.distributions import BaseDistribution, FloatDistribution, IntDistribution


class UnitCube:
    """Parameters as points of the unit cube; whole numbers as the middles of equal parts of a side.

    Parameters of a single value have no side of the cube, but are among the parameters of every point.
    """

    def __init__(self, space: Mapping[str, BaseDistribution]) -> None:
        """Make the cube of a search space of float and int distributions."""
        for name, distribution in space.items():
            if not isinstance(distribution, FloatDistribution | IntDistribution):
                raise ValueError(f"{name}: must be a float or an int distribution, given {distribution}")
        self._single = {name: each.low for name, each in space.items() if each.single()}  # type: ignore[attr-defined]
        self._names = sorted(space.keys() - self._single.keys())
        bounds = [space[name] for name in self._names]
        self._whole = np.array([isinstance(each, IntDistribution) for each in bounds])
        self._low = np.array([float(each.low) for each in bounds])  # type: ignore[attr-defined]
        self._high = np.array([float(each.high) for each in bounds])  # type: ignore[attr-defined]
        self._size = self._high - self._low + self._whole  # n whole numbers share a side of length n

    @property
    def dimensions(self) -> int:
        """How many parameters have more than a single value."""
        return len(self._names)

    def points(self, parameters: Sequence[Mapping[str, Any]]) -> np.ndarray:
        """Points of parameters, shape (n, d)."""
        rows = np.array([[float(each[name]) for name in self._names] for each in parameters])
        rows = rows.reshape(len(parameters), self.dimensions)
        return (rows - self._low + 0.5 * self._whole) / self._size

    def snapped(self, points: np.ndarray) -> np.ndarray:
        """The nearest points that stand for parameters, shape (p, d)."""
        inside = np.clip(points, 0.0, 1.0)
        middles = (np.minimum(np.floor(inside * self._size), self._size - 1.0) + 0.5) / self._size
        return np.where(self._whole, middles, inside)

    def values(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """Parameters of snapped points by name, each of shape (p,)."""
        values = self._low + points * self._size - 0.5 * self._whole
        values[:, self._whole] = np.round(values[:, self._whole])
        values = np.clip(values, self._low, self._high)  # low + (high - low) may be the next number above high
        single = {name: np.full(len(points), float(value)) for name, value in self._single.items()}
        return {**dict(zip(self._names, values.T, strict=True)), **single}

    def parameters(self, point: np.ndarray) -> dict[str, float | int]:
        """Parameters of one snapped point, shape (d,)."""
        values = self.values(point[None])
        searched = {
            name: int(values[name][0]) if whole else float(values[name][0])
            for name, whole in zip(self._names, self._whole, strict=True)
        }
        return {**searched, **self._single}
