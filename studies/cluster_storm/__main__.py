"""Tests a cluster whose workers, database and client are killed, and measures the overhead of a cluster.

It also computes what 1,000 workers would need. The command writes the tables of docs/notes/cluster.md:

    python -m studies.cluster_storm [storm] [overhead] [busy] [constants] [--studies 200] [--write-docs]

The study needs `tatamu[cluster]`. The parts `storm` and `constants` also need PostgreSQL, whose server runs in a
temporary folder. Everything runs in real processes on this machine.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event, Thread
from typing import Any

from benchmarks.tables import markdown, publish
from tests import postgres

from tatamu import Nominal, make_task

WORKERS = 4
KILL_EVERY = 8.0
"""Time between two kills of a worker [s]."""
CLIENT_KILLED_AT = (0.3, 0.6)
DATABASE_RESTARTED_AT = ((0.2, "fast"), (0.5, "immediate"))
"""Moments at which the database is restarted, and the ways in which PostgreSQL is then stopped.

A moment is given as the fraction of studies that are complete.
"""
ROUNDS = 3
"""Number of times that a measurement is repeated.

Only the fastest round counts, because other programs may slow down a round.
"""
CALLS = 30
"""Number of calls per worker in a round of a measurement. A call only sleeps."""
TOGETHER = 16
"""Number of workers in each process. They can share a process because they only sleep."""
HERE = ("--host", "127.0.0.1")
CLIENT = """
import sys
import tatamu.report.topview
tatamu.report.topview.WIDE = 60  # pictures are most of a small study
from tatamu.cli import main
main()
"""


def sweep_file(folder: Path, studies: int) -> Path:
    """Write a file that describes a sweep (a list of learning tasks) of small studies, and return its path."""
    path = folder / "sweep.toml"
    seeds = list(range(studies))
    path.write_text(
        '[all]\ngarment = "towel"\nsize = "0.24x0.50"\nspacing = 0.04\ntrials = 3\nbaselines = false\n'
        'disturbances = "none"\n'
        f"[grid]\nseed = {seeds}\n"
    )
    return path


def start(file: Path, out: Path, *options: str) -> subprocess.Popen[bytes]:
    """Start a client process that runs a sweep, a list of learning tasks."""
    command = [sys.executable, "-c", CLIENT, "sweep", str(file), "--out", str(out), *options]
    environment = {**os.environ, "PGPASSWORD": postgres.PASSWORD}
    return subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def complete(out: Path) -> int:
    """Return the number of tasks of a sweep that are complete."""
    try:
        tasks = json.loads((out / "sweep.json").read_text())["tasks"]
    except (OSError, ValueError):
        return 0
    return sum(task["state"] == "complete" for task in tasks)


def results(out: Path) -> dict[str, str]:
    """Return a digest of each study of a sweep, by the name of its folder.

    The digest is computed from all results except times: the trials, the manipulation, the scene and the rollout.
    """
    import numpy as np

    found = {}
    for folder in sorted(path for path in out.iterdir() if (path / "result.json").exists()):
        data = json.loads((folder / "result.json").read_text())
        del data["wall_seconds"]
        for trial in data["trials"]:
            del trial["seconds"]
        digest = hashlib.sha256(json.dumps(data).encode())
        for name in ("manipulation.json", "scene.json"):
            digest.update((folder / name).read_bytes())
        with np.load(folder / "rollout.npz") as rollout:
            for name in ("times", "positions", "faces", "target"):
                digest.update(rollout[name].tobytes())
        found[folder.name] = digest.hexdigest()
    return found


class Cluster:
    """A scheduler and workers, which are all processes of this machine.

    Workers that have ended can be restarted, as Slurm and Kubernetes do.
    """

    def __init__(self, folder: Path, workers: int, together: int | None = None) -> None:
        """Start the scheduler and all workers.

        Args:
            folder: Folder of the cluster's files.
            workers: Number of worker processes.
            together: Number of workers in each process, which then has no nanny (the process with which Dask supervises
                a worker). None for one worker per process, which `dask worker` starts with a nanny.
        """
        self._folder = folder
        self._together = together
        self._environment = {
            **os.environ,
            "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "3",  # Dask's own default
            "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",  # this and the next line are as in examples/cluster
            "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "1s",
            "DASK_LOGGING__DISTRIBUTED": "error",
        }
        said = folder / "scheduler.json"
        own = ["--scheduler-file", str(said), "--port", "0", "--dashboard-address", "127.0.0.1:0", *HERE]
        self._scheduler = self._start("dask", "scheduler", *own)
        while not said.exists() or not said.read_text():
            time.sleep(0.1)
        self.address: str = json.loads(said.read_text())["address"]
        self._workers = [self._worker() for _ in range(workers)]

    def _start(self, *arguments: str) -> subprocess.Popen[bytes]:
        quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return subprocess.Popen([sys.executable, "-m", *arguments], env=self._environment, **quiet)

    def _worker(self) -> subprocess.Popen[bytes]:
        if self._together is not None:
            return self._start("studies.cluster_storm.sleeping_workers", self.address, str(self._together))
        own = ["--local-directory", str(self._folder), "--memory-limit", "0", "--dashboard-address", "127.0.0.1:0"]
        return self._start("dask", "worker", self.address, "--nworkers", "1", "--nthreads", "1", *own, *HERE)

    def kill_one(self, chance: random.Random) -> bool:
        """Kill the worker of a random nanny, the process that supervises a worker.

        Return whether this nanny had a worker.
        """
        lists = Path(f"/proc/{chance.choice(self._workers).pid}/task").glob("*/children")
        children = [int(word) for path in lists for word in path.read_text().split()]
        working = [child for child in children if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()]
        for child in working:
            os.kill(child, signal.SIGKILL)
        return bool(working)

    def start_again(self) -> None:
        """Restart all workers whose nanny, the supervising process, has ended.

        A nanny ends if its worker is killed while the worker is starting.
        """
        self._workers = [self._worker() if worker.poll() is not None else worker for worker in self._workers]

    def stop(self) -> None:
        """End the scheduler and all workers."""
        for process in [*self._workers, self._scheduler]:
            process.terminate()
        for process in [*self._workers, self._scheduler]:
            process.wait(60)


@dataclass
class Storm:
    """The events of a sweep during which processes are killed, and its whole time [s].

    The events are the numbers of killed workers and clients, and the number of restarts of the database.
    """

    workers: int = 0
    databases: int = 0
    clients: int = 0
    seconds: float = 0.0


def kill_workers(cluster: Cluster, storm: Storm, calm: Event) -> None:
    """Kill a random worker of a cluster every few seconds, until the event `calm` is set."""
    chance = random.Random(0)
    while not calm.wait(KILL_EVERY):
        cluster.start_again()
        with suppress(OSError):  # the worker ended by itself
            storm.workers += cluster.kill_one(chance)


def run_storm(file: Path, out: Path, studies: int, server: postgres.Server) -> Storm:
    """Run a sweep, a list of learning tasks, to its end while workers, database and client are killed."""
    storm, calm, begun = Storm(), Event(), time.monotonic()
    restarts, kills = list(DATABASE_RESTARTED_AT), list(CLIENT_KILLED_AT)
    with TemporaryDirectory() as scratch:
        cluster = Cluster(Path(scratch), WORKERS)
        options = ["--scheduler", cluster.address, "--storage", server.address]
        killer = Thread(target=kill_workers, args=(cluster, storm, calm))
        killer.start()
        client = start(file, out, *options)
        try:
            while (code := client.poll()) is None or code < 0:
                done = complete(out) / studies
                if restarts and done >= restarts[0][0]:
                    server.control("restart", "-m", restarts.pop(0)[1])
                    storm.databases += 1
                if code is not None:
                    client = start(file, out, *options)
                elif kills and done >= kills[0]:
                    kills.pop(0)
                    client.kill()
                    client.wait()
                    storm.clients += 1
                time.sleep(0.2)
            if code != 0:
                raise SystemExit(
                    f"the client ended with {code}: {client.stderr.read().decode() if client.stderr else ''}"
                )
        finally:
            calm.set()
            killer.join()
            client.kill()
            cluster.stop()
    storm.seconds = time.monotonic() - begun
    return storm


def proof(studies: int) -> str:
    """Return a table that compares two runs of the same learning tasks.

    During the first run, processes are killed. The second run is undisturbed.
    """
    with TemporaryDirectory() as folder, postgres.running() as server:
        file = sweep_file(Path(folder), studies)
        calm = start(file, Path(folder) / "calm", "--at-a-time", "4")  # runs at the same time on one core
        storm = run_storm(file, Path(folder) / "storm", studies, server)
        if calm.wait() != 0:
            raise SystemExit(calm.stderr.read().decode() if calm.stderr else "")
        expected, found = results(Path(folder) / "calm"), results(Path(folder) / "storm")
        trials = int(server.query("SELECT count(*) FROM trials"))
        twice = int(
            server.query("SELECT count(*) FROM (SELECT 1 FROM trials GROUP BY study_id, number HAVING count(*) > 1) t")
        )
        held = int(server.query("SELECT count(*) FROM studies"))
    equal = sum(found.get(name) == digest for name, digest in expected.items())
    rows = [
        ("studies", f"{len(found)} of {studies}"),
        ("studies in the database", str(held)),
        ("trials in the database", f"{trials} of {3 * studies}, {twice} twice"),
        ("workers killed", str(storm.workers)),
        ("PostgreSQL restarted", str(storm.databases)),
        ("clients killed", str(storm.clients)),
        ("results equal to the undisturbed ones", f"{equal} of {len(expected)}"),
    ]
    table = markdown([{"": name, "result": value} for name, value in rows])
    print(table, flush=True)
    sound = (len(found), held, trials, twice, equal) == (studies, studies, 3 * studies, 0, studies)
    if not sound or (storm.databases, storm.clients) != (2, 2) or not storm.workers:
        raise SystemExit("something was lost, doubled or not tried")
    return table


def nap(seconds: float) -> float:
    """Sleep for a time [s], and return this time. In measurements, this call takes the place of a simulation."""
    time.sleep(seconds)
    return seconds


def rounds(executor: Executor, workers: int, seconds: float) -> tuple[float, float]:
    """Let workers sleep in several rounds, and return two results of the fastest round.

    The results are the fraction of time in which workers were busy, and the overhead of a call [ms].
    """
    had = []
    calls = workers * CALLS
    for _ in range(ROUNDS):
        begun = time.monotonic()
        futures = [executor.submit(nap, seconds) for _ in range(calls)]
        for future in futures:
            future.result()
        had.append(workers * (time.monotonic() - begun))
    slept = calls * seconds
    return slept / min(had), 1e3 * (min(had) - slept) / calls


def napped(processes: int, together: int | None, seconds: float) -> tuple[float, float, float]:
    """Run `rounds` on Dask workers, and return its results and the client's processor time per call [ms].

    The scheduler and the workers are separate processes, as on a cluster.
    """
    from tatamu.cluster import connected

    workers = processes * (together or 1)
    with TemporaryDirectory() as scratch:
        cluster = Cluster(Path(scratch), processes, together)
        try:
            with connected(cluster.address) as executor:
                while executor.threads < workers:
                    time.sleep(0.2)
                list(executor.map(nap, [0.01] * 4 * workers))
                worked = time.process_time()
                busy, beside = rounds(executor, workers, seconds)
                worked = time.process_time() - worked
        finally:
            cluster.stop()
    return busy, beside, 1e3 * worked / (workers * CALLS * ROUNDS)


@cache
def rollout() -> float:
    """Return the shortest time of three simulations of the default towel on this machine [s]."""
    evaluate = Nominal(make_task("towel"))
    parameters = {"x1": 0.1, "z1": 0.1, "x2": 0.3, "z2": 0.1, "g1": 0, "g2": 0}
    found = [evaluate(parameters).rollout for _ in range(3)]
    return round(min(each.info["wall_seconds"] for each in found if each is not None), 2)


def overhead() -> str:
    """Return a table with the overhead of a call on four processes, for Dask and for Python's own process pool."""
    busy, beside, here = napped(WORKERS, None, rollout())
    with ProcessPoolExecutor(WORKERS) as pool:
        list(pool.map(nap, [0.01] * 4 * WORKERS))
        pool_busy, pool_beside = rounds(pool, WORKERS, rollout())
    head = (
        "four processes",
        f"beside a sleep of {rollout():g} s, each call [ms]",
        "busy",
        "client, each call, of a core [ms]",
    )
    rows = [
        ("Dask", f"{beside:.1f}", f"{100 * busy:.1f} %", f"{here:.1f}"),
        ("`ProcessPoolExecutor`", f"{pool_beside:.1f}", f"{100 * pool_busy:.1f} %", "-"),
    ]
    table = markdown([dict(zip(head, row, strict=True)) for row in rows])
    print(table, flush=True)
    if not beside < 5.0:
        raise SystemExit(f"a call costs {beside:.1f} ms beside its rollout, not below 5")
    return table


