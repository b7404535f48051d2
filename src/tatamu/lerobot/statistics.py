"""Statistics of features, by which policies scale observations and actions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from tatamu.lerobot.feature import Feature

Statistics = Mapping[str, np.ndarray]
"""min, max, mean, std and quantiles in the feature's shape, and count, shape (1,)."""
QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
EVERY = 4
"""Distance between the pixels of pictures that count, along both sides [pixels]."""


def statistics(feature: Feature, values: np.ndarray) -> Statistics:
    """Return the statistics of values of shape (frames, *shape); of pictures, for each colour, from 0 to 1."""
    frames = len(values)
    rows = values[:, ::EVERY, ::EVERY].reshape(-1, 3) / 255.0 if feature.is_video else values.astype(np.float64)
    shape = (3, 1, 1) if feature.is_video else feature.shape
    found = {"min": rows.min(axis=0), "max": rows.max(axis=0), "mean": rows.mean(axis=0), "std": rows.std(axis=0)}
    found |= zip(QUANTILES, np.quantile(rows, list(QUANTILES.values()), axis=0), strict=True)
    return {**{name: np.asarray(value).reshape(shape) for name, value in found.items()}, "count": np.array([frames])}


def joined(episodes: Sequence[Statistics]) -> Statistics:
    """Return the statistics of episodes together. Quantiles are weighted means of the episodes' quantiles."""
    counts = np.array([int(each["count"][0]) for each in episodes])
    weights = counts / counts.sum()

    def mean(name: str) -> np.ndarray:
        return np.asarray(np.tensordot(weights, np.stack([each[name] for each in episodes]), axes=1))

    middle = mean("mean")
    spread = np.stack([each["std"] ** 2 + (each["mean"] - middle) ** 2 for each in episodes])
    return {
        "min": np.min([each["min"] for each in episodes], axis=0),
        "max": np.max([each["max"] for each in episodes], axis=0),
        "mean": middle,
        "std": np.sqrt(np.tensordot(weights, spread, axes=1)),
        **{name: mean(name) for name in QUANTILES},
        "count": np.array([int(counts.sum())]),
    }
