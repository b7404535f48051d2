"""Simulate one manipulation of a towel, chosen by hand, and print its score.

python examples/03_fold_once.py
"""

from __future__ import annotations

import tatamu as tt


def main() -> float:
    """Return the mean distance of the folded towel from its target [m]."""
    task = tt.make_task("towel", size=(0.24, 0.5), spacing=0.03)
    found = tt.Nominal(task)({"x1": 0.15, "z1": 0.2, "x2": 0.4, "z2": 0.2, "g1": 0, "g2": 0})
    assert found.score is not None, found.error
    for name, value in found.score.model_dump().items():
        print(f"{name:22} {value:.4f}")
    return found.score.mean_vertex_distance


if __name__ == "__main__":
    main()