def busy() -> str:
    """Return a table with the fraction of time in which 64 workers are busy.

    Workers are the parts of a cluster that run function calls. Here, the called function only sleeps, for as long as a
    simulation takes. Four processes have 16 workers each, with one thread per worker.
    """
    share, _, here = napped(64 // TOGETHER, TOGETHER, rollout())
    row = {
        "workers": "64",
        "sleep [s]": f"{rollout():g}",
        "busy": f"{100 * share:.1f} %",
        "client, each call, of a core [ms]": f"{here:.1f}",
    }
    table = markdown([row])
    print(table, flush=True)
    if share < 0.95:
        raise SystemExit(f"64 workers were busy {100 * share:.1f} % of the time, not 95")
    return table


def main() -> None:
    """Parse the command line, and run the chosen parts of the study."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("only", nargs="*", choices=["storm", "overhead", "busy", "constants", []])
    parser.add_argument("--studies", type=int, default=200)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    from studies.cluster_storm.constants import constants

    runs: dict[str, Callable[[], str | dict[str, str]]] = {
        "overhead": overhead,
        "busy": busy,
        "constants": constants,
        "storm": lambda: proof(options.studies),
    }
    for name, run in runs.items():
        if options.only and name not in options.only:
            continue
        table = run()
        if options.write_docs:
            for part, text in table.items() if isinstance(table, dict) else [(name, table)]:
                publish(f"cluster: {part}", text)


if __name__ == "__main__":
    main()
