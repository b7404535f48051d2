"""Add a search of your own: it proposes points around the best trial so far.

python examples/08_your_own_search.py
"""

from __future__ import annotations

import numpy as np

import tatamu as tt

SPREAD = 0.1
"""Standard deviation of a step, in parts of a parameter's range."""


class HillClimbing(tt.Search):
    """Proposes a random step from the best trial; the first proposal is random."""

    def propose(self) -> tuple[dict[str, int | float], float | None]:
        """Return the next parameters; the improvement that it expects is not known."""
        if not self.told:
            return self.space.random(self.sub_seed()), None
        best = min(self.told, key=lambda each: each.objective)
        point = self.space.points([best.parameters])[0]  # in the unit cube
        step = SPREAD * np.random.default_rng(self.sub_seed()).standard_normal(len(point))
        return self.space.parameters(self.space.snap(point + step)), None


tt.register_search("hill", HillClimbing)


def main() -> float:
    """Return the objective of the best of twelve trials over that of the first, a random one."""
    task = tt.make_task("towel", size=(0.24, 0.5), spacing=0.04)
    options = tt.LearnOptions(sampler="hill", trials=12, disturbances="none", baselines=False)
    result = tt.learn(task, options, progress=print)
    return result.best.minimised / result.trials[0].minimised


if __name__ == "__main__":
    main()
