"""The method of Li et al. (2015), with which the paper compares its own method.

The method minimises the vector of errors e_i, Eq. (12), by Levenberg-Marquardt. It varies the inner control points P1
and P2 of the Bezier curve, and the hands always grasp the corners. Derivatives are finite differences, and each
difference takes one trial. Li et al. do not state the steps, the damping or the starting curves. Here, searches start
from three curves: the curve shipped with their code, a high arch and a low arch. When all three searches have
converged, more searches start from the points of a Halton sequence.

The squares of the residuals sum to the objective. For each proposal, the searches are repeated on all observations, so
the observations are the only state.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property

import numpy as np

from tatamu.search.levenberg_marquardt import Key, Residuals, key_of, next_point
from tatamu.search.search import Observation, Search
from tatamu.search.space import Parameters, Space

LI_2015 = ((0.53996, 0.20555), (0.78185, 0.45923))
"""Control points P1 and P2 of the curve shipped with the code of Li et al. 2015 (Yinxiaoli/iros2015_folding).

The values are fractions of the span, the horizontal distance from grasp to release, in both axes. The curve is exactly
this cubic Bezier curve."""
CURVES = (LI_2015, ((1 / 3, 0.6), (2 / 3, 0.6)), ((1 / 3, 0.2), (2 / 3, 0.2)))
"""Control points P1 and P2 of the three starting curves.

The values are fractions of the span, the horizontal distance from grasp to release, in both axes.
"""
SEARCHED = ("x1", "x2", "z1", "z2")
"""Names of the parameters that are searched."""
GRASPS = ("g1", "g2")
FURTHER = 1000
"""Number of starting points after the three starting curves. It is larger than the number that any study needs."""


class LMSearch(Search):
    """Search that proposes the points that the Levenberg-Marquardt method evaluates. The seed has no effect."""

    needs_residuals = True

    def propose(self) -> tuple[Parameters, float | None]:
        """Return the next parameters, and None because the method does not estimate an improvement."""
        known = {key: self._all_residuals(each) for key, each in self._by_point(self.known).items()}
        pending = self._by_point([Observation(each.parameters, 0.0) for each in self.pending])
        point = next_point(self._starts(), known, pending.keys())
        corners = {name: self.space.bounds[name].low for name in GRASPS}
        return {**self._curves.parameters(point), **corners}, None

    @cached_property
    def _curves(self) -> Space:
        """The search space of only the Bezier curve's control points P1 and P2."""
        return Space({name: self.space.bounds[name] for name in SEARCHED})

    def _all_residuals(self, observation: Observation) -> Residuals:
        """Return the vector whose squares sum to the objective C of Eq. (10); None for a failed trial."""
        if observation.residuals is None or self.space.known_part is None:
            return None
        columns = {name: np.array([value]) for name, value in observation.parameters.items()}
        return np.concatenate([np.sqrt(self.space.known_part(columns)), observation.residuals])

    def _by_point(self, observations: Sequence[Observation]) -> Mapping[Key, Observation]:
        """Return the observations in which the hands grasp the corners, by their rounded points of the search space."""
        chosen = [each for each in observations if not any(int(each.parameters[name]) for name in GRASPS)]
        points = self._curves.points([each.parameters for each in chosen])
        return {key_of(point): each for point, each in zip(points, chosen, strict=True)}

    def _starts(self) -> Iterator[np.ndarray]:
        """Yield the points of the unit cube from which searches start, shape (4,)."""
        from scipy.stats import qmc  # this import takes half a second

        highest = round(self.space.bounds["z1"].high / self.space.bounds["x1"].high, 9)  # 0.75 without rounding errors
        for (x1, z1), (x2, z2) in CURVES:
            yield np.array([x1, x2, z1 / highest, z2 / highest])
        yield from qmc.Halton(len(SEARCHED), scramble=False).random(FURTHER)
