"""Tests whether the paper's claims about its results are also true for the results of this study.

The test of a claim computes a number that is defined in advance.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.stats import median_abs_deviation

from studies.paper.experiment import Study
from tatamu.study.result import MOMENTS, Result
from tatamu.study.trial import Trial

AFTER = tuple(count for count, _ in MOMENTS.values())
"""Numbers of trials after which Fig. 6 of the paper shows the vertex errors of the best fold."""
TWO_PEAKS = 2.0
"""Least value of Ashman's D, a measure of separation, for two clearly separate groups (Ashman, Bird and Zepf 1994)."""


@dataclass(frozen=True)
class Moment:
    """Results of the best trial up to a moment of the search, as medians over the random seeds."""

    after: int
    mean_vertex_distance: float
    """Mean of the vertex errors e_i, Eq. (12), in the best trial, as a median over the seeds [m]."""
    slip: float
    """Slip of the part of the cloth that should not move, in the best trial, as a median over the seeds [m]."""
    trajectory_length: float
    """Length l_x of a hand's path in the best trial, as a median over the seeds [m]."""


@dataclass(frozen=True)
class Claims:
    """The answers to the question whether the paper's claims are true for a garment."""

    garment: str
    seeds: int
    moments: list[Moment]
    moved_left: int
    """Number of seeds whose mean vertex error falls during the search. It must never rise from one moment to the next,
    and must be smaller at the end than at first."""
    peaks: list[float]
    """Separation (Ashman's D) of two groups of vertex errors, for each seed. The first group belongs to the moving part
    of the cloth, and the second group to the part that should not move."""
    slipped_less: int
    """Number of seeds whose best fold slips less than the fold of their first trial."""

    @property
    def two_peaked(self) -> int:
        """Number of seeds whose vertex errors have two clearly separate peaks."""
        return sum(peak > TWO_PEAKS for peak in self.peaks)


def claims(garment: str, studies: list[Study]) -> Claims:
    """Compare the paper's claims with the studies of a garment, and return the answers."""
    folds = [study.fold for study in studies if study.garment == garment]
    count = len(folds[0].record.trials)
    moments = [after for after in AFTER if after <= count] + ([count] if count not in AFTER else [])
    found = [[best(fold, after) for after in moments] for fold in folds]
    return Claims(
        garment,
        len(folds),
        [_moment(after, [row[k] for row in found]) for k, after in enumerate(moments)],
        sum(_falls([_distance(trial) for trial in row]) for row in found),
        [separation(fold) for fold in folds],
        sum(_slip(row[-1]) < _slip(row[0]) for row in found),
    )


def best(fold: Result, after: int) -> Trial | None:
    """Return the complete trial with the lowest objective C, Eq. (10), among the first `after` trials.

    The result is None if all of these trials failed.
    """
    complete = [trial for trial in fold.record.trials[:after] if trial.state == "complete"]
    return min(complete, key=lambda trial: (trial.objective, trial.number)) if complete else None


def separation(fold: Result) -> float:
    """Return Ashman's D = sqrt(2) |m_1 - m_2| / sqrt(s_1^2 + s_2^2), the separation of two groups of vertex errors.

    The groups are the errors of the upper part and of the lower part of the cloth. In the paper, the errors have two
    peaks, because a lower part had slipped under a correct upper part.

    Here m is the median of a group. The spread s is the median absolute deviation, scaled to a normal distribution. The
    loop of cloth between both parts has large errors. Because medians are used, these errors have little influence.
    """
    lower = np.linalg.norm(fold.target - fold.start, axis=1) < 1e-6
    if not lower.any() or lower.all():
        return 0.0
    upper, still = fold.errors[~lower], fold.errors[lower]
    spread = np.hypot(*(median_abs_deviation(part, scale="normal") for part in (upper, still)))
    return float(np.sqrt(2.0) * abs(np.median(upper) - np.median(still)) / max(spread, 1e-12))


def _moment(after: int, trials: list[Trial | None]) -> Moment:
    return Moment(after, *(float(np.median([of(trial) for trial in trials])) for of in (_distance, _slip, _length)))


def _distance(trial: Trial | None) -> float:
    return np.inf if trial is None or trial.score is None else trial.score.mean_vertex_distance


def _slip(trial: Trial | None) -> float:
    return np.inf if trial is None or trial.score is None else trial.score.slip


def _length(trial: Trial | None) -> float:
    return np.inf if trial is None or trial.trajectory_length is None else trial.trajectory_length


def _falls(values: list[float]) -> bool:
    """Return whether a series of values never rises, and its last value is less than its first."""
    return values[-1] < values[0] and all(later <= earlier for earlier, later in pairwise(values))
