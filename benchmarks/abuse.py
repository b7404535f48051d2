"""Ten thousand random scenes: how many ended in a rollout, how many in which error.

The table "abuse" of docs/notes/benchmarks.md:

    python -m benchmarks.abuse [--scenes 10000] [--processes 2] [--out runs/abuse.json] [--write-docs]

A scene is wrong that gives NaN, raises what is no error of ours, crashes, or takes longer than a minute; each is named
by its seed (`tests.abuse.scene(SEED)`), and the exit code is then 1.
"""

from __future__ import annotations

import os
import subprocess
import sys
from argparse import SUPPRESS
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from faulthandler import dump_traceback_later
from pathlib import Path

from tests.abuse import acceptable, outcome

from benchmarks.tables import arguments, show
from benchmarks.timed_folds import towel
from tatamu import simulate
from tatamu.base.files import write_json

PATIENCE = 60.0
"""Time after which a scene counts as hanging [s]."""
CHUNK = 250


def worker(seeds: range) -> None:
    """Print a line for each seed; end the process if a scene hangs."""
    simulate(towel(0.05).scene.model_copy(update={"duration": 0.05}))  # compiles, which is no scene's time
    for seed in seeds:
        dump_traceback_later(PATIENCE, exit=True)
        try:
            kind = outcome(seed)
        except Exception as error:
            kind = f"WRONG: {type(error).__name__}: {error}".splitlines()[0]
        print(f"{seed}\t{kind}", flush=True)


def outcomes(seeds: range) -> dict[int, str]:
    """Return the outcome of each seed; a process that crashes is replaced."""
    found: dict[int, str] = {}
    while len(found) < len(seeds):
        rest = seeds[len(found) :]
        command = [sys.executable, "-m", "benchmarks.abuse", "--worker", str(rest.start), str(rest.stop)]
        one = {**os.environ, "OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1"}
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, env=one, check=False)
        found |= {int(seed): kind for seed, kind in (line.split("\t") for line in done.stdout.splitlines())}
        if done.returncode:
            found[seeds[len(found)]] = f"WRONG: crash, or more than {PATIENCE:g} s (exit code {done.returncode})"
    return found


def table(found: dict[int, str]) -> list[dict[str, object]]:
    """Return one row for each kind of outcome, the most frequent first; `seed` is the first seed with this outcome."""
    first = {kind: seed for seed, kind in sorted(found.items(), reverse=True)}
    return [{"outcome": k, "scenes": n, "first seed": first[k]} for k, n in Counter(found.values()).most_common()]


def main() -> None:
    parser = arguments(__doc__)
    parser.add_argument("--scenes", type=int, default=10_000)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("runs/abuse.json"))
    parser.add_argument("--worker", type=int, nargs=2, help=SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        return worker(range(*options.worker))
    chunks = [range(a, min(a + CHUNK, options.scenes)) for a in range(0, options.scenes, CHUNK)]
    found: dict[int, str] = {}
    with ThreadPoolExecutor(options.processes) as pool:
        for part in pool.map(outcomes, chunks):
            found |= part
            print(f"\r{len(found)} of {options.scenes}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    wrong = {seed: kind for seed, kind in found.items() if not acceptable(kind)}
    rows = table(found)
    write_json(options.out, {"scenes": len(found), "outcomes": rows, "wrong": wrong})
    show({"abuse": rows}, options.write_docs)
    print(f"{len(found)} scenes, {len(wrong)} wrong: {wrong}")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
