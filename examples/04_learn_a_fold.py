"""Learn to fold a small towel in eight trials, and write the report.

python examples/04_learn_a_fold.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import tatamu as tt


def main(folder: Path = Path("runs/example")) -> float:
    """Return the objective C of the best trial."""
    task = tt.make_task("towel", size=(0.24, 0.5), spacing=0.04)
    options = tt.LearnOptions(trials=8, seed=0, disturbances="none")
    result = tt.learn(task, options, out=folder, progress=print)
    assert isinstance(result, tt.Result)  # a plan of several steps gives a PlanResult
    print(f"best trial: number {result.best.number}, {result.best.parameters}")
    print(f"open {folder / 'report.html'}")
    return result.score.objective


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
