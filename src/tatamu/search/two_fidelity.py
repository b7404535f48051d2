"""A search over two fidelities. Most trials evaluate a cheap model, and the last trials evaluate the model itself.

Let y be the logarithm of the unknown part of the objective (alpha D of Eq. (10)). If no part is known before a trial, y
is the objective itself. The two fidelities are related by

    y_high(x) = y_low(x) + d(x)                    co-kriging (Kennedy and O'Hagan 2000)

y_low is the value of the cheap model, y_high the value of the model itself, and d their difference. y_low and d are
Gaussian processes. The first proposals at high fidelity are the best trials of low fidelity. Trials that differ too
little from a better trial are left out. When a few of these trials are known, the model proposes points. It proposes
the points with the largest expected improvement over the best trial of high fidelity.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tatamu.search.expected_improvement import log_expected_improvement, log_expected_improvement_beyond
from tatamu.search.gp import (
    LEAST_DEVIATION,
    THREADS,
    Maximisation,
    away_from,
    fit_standardised,
    leading,
    log_unknown,
    maximise,
)
from tatamu.search.search import HIGH, LOW, Evaluated, Observation, Proposal, Search
from tatamu.search.space import Parameters, Space


@dataclass(frozen=True)
class CoKriging:
    """Settings of the model that combines both fidelities."""

    handful: int = 3
    """Number of trials at high fidelity that are needed to model the difference d between the fidelities."""
    different: float = 0.1
    """Least difference of two trials in one parameter, as a fraction of its range. Closer trials count as equal."""
    least_difference: float = 1.0
    """Least standard deviation of the difference d between the logarithms of alpha D at low and at high fidelity.

    A difference of 1.0 corresponds to a factor of about three.
    """


class TwoFidelitySearch(Search):
    """Search that uses another search at low fidelity, and a co-kriging model of both fidelities at high fidelity."""

    settings = CoKriging()
    maximisation = Maximisation()

    def __init__(
        self,
        make: Callable[[Space, int, Sequence[Parameters]], Search],
        space: Space,
        seed: int = 0,
        first: Sequence[Parameters] = (),
    ) -> None:
        """Start a search.

        Args:
            make: Callable that makes the search of low fidelity from a space, a seed and first parameters.
            space: Bounds of the parameters, and the known part of the objective.
            seed: Random seed of the search.
            first: Parameters of the first proposals. The last of them is proposed at high fidelity. It is the last of
                the handful before the difference is modelled: a best trial is known by then, which it has to beat. It
                is left out if it was proposed before.
        """
        super().__init__(space, seed, first[-1:])
        self.low = make(space, seed, first[:-1])
        self.needs_residuals = self.low.needs_residuals

    @property
    def number(self) -> int:
        """Number of the next proposal, from 0."""
        return self.low.number + super().number

    def ask(self, fidelity: int = HIGH) -> Proposal:
        """Return the next proposal at a fidelity. It stays pending until its result is reported with `tell`."""
        if fidelity == LOW:
            return self.low.ask(LOW)
        tried = self._tried()
        given = len(tried) == self.settings.handful - 1 and bool(self.first) and self.first[0] not in tried
        parameters, gain = (self.first[0], None) if given else self.propose()
        proposal = Proposal(dict(parameters), HIGH, gain)
        self.expect(proposal)
        return proposal

    def expect(self, proposal: Proposal) -> None:
        """Add a pending proposal, for example a proposal of an interrupted study."""
        if proposal.fidelity == HIGH:
            super().expect(proposal)
        else:
            self.low.expect(proposal)

    def tell(self, proposal: Mapping[str, int | float], found: Evaluated | float) -> None:
        """Report the result of a proposal to the search of its fidelity."""
        if getattr(proposal, "fidelity", HIGH) == LOW:
            self.low.tell(proposal, found)
        else:
            super().tell(proposal, found)

    def propose(self) -> tuple[Parameters, float | None]:
        """Return the next parameters at high fidelity, and their expected improvement.

        The improvement is a fraction of the best objective.
        """
        if not self.low.told:
            return self.space.random(self.sub_seed()), None
        if len(self.told) < self.settings.handful:
            return self._best_different(), None
        random = np.random.default_rng([self.seed, self.number])
        low, high = (_arrays(self.space, each) for each in (self.low.told, self.told))
        best = np.concatenate([leading(*each, self.maximisation.best_trials) for each in (high, low)])
        pending = self.space.points([each.parameters for each in self.pending])
        with THREADS.limit(limits=1):
            acquisition = away_from(np.concatenate([high[0], pending]), self._acquisition(low, high))
            point, height = maximise(acquisition, self.space, best, random, self.maximisation)
        return self.space.parameters(point), float(np.exp(height) / high[1].min())

    def _tried(self) -> list[Parameters]:
        """Return the parameters of all proposals at high fidelity."""
        return [each.parameters for each in self.told] + [each.parameters for each in self.pending]

    def _best_different(self) -> Parameters:
        """Return the parameters of the best trial of low fidelity that differs from all trials of high fidelity.

        If no trial of low fidelity differs from them, return the parameters of the best one.
        """
        points, objectives = _arrays(self.space, self.low.told)
        taken = self.space.points(self._tried())
        order = np.argsort(objectives, kind="stable")
        apart = np.abs(points[:, None] - taken[None]).max(axis=2) >= self.settings.different
        different = [number for number in order if apart[number].all()]
        return dict(self.low.told[(different or order)[0]].parameters)

    def _acquisition(
        self, low: tuple[np.ndarray, np.ndarray], high: tuple[np.ndarray, np.ndarray]
    ) -> Callable[[np.ndarray], np.ndarray]:
        """Return a function that gives the log expected improvement, shape (p,), at p points, shape (p, d).

        The improvement is relative to the best trial of high fidelity.
        """
        space = self.space
        pending = space.points([each.parameters for each in self.pending])
        lower, centre, spread = fit_standardised(low[0], log_unknown(space, *low), pending)
        predicted = centre + spread * lower.predict(high[0])[0]
        least = self.settings.least_difference if space.known_part else LEAST_DEVIATION
        beside, shift, deviation = fit_standardised(high[0], log_unknown(space, *high) - predicted, pending, least)
        best = float(high[1].min())

        def improvement(at: np.ndarray) -> np.ndarray:
            mean, wide = lower.predict(at)
            mean_beside, wide_beside = beside.predict(at)
            expected = centre + spread * mean + shift + deviation * mean_beside
            uncertain = np.hypot(spread * wide, deviation * wide_beside)
            if space.known_part is None:
                return log_expected_improvement(best, expected, uncertain)
            return log_expected_improvement_beyond(best, space.known_part(space.values(at)), expected, uncertain)

        return improvement


def _arrays(space: Space, observations: Sequence[Observation]) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of n observations in the unit cube, shape (n, d), and their objectives, shape (n,)."""
    points = space.points([each.parameters for each in observations])
    return points, np.array([each.objective for each in observations])
