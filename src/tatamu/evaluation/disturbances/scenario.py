"""Scenarios: a value of every disturbance. Folds that are compared are simulated in the same scenarios."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from tatamu.evaluation.disturbances.channels import CHANNELS, DIRECTIONS, PARTS, PLACES
from tatamu.evaluation.disturbances.description import Disturbances


class Stream(IntEnum):
    """What random scenarios are for, each with its own random numbers."""

    JUDGING = 1
    """The success of the best fold of a study."""
    MARGINS = 2
    OBSERVATION = 3


@dataclass(frozen=True)
class Scenario:
    """A scenario: the value of every disturbance."""

    values: Mapping[str, float]
    """Values by the names of `CHANNELS`. Relative values are logarithms of factors, and missing values are 0."""

    def __getitem__(self, name: str) -> float:
        return self.values.get(name, 0.0)

    def factor(self, name: str) -> float:
        """Return the factor of a relative disturbance."""
        return float(np.exp(self[name]))

    @property
    def is_nominal(self) -> bool:
        return not any(self.values.values())

    def vector(self, prefix: str) -> np.ndarray:
        """Return the disturbances PREFIX.along, .across and .up as a displacement [m], shape (3,)."""
        return np.array([self[f"{prefix}.{direction}"] for direction in DIRECTIONS])


NOMINAL = Scenario({})


def deviations(disturbances: Disturbances) -> dict[str, float]:
    """Return the standard deviations above 0, by the names of `CHANNELS`."""
    found = {channel.name: _deviation(disturbances, channel.name) for channel in CHANNELS}
    return {name: deviation for name, deviation in found.items() if deviation > 0.0}


def _deviation(disturbances: Disturbances, name: str) -> float:
    table, field, *part = name.split(".")
    given = getattr(disturbances, table)
    value = given.get(field, 0.0) if table == "material" else getattr(given, field)
    return float(value[PARTS[part[0]]] if isinstance(value, list) else value)


def mean_scenario(disturbances: Disturbances) -> Scenario:
    """Return the scenario in which every disturbance has its mean."""
    means = disturbances.mean
    return Scenario({channel.name: means[channel.name] for channel in CHANNELS if means.get(channel.name)})


def sample_scenarios(disturbances: Disturbances, count: int, seed: int, stream: Stream) -> list[Scenario]:
    """Draw independent scenarios. Each has its own random numbers, so the first ones are the same for any `count`."""
    rows = [
        np.random.default_rng(np.random.SeedSequence([seed, stream, number])).standard_normal(len(CHANNELS))
        for number in range(count)
    ]
    return scenarios_of(disturbances, rows)


def scenarios_of(disturbances: Disturbances, rows: Sequence[np.ndarray] | np.ndarray) -> list[Scenario]:
    """Return n scenarios from standard normal numbers, shape (n, k), a column for each of the k disturbances."""
    scales = deviations(disturbances)
    means = mean_scenario(disturbances).values
    mixing = correlations_root(disturbances)
    return [
        Scenario({**means, **{name: means.get(name, 0.0) + float(scales[name] * row[PLACES[name]]) for name in scales}})
        for row in (mixing @ row for row in rows)
    ]


def correlations_root(disturbances: Disturbances) -> np.ndarray:
    """Return a matrix B, shape (k, k), so that B B' is the correlation matrix of the k disturbances."""
    mixing = np.eye(len(CHANNELS))
    correlation = disturbances.correlation
    if correlation is not None and correlation.parameters:
        rows = [PLACES[name if name in PLACES else f"material.{name}"] for name in correlation.parameters]
        values, vectors = np.linalg.eigh(np.array(correlation.matrix))
        root = vectors * np.sqrt(np.clip(values, 0.0, None)) @ vectors.T
        mixing[np.ix_(rows, rows)] = root / np.linalg.norm(root, axis=1, keepdims=True)
    return mixing
