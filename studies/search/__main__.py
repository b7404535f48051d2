"""Compares the default search with other searches, by the best folds after 1 to 134 simulations.

The results are in docs/notes/search.md. The commands are:

    python -m studies.search --out runs/search [--seeds 10] [--pair-seeds 20] [--write-docs]
    python -m studies.search --out runs/search --show [--write-docs]      tables of finished studies only

Every simulation is kept in OUT/rollouts, and every study in OUT/studies, so an interrupted run can be resumed. All
studies of a seed run before the studies of the next seed, so partial results can be shown at any time. Optuna's
GPSampler needs torch, which tatamu does not install (`pip install torch`). Without torch, the row of GPSampler is left
out of the tables.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks.tables import IMAGES, markdown, publish
from studies.search.chart import draw
from studies.search.courses import Studies
from studies.search.methods import CORE, FEW, MANY, METHODS, PAIR
from studies.search.settings import GARMENTS, Setting
from studies.search.tables import answers, courses_of, pair_table, table
from threadpoolctl import threadpool_limits


def run(out: Path, seeds: int, pair_seeds: int) -> None:
    """Run those studies of all searches that are missing, seed by seed.

    Studies of the towel come first, because they are fast and important.
    """
    settings = {name: Setting(name, coarse, out / "rollouts") for name, coarse in GARMENTS.items()}
    studies = Studies(out)
    softer = tuple(name for name, coarse in GARMENTS.items() if coarse.softer != 1.0)
    all_garments = tuple(name for name in GARMENTS if name not in softer)
    towel, all_methods = ("towel",), tuple(METHODS)
    few = min(2, seeds)
    for garments, names, trials, first, last in (
        (all_garments, all_methods, FEW, 0, few),
        (all_garments, ("lm",), MANY, 0, 1),
        (all_garments, ("grid",), MANY, 0, seeds),
        (towel, CORE, FEW, few, seeds),
        (all_garments, CORE, FEW, few, seeds),
        (softer, CORE, FEW, 0, seeds),
        (towel, all_methods, FEW, few, seeds),
        (all_garments, all_methods, FEW, few, seeds),
        (all_garments, all_methods, MANY, 0, seeds),
        (all_garments, PAIR, FEW, seeds, pair_seeds),
    ):
        for seed in range(first, last):
            for garment in garments:
                for name in names:
                    method = METHODS[name]
                    if method.possible and seed < (method.seeds or last) and trials <= method.trials:
                        studies.run(name, settings[garment], seed, trials)
            print(f"{', '.join(garments)}: {', '.join(names)}, {trials} trials, seed {seed}: done", flush=True)


def show(out: Path, seeds: int, pair_seeds: int, write: bool) -> None:
    """Print all tables that compare the searches.

    If `write` is true, also write them into the docs.
    """
    studies = Studies(out)
    texts = {f"search: {garment}": table(studies, garment, seeds) for garment in GARMENTS}
    texts["search: answers"] = answers(studies, seeds)
    texts["search: pair"] = pair_table(studies, pair_seeds)
    for name, rows in texts.items():
        if not rows:
            continue
        print(f"\n{name}\n\n{markdown(rows)}")
        if write:
            publish(name, markdown(rows))
    if write:
        draw(courses_of(studies, seeds), IMAGES / "search.svg")


def main() -> None:
    """Parse the command line, and run the studies or show their results."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--pair-seeds", type=int, default=20)
    parser.add_argument("--show", action="store_true", help="run nothing")
    parser.add_argument("--write-docs", action="store_true")
    given = parser.parse_args()
    if not given.show:
        with threadpool_limits(1):
            run(given.out, given.seeds, given.pair_seeds)
    show(given.out, given.seeds, given.pair_seeds, given.write_docs)


if __name__ == "__main__":
    main()
