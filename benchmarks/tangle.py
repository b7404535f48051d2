"""Random folds of limp cloth, and fingers that poke it, in which anything passes through anything.

The tables "tangle" and "tangle: pokes" of docs/notes/validation.md:

    python benchmarks/tangle.py [--folds 600] [--pokes 200] [--write-docs]

The folds are those of `python -m tests.physics --only folds`, with other seeds, because what happens in none of 64
may happen once in hundreds.
"""

from __future__ import annotations

from tests.physics.checks.bodies import deepest_poke
from tests.physics.checks.tangle import crossings_of_fold

from benchmarks.tables import arguments, show
from tatamu.simulation.native import simulate

FIRST = 300
"""Seed of the first fold."""


def line(fast: bool, count: int) -> dict[str, object]:
    """Return the outcome of `count` folds."""
    found = [crossings_of_fold(simulate, seed, fast) for seed in range(FIRST, FIRST + count)]
    frames = [each for each in found if each is not None]
    passed = [each for each in frames if each.any()]
    return {
        "folds": f"{count} {'fast' if fast else 'slow'}",
        "with a crossing in any frame": len(passed),
        "in the last frame": sum(bool(each[-1]) for each in frames),
        "most in one frame": max((int(each.max()) for each in passed), default=0),
        "ended in an error": count - len(frames),
    }


def pokes(count: int) -> dict[str, object]:
    """Return the outcome of `count` scenes in which a thin finger flies into a limp cloth at 0.6 m/s."""
    found = [deepest_poke(simulate, seed) for seed in range(FIRST, FIRST + count)]
    depths = [depth for depth in found if depth is not None]
    return {
        "pokes": count,
        "deeper than a tenth of the thickness in any frame": sum(depth > 0.1 for depth in depths),
        "deeper than the thickness": sum(depth > 1.0 for depth in depths),
        "deepest [thicknesses]": f"{max(depths, default=0.0):.2f}",
        "ended in an error": count - len(depths),
    }


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--folds", type=int, default=600, help="of each kind")
    parser.add_argument("--pokes", type=int, default=200, help="fingers that fly into cloth")
    options = parser.parse_args()
    table = [line(fast, options.folds) for fast in (True, False)]
    show({"tangle": table, "tangle: pokes": [pokes(options.pokes)]}, options.write_docs)


if __name__ == "__main__":
    main()
