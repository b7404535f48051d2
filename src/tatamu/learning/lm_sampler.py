"""The method of Li et al. (2015), with which the paper compares itself, as an Optuna sampler.

Levenberg-Marquardt on the inner control points P1 and P2 of the Bezier curve, over the vector of errors e_i, Eq. (12);
derivatives by finite differences, each of which is a trial; hands at the corners; from three starting curves. Their
paper does not say how steps and damping are chosen, nor which curves these are: here one is the curve that was shipped
with their code, the others are a high and a low arch. Whatever trials are left once all three have converged go to
further searches, from the points of a Halton sequence.

The residuals are those whose squares sum to the objective, so that the method minimises what it is judged by. There is
no state but the trials: each proposal runs the searches again on what these have found.
"""

from __future__ import annotations

from base64 import b64decode, b64encode
from collections.abc import Iterator, Sequence
from typing import Any
from zlib import compress, decompress

import numpy as np
from optuna.distributions import BaseDistribution
from optuna.samplers import BaseSampler
from optuna.study import Study
from optuna.trial import FrozenTrial, TrialState
from scipy.stats import qmc

from tatamu.folding.baselines import LI_2015
from tatamu.folding.score import residuals
from tatamu.learning.gp_sampler import KnownPart
from tatamu.learning.levenberg_marquardt import Key, Residuals, key_of, next_point
from tatamu.learning.space import HIGHEST
from tatamu.learning.unit_cube import UnitCube

ERRORS = "tatamu:errors"
"""System attribute of a trial that holds e_i."""
CURVES = (LI_2015, ((1 / 3, 0.6), (2 / 3, 0.6)), ((1 / 3, 0.2), (2 / 3, 0.2)))
"""P1 and P2 of the starting curves, as fractions of the span in both axes."""
SEARCHED = ("x1", "x2", "z1", "z2")
"""Names of what is searched, in the order of `UnitCube`."""
GRASPS = ("g1", "g2")
FURTHER = 1000
"""Starting points beyond the three curves: more than any study needs."""


def packed(errors: np.ndarray) -> str:
    """Errors e_i [m], shape (n,), as text; to single precision."""
    return b64encode(compress(errors.astype("<f4").tobytes())).decode()


def unpacked(text: str) -> np.ndarray:
    """Errors e_i [m] of a text of `packed`, shape (n,)."""
    return np.frombuffer(decompress(b64decode(text)), "<f4").astype(float)


class LevenbergMarquardtSampler(BaseSampler):
    """Proposes the next evaluation of Levenberg-Marquardt; without a seed, as nothing is drawn."""

    def __init__(self, lengths: KnownPart) -> None:
        """Make a sampler.

        Args:
            lengths: l_x of Eq. (10) [m].
        """
        self._lengths = lengths

    def infer_relative_search_space(self, study: Study, trial: FrozenTrial) -> dict[str, BaseDistribution]:
        """The parameters of the trials before."""
        before = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE, TrialState.RUNNING))
        return next((dict(other.distributions) for other in before if other.distributions), {})

    def sample_relative(
        self, study: Study, trial: FrozenTrial, search_space: dict[str, BaseDistribution]
    ) -> dict[str, Any]:
        """Parameters of the next trial; none where it is the first."""
        if not search_space:
            return {}
        cube = UnitCube({name: search_space[name] for name in SEARCHED})
        finished = self._at_corners(study, TrialState.COMPLETE)
        running = self._at_corners(study, TrialState.RUNNING)
        known = {key: self._residuals(other) for key, other in _by_point(cube, finished).items()}
        point = next_point(_starts(), known, _by_point(cube, running).keys())
        corners = {name: search_space[name].low for name in GRASPS}  # type: ignore[attr-defined]
        return {**cube.parameters(point), **corners}

    def sample_independent(
        self, study: Study, trial: FrozenTrial, param_name: str, param_distribution: BaseDistribution
    ) -> Any:
        """A value of the first trial: the first starting curve, hands at the corners."""
        low, high = param_distribution.low, param_distribution.high  # type: ignore[attr-defined]
        if param_name not in SEARCHED:
            return low
        return low + (high - low) * float(next(_starts())[SEARCHED.index(param_name)])

    def _residuals(self, trial: FrozenTrial) -> Residuals:
        """Of a finished trial; None where it failed."""
        if ERRORS not in trial.system_attrs:
            return None
        length = self._lengths({name: np.array([value]) for name, value in trial.params.items()})
        return residuals(float(length[0]), unpacked(trial.system_attrs[ERRORS]))

    @staticmethod
    def _at_corners(study: Study, state: TrialState) -> list[FrozenTrial]:
        """Trials whose hands grasp the corners."""
        trials = study.get_trials(deepcopy=False, states=(state,))
        return [each for each in trials if each.params and not any(int(each.params[name]) for name in GRASPS)]


def _by_point(cube: UnitCube, trials: Sequence[FrozenTrial]) -> dict[Key, FrozenTrial]:
    points = cube.points([trial.params for trial in trials])
    return {key_of(point): trial for point, trial in zip(points, trials, strict=True)}


def _starts() -> Iterator[np.ndarray]:
    """Points of the unit cube from which searches begin, shape (4,)."""
    for (x1, z1), (x2, z2) in CURVES:
        yield np.array([x1, x2, z1 / HIGHEST, z2 / HIGHEST])
    yield from qmc.Halton(len(SEARCHED), scramble=False).random(FURTHER)
