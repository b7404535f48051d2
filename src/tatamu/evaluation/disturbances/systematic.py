"""Systematic and random parts of disturbances.

A disturbance with the variance v and the systematic share a is the sum of two independent normal numbers. The first has
the variance a v and is constant for a set-up (one robot, garment and table). The second has the variance (1 - a) v and
is drawn for each fold, independently of all others. All correlations are therefore those of the systematic parts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from tatamu.evaluation.disturbances.channels import CHANNELS, PLACES, prefix_in
from tatamu.evaluation.disturbances.description import OWN, Correlation, Disturbances, read_disturbances
from tatamu.evaluation.disturbances.scenario import correlations_root, deviations


@dataclass(frozen=True)
class Split:
    """The systematic and the random parts of k disturbances, in the order of `names`."""

    names: tuple[str, ...]
    """Names, from `CHANNELS`, of those with a standard deviation above 0 or a mean that is not 0."""
    mean: np.ndarray
    """Means, shape (k,)."""
    systematic: np.ndarray
    """Covariance of the systematic parts, shape (k, k)."""
    random: np.ndarray
    """Variances of the random parts, shape (k,)."""

    @property
    def deviations(self) -> np.ndarray:
        """Standard deviations of both parts together, shape (k,)."""
        return np.asarray(np.sqrt(np.diag(self.systematic) + self.random))


@cache
def _usual() -> Disturbances:
    return read_disturbances(OWN / "systematic.toml")


def share(disturbances: Disturbances, name: str) -> float:
    """Return the systematic share of a disturbance's variance, by default that of `systematic.toml`."""
    for shares in (disturbances.systematic, _usual().systematic):
        known = prefix_in(name, shares)
        if known is not None:
            return shares[known]
    return 0.0


def split(disturbances: Disturbances) -> Split:
    """Return both parts of disturbances."""
    scales = deviations(disturbances)
    names = tuple(channel.name for channel in CHANNELS if channel.name in scales or disturbances.mean.get(channel.name))
    places = [PLACES[name] for name in names]
    scale = np.array([scales.get(name, 0.0) for name in names])
    root = correlations_root(disturbances)[places]
    whole = root @ root.T * np.outer(scale, scale)
    random = np.array([1.0 - share(disturbances, name) for name in names]) * scale**2
    mean = np.array([disturbances.mean.get(name, 0.0) for name in names])
    return Split(names, mean, whole - np.diag(random), random)


def join(parts: Split, others: Disturbances) -> Disturbances:
    """Return disturbances from their parts, with the fingers of others: the inverse of `split`, to six digits."""
    deviation = dict(zip(parts.names, map(_rounded, parts.deviations), strict=True))
    tables: dict[str, dict[str, Any]] = {}
    for channel in CHANNELS:
        table, field, *part = channel.name.split(".")
        fields, value = tables.setdefault(table, {}), deviation.get(channel.name, 0.0)
        if part:
            fields[field] = [*fields.get(field, []), value]
        elif table != "material" or channel.name in deviation:
            fields[field] = value
    plain: dict[str, Any] = {
        **tables,
        "mean": {name: _rounded(value) for name, value in zip(parts.names, parts.mean, strict=True) if value},
        "systematic": {
            name: _rounded(variance / value**2)
            for name, variance, value in zip(parts.names, np.diag(parts.systematic), parts.deviations, strict=True)
            if value
        },
        "fingers": others.fingers.model_dump(exclude_defaults=True),
    }
    return Disturbances.model_validate({**plain, "correlation": _correlation(parts)})


def _correlation(parts: Split) -> Correlation | None:
    whole = parts.systematic + np.diag(parts.random)
    scale = np.sqrt(np.diag(whole))
    used = np.flatnonzero(scale)
    matrix = whole[np.ix_(used, used)] / np.outer(scale[used], scale[used])
    np.fill_diagonal(matrix, 1.0)
    if not len(used) or np.abs(matrix - np.eye(len(used))).max() < 1e-9:
        return None
    rows = [[round(float(value), 6) for value in row] for row in 0.5 * (matrix + matrix.T)]
    return Correlation(parameters=[parts.names[place] for place in used], matrix=rows)


def _rounded(value: float) -> float:
    return float(f"{value:.6g}")
