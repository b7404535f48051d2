"""Broken files of every kind that tatamu reads, for as long as asked: each ends in one clean line, or is read.

    python -m benchmarks.fuzz [--minutes 10] [--processes 2] [--first 0] [--seeds 3,14]

A case is wrong that ends in a traceback, in more than one line, in control characters, or that takes more than 10 s or
1.5 GiB; each is named by its seed (`tests.fuzzing.outcome(SEED)`), and the exit code is then 1. Workers are processes
of their own with limited memory; one that hangs or crashes is replaced.
"""

from __future__ import annotations

import argparse
import faulthandler
import os
import resource
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from subprocess import PIPE
from tempfile import TemporaryFile

from tests.fuzzing import PATIENCE, acceptable, outcome, warm

CHUNK = 150
"""Seeds for each worker: whatever it leaks goes with it."""
HANGING = int(5 * PATIENCE)
"""What takes more time of a processor hangs [s]; nothing is read that waits for anything else."""
MAX_MEMORY = 6 << 30
"""Memory that a worker may ask for [bytes]."""


def worker(seeds: range) -> None:
    """Print a line for each seed; end with a traceback where one hangs."""
    resource.setrlimit(resource.RLIMIT_AS, (MAX_MEMORY, MAX_MEMORY))
    faulthandler.enable()
    faulthandler.register(signal.SIGPROF, chain=True)  # the signal then ends the process
    warm()
    for seed in seeds:
        signal.setitimer(signal.ITIMER_PROF, HANGING)
        print(f"{seed}\t{outcome(seed)}", flush=True)


def outcomes(seeds: range) -> Iterator[tuple[int, str]]:
    """Outcome of each seed, from a process of its own, and from another after each that ends it."""
    found = seeds.start
    while found < seeds.stop:
        command = [sys.executable, "-m", "benchmarks.fuzz", "--worker", str(found), str(seeds.stop)]
        one = {**os.environ, "OMP_NUM_THREADS": "1", "NUMBA_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        with (
            TemporaryFile("w+") as said,
            subprocess.Popen(command, stdout=PIPE, stderr=said, text=True, env=one) as run,
        ):
            try:
                for line in run.stdout or ():
                    seed, _, kind = line.partition("\t")
                    found = int(seed) + 1
                    yield int(seed), kind.rstrip()
                run.wait()
            finally:
                run.kill()  # the caller may want no more
            said.seek(0)
            errors = said.read()
        if run.returncode:
            where = " | ".join(errors.splitlines()[:6])
            yield found, f"WRONG: a crash, or more than {HANGING} s (exit code {run.returncode}): {where[:600]}"
            found += 1
        elif errors:
            yield found - 1, f"WRONG: a library wrote {errors[:200]!r} (one of the {CHUNK} seeds before)"


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--seeds", help="these seeds only, separated by commas, in this process")
    parser.add_argument("--worker", type=int, nargs=2, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.worker:
        return worker(range(*options.worker))
    if options.seeds:
        for seed in options.seeds.split(","):
            print(f"{seed}\t{outcome(int(seed))}")
        return None
    found: dict[int, str] = {}
    end = time.monotonic() + 60.0 * options.minutes

    def run(lane: int) -> None:
        start = options.first + lane * CHUNK
        while time.monotonic() < end:
            for seed, kind in outcomes(range(start, start + CHUNK)):
                found[seed] = kind
                if not acceptable(kind):
                    print(f"{seed}\t{kind}", flush=True)
                if time.monotonic() > end:
                    break
            start += options.processes * CHUNK

    with ThreadPoolExecutor(options.processes) as pool:
        list(pool.map(run, range(options.processes)))
    for kind, count in sorted(Counter(kind for kind in found.values() if acceptable(kind)).items()):
        print(f"{count:6}  {kind}")
    wrong = sum(not acceptable(kind) for kind in found.values())
    print(f"{len(found)} files, {wrong} wrong")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
