"""How much longer rollouts take with air, friction of bending and shear of its own.

    python -m benchmarks.terms_cost [--rounds 9] [--write-docs]

Folds of a towel and a T-shirt, in every round with the fabric of today and with each of its variants in turn, so that
other work on the machine slows all of them. The ratio is that of processor seconds, in the median over rounds.
"""

from __future__ import annotations

import argparse
from time import process_time

import numpy as np

from benchmarks.tables import markdown, publish
from benchmarks.terms import variants
from benchmarks.timed_folds import Fold, shirt, towel
from tatamu.simulation.presets import load_preset
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import simulate

ASKED = 1.3
"""Largest ratio of the time with all terms to the present time."""


def folds() -> dict[str, Fold]:
    """Return the timed folds, by the garment whose terms they get."""
    return {"towel": towel(0.015, load_preset("terry").material), "tshirt": shirt(0.02)}


def seconds(scene: Scene) -> float:
    """Return the processor time of a rollout [s]."""
    begun = process_time()
    simulate(scene)
    return process_time() - begun


def row(garment: str, fold: Fold, rounds: int) -> dict[str, str]:
    """Return a line of the table."""
    scenes = {
        name: fold.scene.model_copy(update={"material": material})
        for name, material in variants(garment, fold.scene.material).items()
    }
    for scene in scenes.values():  # whatever is compiled at first use
        simulate(scene.model_copy(update={"duration": 0.05}))
    times = np.array([[seconds(scene) for scene in scenes.values()] for _ in range(rounds)])
    over = times / times[:, :1]
    low, middle, high = np.percentile(over, [25, 50, 75], axis=0)
    return {
        "fold": fold.name,
        "vertices": str(len(fold.target)),
        "today [s]": f"{np.median(times[:, 0]):.2f}",
        **{
            f"{name}, times": f"{middle[place]:.2f} ({low[place]:.2f} to {high[place]:.2f})"
            for place, name in enumerate(scenes)
            if name != "today"
        },
        f"at most {ASKED:g}": "yes" if middle[-1] <= ASKED else "no",
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--write-docs", action="store_true", help="write the table into docs/notes/real-cloth.md")
    options = parser.parse_args()
    table = markdown([row(garment, fold, options.rounds) for garment, fold in folds().items()])
    print(table)
    if options.write_docs:
        publish("real: cost", table)


if __name__ == "__main__":
    main()
