"""Distributions of numbers and of names in a specification, and random draws from them."""

from __future__ import annotations

from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, PlainSerializer, PlainValidator, model_validator

from tatamu.base.arrays import is_finite_number
from tatamu.base.records import Record
from tatamu.simulation.material import Number


class Uniform(Record):
    """A random number that is evenly distributed between two bounds."""

    low: Number
    high: Number

    @model_validator(mode="after")
    def _check(self) -> Self:
        if not self.high >= self.low:
            raise ValueError(f"low must not be above high, given low = {self.low:g} and high = {self.high:g}")
        return self


class Normal(Record):
    """A normally distributed random number. A number more than two standard deviations from the mean is drawn again."""

    mean: Number
    deviation: Annotated[Number, Field(ge=0.0)]


def _distribution(given: Any) -> float | list[float] | Uniform | Normal:
    """Return the distribution that is given in a file.

    If the given value has none of the allowed forms, one error message lists these forms.
    """
    if isinstance(given, Uniform | Normal):
        return given
    if isinstance(given, dict):
        for kind in (Uniform, Normal):
            if set(given) & set(kind.model_fields):
                return kind.model_validate(given)
    numbers = given if isinstance(given, list) else [given]
    if not numbers or not all(map(is_finite_number, numbers)):
        raise ValueError(f"must be a number, a list of numbers, {{low, high}} or {{mean, deviation}}, given {given!r}")
    return [float(each) for each in given] if isinstance(given, list) else float(given)


def _names(given: Any) -> str | list[str]:
    """Return the name or the list of names that is given in a file."""
    names = given if isinstance(given, list) else [given]
    if not names or not all(isinstance(name, str) and name for name in names):
        raise ValueError(f"must be a name, or a list of names, given {given!r}")
    return [*given] if isinstance(given, list) else str(given)


def _plain(given: Any) -> Any:
    """Return a distribution as plain data for a file."""
    return given.model_dump() if isinstance(given, Record) else given


Distribution = Annotated[
    float | list[float] | Uniform | Normal, PlainValidator(_distribution), PlainSerializer(_plain, return_type=Any)
]
"""A number, a list from which a number is drawn, a range, or a normal distribution."""
Names = Annotated[str | list[str], PlainValidator(_names)]
"""A name, or a list from which a name is drawn."""


def draw(distribution: Distribution, generator: np.random.Generator) -> float:
    """Draw a random number. A fixed number is returned unchanged."""
    if isinstance(distribution, Uniform):
        return float(generator.uniform(distribution.low, distribution.high))
    if isinstance(distribution, Normal):
        while abs(deviations := generator.standard_normal()) > 2.0:
            pass
        return float(distribution.mean + distribution.deviation * deviations)
    if isinstance(distribution, list):
        return distribution[int(generator.integers(len(distribution)))]
    return float(distribution)


def highest(distribution: Distribution) -> float:
    """Return the largest number that may be drawn from a distribution."""
    if isinstance(distribution, Uniform):
        return distribution.high
    if isinstance(distribution, Normal):
        return distribution.mean + 2.0 * distribution.deviation
    return max(distribution) if isinstance(distribution, list) else float(distribution)


def choose(names: str | list[str], generator: np.random.Generator) -> str:
    """Choose a name from a list at random. A single name is returned unchanged."""
    return names[int(generator.integers(len(names)))] if isinstance(names, list) else names
