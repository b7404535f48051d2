"""Learn with an objective of your own: a function of the parameters, then a wrapper of the paper's objective.

python examples/07_your_own_objective.py
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import tatamu as tt

SHOWN = {"x1": 0.15, "z1": 0.2, "x2": 0.4, "z2": 0.2}
"""Control points of a fold that a person demonstrated [m]."""


def unlike(parameters: Mapping[str, int | float]) -> float:
    """Return how far the control points of the hands are from the demonstration's [m]."""
    return sum((parameters[name] - value) ** 2 for name, value in SHOWN.items()) ** 0.5


class LikeShown(tt.Wrapper):
    """Adds the distance from the demonstration to the objective."""

    def __call__(self, ask: tt.Ask) -> tt.Evaluation:
        """Evaluate a manipulation."""
        found = self.inner(ask)
        return replace(found, objective=found.objective + unlike(ask.parameters))


def main() -> float:
    """Return how much nearer to the demonstration the wrapper's fold is than the paper's [m]."""
    task = tt.make_task("towel", size=(0.24, 0.5), spacing=0.04)
    options = tt.LearnOptions(trials=16, disturbances="none", baselines=False)
    distances = {}
    for name, objective in {"C": None, "unlike": unlike, "C + unlike": LikeShown(tt.Nominal(task))}.items():
        result = tt.learn(task, options, evaluate=objective)
        distances[name] = unlike(result.best.parameters)
        error = 1e3 * result.score.mean_vertex_distance
        print(f"{name:10} {distances[name]:.3f} m from the demonstration, mean vertex distance {error:.1f} mm")
    return distances["C"] - distances["C + unlike"]


if __name__ == "__main__":
    main()
