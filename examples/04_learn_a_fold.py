"""A short study: search grasps and trajectory for a small towel, and open its report.

python examples/04_learn_a_fold.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

from tatamu.folding.task import make_task
from tatamu.learning import learn
from tatamu.results import ResultFolder


def main(folder: Path = Path("runs/example")) -> float:
    """Objective C of the best of eight trials."""
    task = make_task("towel", size=(0.24, 0.5), spacing=0.04)
    report = learn(task, folder, trials=8, progress=lambda p: print(f"trial {p.done}: best C = {p.best}"))
    best = ResultFolder(folder).result.best_trial
    assert best.objective is not None
    print(f"open {report}")
    return best.objective


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
