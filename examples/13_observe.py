"""After the fold: report how a real fold ended, and correct the next one.

Here the real fold is a simulation whose hands are 8 mm too far, which nobody knows. Prints how far the fold ended from
its target, and the corrected one.
"""

from __future__ import annotations

import sys
from pathlib import Path

import tatamu as tt
from tatamu.evaluation.disturbances import Scenario
from tatamu.folding.score import marks

REALITY = Scenario({"hands.offset.along": 0.008})


def main(out: Path = Path("runs/observed"), spacing: float = 0.025) -> float:
    """Return the mean vertex distance after the correction over that before it."""
    task = tt.make_task(tt.make_garment("towel", size=(0.3, 0.4), spacing=spacing))
    options = tt.LearnOptions(trials=1, baselines=False)
    result = tt.learn(task, options, out=out)
    assert isinstance(result, tt.Result)

    before = tt.Nominal(task).simulate(result.best.parameters, REALITY)
    assert before.rollout and before.score
    seen = marks(task.fold, before.rollout.positions[-1])
    observed = tt.observe(
        result,
        left=(seen["left_along"], seen["left_across"]),
        right=(seen["right_along"], seen["right_across"]),
        slip=(seen["slip_along"], seen["slip_across"]),
    )

    corrected = tt.correct(observed, out=out / "corrected-1")
    after = tt.Nominal(corrected.task).simulate(result.best.parameters, REALITY)
    assert after.score
    distances = [score.mean_vertex_distance for score in (before.score, after.score)]
    print(f"before {1e3 * distances[0]:.1f} mm, after {1e3 * distances[1]:.1f} mm")
    return distances[1] / distances[0]


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
