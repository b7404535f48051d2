"""One manipulation of a towel, chosen by hand, and its score.

python examples/03_fold_once.py
"""

from __future__ import annotations

from tatamu.folding.task import make_task


def main() -> float:
    """Mean distance of the folded towel from the wanted shape [m]."""
    task = make_task("towel", size=(0.24, 0.5), spacing=0.03)
    manipulation = task.manipulation({"x1": 0.15, "z1": 0.2, "x2": 0.4, "z2": 0.2, "g1": 0, "g2": 0})
    outcome = task.evaluate(manipulation)
    assert outcome.score is not None, outcome.error
    for name, value in outcome.score.as_dict().items():
        print(f"{name:22} {value:.4f}")
    return outcome.score.mean_vertex_distance


if __name__ == "__main__":
    main()
