"""The search space: named parameters with bounds, and the unit cube in which searches compute."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from numbers import Real
from typing import Any

import numpy as np

from tatamu.base.errors import InputError

Parameters = dict[str, int | float]
"""A point of a search space, by the names of its parameters. Whole numbers have the type `int`."""
KnownPart = Callable[[Mapping[str, np.ndarray]], np.ndarray]
"""Computes the part of an objective that needs no simulation, shape (p,), from the p values of each parameter."""


@dataclass(frozen=True)
class Bounds:
    """The range of one parameter."""

    low: float
    high: float
    whole: bool = False

    @property
    def single(self) -> bool:
        """Whether only one value is allowed."""
        return self.low == self.high

    def nearest(self, value: float) -> int | float:
        inside = min(max(value, self.low), self.high)
        return round(inside) if self.whole else float(inside)

    def check(self, name: str, value: Any) -> None:
        """Raise an InputError that begins with `name` if a value is not a number within the bounds."""
        slack = 1e-9 * (self.high - self.low)  # for rounding errors
        number = isinstance(value, Real) and not isinstance(value, bool)
        if not number or not self.low - slack <= value <= self.high + slack or (self.whole and value != int(value)):
            kind = "a whole number" if self.whole else "a number"
            raise InputError(f"{name}: must be {kind} from {self.low:g} to {self.high:g}, given {value!r}")


@dataclass(frozen=True, eq=False)
class Space:
    """Named parameters with bounds, and the unit cube that represents them.

    Each parameter with more than one value has its own axis. For whole numbers, the side of the cube is divided into
    equal parts, whose middles represent the numbers.
    """

    bounds: Mapping[str, Bounds]
    known_part: KnownPart | None = field(default=None, kw_only=True)

    def middle(self) -> Parameters:
        return {name: each.nearest(0.5 * (each.low + each.high)) for name, each in self.bounds.items()}

    def random(self, seed: int) -> Parameters:
        """Return parameters drawn uniformly, the same as Optuna's `RandomSampler` for this seed."""
        generator = np.random.RandomState(seed)
        drawn: Parameters = {}
        for name, each in self.bounds.items():
            half = 0.5 * each.whole
            value = each.low if each.single else float(generator.uniform(each.low - half, each.high + half))
            drawn[name] = each.nearest(value)
        return drawn

    def check(self, parameters: Mapping[str, Any]) -> None:
        """Raise an InputError that names the parameter which is missing, unknown, or outside its bounds."""
        if wrong := next(iter(set(parameters) ^ set(self.bounds)), None):
            raise InputError(f"parameters: must be {', '.join(self.bounds)}, but {wrong} is missing or unknown")
        for name, each in self.bounds.items():
            each.check(name, parameters[name])

    @cached_property
    def _names(self) -> list[str]:
        """Parameters with more than one value, in the order of the cube's axes."""
        return sorted(name for name, each in self.bounds.items() if not each.single)

    @cached_property
    def _whole(self) -> np.ndarray:
        return np.array([self.bounds[name].whole for name in self._names])

    @cached_property
    def _low(self) -> np.ndarray:
        return np.array([float(self.bounds[name].low) for name in self._names])

    @cached_property
    def _high(self) -> np.ndarray:
        return np.array([float(self.bounds[name].high) for name in self._names])

    @cached_property
    def _size(self) -> np.ndarray:
        return self._high - self._low + self._whole  # n whole numbers share a side of length n

    @property
    def dimensions(self) -> int:
        return len(self._names)

    def points(self, parameters: Sequence[Mapping[str, Any]]) -> np.ndarray:
        """Return the points of the unit cube that represent n sets of parameters, shape (n, d)."""
        rows = np.array([[float(each[name]) for name in self._names] for each in parameters])
        rows = rows.reshape(len(parameters), self.dimensions)
        return np.asarray((rows - self._low + 0.5 * self._whole) / self._size)

    def snap(self, points: np.ndarray) -> np.ndarray:
        """Return the nearest point with allowed parameters to each of p points, shape (p, d)."""
        inside = np.clip(points, 0.0, 1.0)
        middles = (np.minimum(np.floor(inside * self._size), self._size - 1.0) + 0.5) / self._size
        return np.where(self._whole, middles, inside)

    def values(self, points: np.ndarray) -> dict[str, np.ndarray]:
        """Return the p values of each parameter, shape (p,), at points from `snap`, shape (p, d)."""
        values = self._low + points * self._size - 0.5 * self._whole
        values[:, self._whole] = np.round(values[:, self._whole])
        values = np.clip(values, self._low, self._high)  # low + (high - low) may be rounded to a number above high
        single = {n: np.full(len(points), float(each.low)) for n, each in self.bounds.items() if each.single}
        return {**dict(zip(self._names, values.T, strict=True)), **single}

    def parameters(self, point: np.ndarray) -> Parameters:
        """Return the parameters at a point from `snap`."""
        values = self.values(point[None])
        searched = {
            name: int(values[name][0]) if whole else float(values[name][0])
            for name, whole in zip(self._names, self._whole, strict=True)
        }
        return {**searched, **{name: each.low for name, each in self.bounds.items() if each.single}}
