"""A world: one draw of all that is not known. Worlds of one seed are common to all folds that are compared in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from scipy.stats import norm, qmc

from tatamu.disturbances.description import FIELDS, Disturbances

DIRECTIONS = ("along", "across", "up")


@dataclass(frozen=True)
class Channel:
    """One thing that may be off, by a number that is drawn from a normal distribution."""

    name: str
    """As in `margins.json`, such as "hands.offset.up"."""
    unit: str
    """m, rad or s; 1 where the number is the logarithm of a factor."""

    @property
    def relative(self) -> bool:
        """Whether the number is the logarithm of a factor."""
        return self.unit == "1"

    def shown(self, value: float) -> float:
        """A number as people read it: in its unit, or as a relative change."""
        return float(np.expm1(value)) if self.relative else value


CHANNELS = (
    *(Channel(f"hands.offset.{direction}", "m") for direction in DIRECTIONS),
    *(Channel(f"hands.difference.{direction}", "m") for direction in DIRECTIONS),
    Channel("hands.yaw", "rad"),
    Channel("hands.opening_delay", "s"),
    Channel("hands.speed", "1"),
    Channel("grasp.along.left", "m"),
    Channel("grasp.along.right", "m"),
    Channel("grasp.into.left", "m"),
    Channel("grasp.into.right", "m"),
    Channel("cloth.place.along", "m"),
    Channel("cloth.place.across", "m"),
    Channel("cloth.yaw", "rad"),
    Channel("table.height", "m"),
    *(Channel(f"material.{name}", "1") for name in FIELDS),
)
"""Everything that may be off. Worlds draw them in this order: append only, or all worlds change."""
PLACES = {channel.name: number for number, channel in enumerate(CHANNELS)}


DIMENSIONS = 64
"""Of the Sobol sequence, more than there are channels: a scramble of another dimension would change all worlds."""


class Stream(IntEnum):
    """Purposes of worlds. Folds are not judged in the worlds in which they were learned."""

    LEARNING = 0
    JUDGING = 1
    """When a study chooses and says how sure its fold is."""
    MARGINS = 2


@dataclass(frozen=True)
class World:
    """How far everything is off in one draw."""

    values: Mapping[str, float]
    """By the names of `CHANNELS`; relative ones as logarithms of factors. What is left out is as it should be."""

    def __getitem__(self, name: str) -> float:
        return self.values.get(name, 0.0)

    def factor(self, name: str) -> float:
        """The factor of a relative number."""
        return float(np.exp(self[name]))

    @property
    def calm(self) -> bool:
        """Whether nothing is off."""
        return not any(self.values.values())

    def vector(self, prefix: str) -> np.ndarray:
        """Along the fold, across, up [m], shape (3,)."""
        return np.array([self[f"{prefix}.{direction}"] for direction in DIRECTIONS])


CALM = World({})
"""Everything is as it should be."""


def deviations(disturbances: Disturbances) -> dict[str, float]:
    """Standard deviation of everything that is not known exactly, by the names of `CHANNELS`."""
    hands = disturbances.hands
    found = {
        **dict(zip((f"hands.offset.{d}" for d in DIRECTIONS), hands.offset, strict=True)),
        **dict(zip((f"hands.difference.{d}" for d in DIRECTIONS), hands.difference, strict=True)),
        "hands.yaw": hands.yaw,
        "hands.opening_delay": hands.opening_delay,
        "hands.speed": hands.speed,
        **{f"grasp.along.{side}": disturbances.grasp.along for side in ("left", "right")},
        **{f"grasp.into.{side}": disturbances.grasp.into for side in ("left", "right")},
        **dict(zip(("cloth.place.along", "cloth.place.across"), disturbances.cloth.place, strict=True)),
        "cloth.yaw": disturbances.cloth.yaw,
        "table.height": disturbances.table.height,
        **{f"material.{name}": deviation for name, deviation in disturbances.material.items()},
    }
    return {channel.name: found[channel.name] for channel in CHANNELS if found.get(channel.name, 0.0) > 0.0}


def drawn(disturbances: Disturbances, count: int, seed: int, stream: Stream) -> list[World]:
    """Independent worlds; each has its own stream of random numbers, so that the first ones do not depend on `count`.

    Args:
        disturbances: What is not known, and how far it may be off.
        count: How many worlds.
        seed: The same seed gives the same worlds.
        stream: What they are for; worlds of different streams are independent.
    """
    rows = [
        np.random.default_rng(np.random.SeedSequence([seed, stream, number])).standard_normal(len(CHANNELS))
        for number in range(count)
    ]
    return worlds_of(disturbances, rows)


def spread(disturbances: Disturbances, count: int, seed: int, stream: Stream) -> list[World]:
    """Worlds spread evenly over what may be, from a scrambled Sobol sequence: fewer do for an expectation.

    The first ones do not depend on `count`; see `drawn` for the arguments.
    """
    generator = np.random.default_rng(np.random.SeedSequence([seed, stream]))
    engine = qmc.Sobol(DIMENSIONS, scramble=True, rng=generator)
    even = engine.random_base2(max(0, int(np.ceil(np.log2(count)))))[:count, : len(CHANNELS)]
    return worlds_of(disturbances, norm.ppf(np.clip(even, 1e-9, 1.0 - 1e-9)))


def worlds_of(disturbances: Disturbances, rows: Sequence[np.ndarray] | np.ndarray) -> list[World]:
    """Worlds of standard normal numbers, one for each of `CHANNELS`, shape (n, k)."""
    scales = deviations(disturbances)
    mixing = _mixing(disturbances)
    return [
        World({name: float(scales[name] * row[PLACES[name]]) for name in scales})
        for row in (mixing @ row for row in rows)
    ]


def _mixing(disturbances: Disturbances) -> np.ndarray:
    """The root of the correlation matrix of all channels, shape (k, k)."""
    mixing = np.eye(len(CHANNELS))
    correlation = disturbances.correlation
    if correlation is not None and correlation.parameters:
        rows = [PLACES[f"material.{name}"] for name in correlation.parameters]
        values, vectors = np.linalg.eigh(np.array(correlation.matrix))
        root = vectors * np.sqrt(np.clip(values, 0.0, None)) @ vectors.T
        mixing[np.ix_(rows, rows)] = root / np.linalg.norm(root, axis=1, keepdims=True)
    return mixing
