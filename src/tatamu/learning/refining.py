"""The last trials of a study that began on a coarser mesh: proposed from what both meshes said so far.

With y the logarithm of what is not known of the objective (alpha D of Eq. (10)), on the coarse and on the fine mesh,

    y_fine(x) = y_coarse(x) + d(x)                              (Kennedy and O'Hagan 2000)

and y_coarse and d each a Gaussian process. The first proposals are the best coarse trials, each at some distance from
those before it; once a few of them were simulated on the fine mesh, the largest expected improvement over the best fine
trial is proposed, whether a coarse trial was there or not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from optuna.distributions import BaseDistribution

from tatamu.learning.expected_improvement import log_expected_improvement_beyond
from tatamu.learning.gp_sampler import BEST_TRIALS, LEAST_UNKNOWN, KnownPart, maximised, standardised_fit
from tatamu.learning.unit_cube import UnitCube
from tatamu.results.result import Parameters

HANDFUL = 3
"""How many fine trials must be known before the difference between the meshes is modelled."""
DIFFERENT = 0.1
"""Two trials are different where one parameter differs by this part of its range."""
LEAST_DIFFERENCE = 1.0
"""Deviation of d that is expected at least: on one mesh alpha D may be three times that on the other."""


@dataclass(frozen=True)
class Known:
    """Parameters and objectives of finished trials on one mesh."""

    parameters: Sequence[Parameters]
    objectives: np.ndarray


def refining_proposal(
    space: Mapping[str, BaseDistribution],
    known_part: KnownPart,
    coarse: Known,
    fine: Known,
    running: Sequence[Parameters],
    random: np.random.Generator,
) -> tuple[Parameters, float | None]:
    """Parameters of the next trial on the fine mesh, and the improvement that is expected of it, as a part of the best.

    Args:
        space: Bounds of the search.
        known_part: The part of the objective that is known before a trial runs.
        coarse: Finished trials on the coarse mesh, at least one.
        fine: Finished trials on the fine mesh.
        running: Parameters of trials on the fine mesh that are still running.
        random: For the search of the best proposal.
    """
    cube = UnitCube(space)
    if len(fine.parameters) < HANDFUL:
        return _best_different(cube, coarse, [*fine.parameters, *running]), None
    points = cube.points(coarse.parameters)
    fine_points = cube.points(fine.parameters)
    improvement = _improvement(cube, known_part, (points, coarse.objectives), (fine_points, fine.objectives), running)
    best = np.concatenate([_leading(fine_points, fine.objectives), _leading(points, coarse.objectives)])
    chosen, height = maximised(improvement, cube, best, random)
    return cube.parameters(chosen), float(np.exp(height) / fine.objectives.min())


def _best_different(cube: UnitCube, coarse: Known, taken: Sequence[Parameters]) -> Parameters:
    """The best coarse trial that differs from those taken; the best of all where none does."""
    points = cube.points(coarse.parameters)
    others = cube.points(taken)
    order = np.argsort(coarse.objectives, kind="stable")
    apart = np.abs(points[:, None] - others[None]).max(axis=2) >= DIFFERENT
    different = [number for number in order if apart[number].all()]
    return dict(coarse.parameters[(different or order)[0]])


def _leading(points: np.ndarray, objectives: np.ndarray) -> np.ndarray:
    return points[np.argsort(objectives, kind="stable")[:BEST_TRIALS]]


def _improvement(
    cube: UnitCube,
    known_part: KnownPart,
    coarse: tuple[np.ndarray, np.ndarray],
    fine: tuple[np.ndarray, np.ndarray],
    running: Sequence[Parameters],
) -> Callable[[np.ndarray], np.ndarray]:
    """Log expected improvement over the best fine trial, from points, shape (p, d), to shape (p,)."""
    pending = cube.points(running)

    def unknown(points: np.ndarray, objectives: np.ndarray) -> np.ndarray:
        return np.log(np.maximum(objectives - known_part(cube.values(points)), LEAST_UNKNOWN))

    coarsely, centre, spread = standardised_fit(coarse[0], unknown(*coarse), pending)
    expected = centre + spread * coarsely.predict(fine[0])[0]
    beside, shift, deviation = standardised_fit(fine[0], unknown(*fine) - expected, pending, LEAST_DIFFERENCE)

    def improvement(at: np.ndarray) -> np.ndarray:
        mean, wide = coarsely.predict(at)
        mean_beside, wide_beside = beside.predict(at)
        return log_expected_improvement_beyond(
            float(fine[1].min()),
            known_part(cube.values(at)),
            centre + spread * mean + shift + deviation * mean_beside,
            np.hypot(spread * wide, deviation * wide_beside),
        )

    return improvement
