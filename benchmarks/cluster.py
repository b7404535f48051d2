"""What many machines give and stand: workers, database and client killed; overhead; what 1,000 workers would need.

The tables of docs/notes/cluster.md:

    python -m benchmarks.cluster [storm] [overhead] [busy] [constants] [--studies 200] [--write-docs]

Needs `tatamu[cluster]` and, for `storm` and `constants`, PostgreSQL: a server of its own, in a folder that is thrown
away. Everything runs on this machine in real processes.
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
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event, Thread
from typing import Any

from benchmarks.tables import markdown, publish
from tests import postgres

WORKERS = 4
KILL_EVERY = 8.0
"""Seconds between two workers killed."""
CLIENT_KILLED_AT = (0.3, 0.6)
DATABASE_RESTARTED_AT = ((0.2, "fast"), (0.5, "immediate"))
"""When, in parts of the studies that are complete, and how."""
ROLLOUT = 0.3
"""Seconds that a sleeping call sleeps: a rollout of the default towel takes about as long."""
CLIENT = """
import sys
import tatamu.report.topview
tatamu.report.topview.WIDE = 60  # pictures are most of a small study
from tatamu.cli import main
main()
"""


def sweep_file(folder: Path, studies: int) -> Path:
    """A sweep of small studies."""
    path = folder / "sweep.toml"
    seeds = list(range(studies))
    path.write_text(
        '[all]\ngarment = "towel"\nsize = "0.24x0.50"\nspacing = 0.04\ntrials = 3\nbaselines = false\n'
        f"[grid]\nseed = {seeds}\n"
    )
    return path


def start(file: Path, out: Path, *options: str) -> subprocess.Popen[bytes]:
    """Start a client."""
    command = [sys.executable, "-c", CLIENT, "sweep", str(file), "--out", str(out), *options]
    environment = {**os.environ, "PGPASSWORD": postgres.PASSWORD}
    return subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def complete(out: Path) -> int:
    """How many tasks of a sweep are complete."""
    try:
        tasks = json.loads((out / "sweep.json").read_text())["tasks"]
    except (OSError, ValueError):
        return 0
    return sum(task["state"] == "complete" for task in tasks)


def results(out: Path) -> dict[str, str]:
    """A digest of each study: trials without their times, manipulation, scene, and the bytes of the rollout."""
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
    """A scheduler, and workers that are started again when they end, as Slurm and Kubernetes do; all are processes."""

    def __init__(self, folder: Path, workers: int) -> None:
        self._folder = folder
        self._environment = {
            **os.environ,
            "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "3",  # Dask's own default
            "DASK_LOGGING__DISTRIBUTED": "error",
        }
        said = folder / "scheduler.json"
        self._scheduler = self._start(
            "scheduler", "--scheduler-file", str(said), "--port", "0", "--dashboard-address", "127.0.0.1:0"
        )
        while not said.exists() or not said.read_text():
            time.sleep(0.1)
        self.address: str = json.loads(said.read_text())["address"]
        self._workers = [self._worker() for _ in range(workers)]

    def _start(self, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "dask", *arguments, "--host", "127.0.0.1"]
        quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return subprocess.Popen(command, env=self._environment, **quiet)

    def _worker(self) -> subprocess.Popen[bytes]:
        own = ["--local-directory", str(self._folder), "--memory-limit", "0", "--dashboard-address", "127.0.0.1:0"]
        return self._start("worker", self.address, "--nworkers", "1", "--nthreads", "1", *own)

    def kill_one(self, chance: random.Random) -> bool:
        """Kill the process that works under one of the nannies; whether there was one."""
        lists = Path(f"/proc/{chance.choice(self._workers).pid}/task").glob("*/children")
        children = [int(word) for path in lists for word in path.read_text().split()]
        working = [child for child in children if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()]
        for child in working:
            os.kill(child, signal.SIGKILL)
        return bool(working)

    def start_again(self) -> None:
        """Start workers whose nannies have ended: one that is killed while it starts takes its nanny with it."""
        self._workers = [self._worker() if worker.poll() is not None else worker for worker in self._workers]

    def stop(self) -> None:
        """End all."""
        for process in [*self._workers, self._scheduler]:
            process.terminate()
        for process in [*self._workers, self._scheduler]:
            process.wait(60)


@dataclass
class Storm:
    """What was killed, and how often."""

    workers: int = 0
    databases: int = 0
    clients: int = 0
    seconds: float = 0.0


def kill_workers(cluster: Cluster, storm: Storm, calm: Event) -> None:
    """Kill a worker every few seconds."""
    chance = random.Random(0)
    while not calm.wait(KILL_EVERY):
        cluster.start_again()
        with suppress(OSError):  # it ended by itself
            storm.workers += cluster.kill_one(chance)


def run_storm(file: Path, out: Path, studies: int, server: postgres.Server) -> Storm:
    """A sweep to its end, whatever is killed meanwhile."""
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
    """The storm against the undisturbed sweep, as a table."""
    with TemporaryDirectory() as folder, postgres.running() as server:
        file = sweep_file(Path(folder), studies)
        calm = start(file, Path(folder) / "calm", "--at-a-time", "4")  # beside the storm: it needs one core
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
    """A call that sleeps as long as a rollout takes."""
    time.sleep(seconds)
    return seconds


def napped(workers: int, calls: int, seconds: float, threads: bool = False) -> tuple[float, float, float]:
    """The share of time that workers were busy, what a call costs beside its sleep [ms], and of this here [ms]."""
    from tatamu.cluster.connection import _configure
    from tatamu.cluster.executor import DaskExecutor

    _configure()
    import distributed

    kind = {"n_workers": workers, "threads_per_worker": 1, "processes": not threads, "memory_limit": 0}
    with (
        distributed.LocalCluster(**kind, dashboard_address="127.0.0.1:0", silence_logs=50) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        executor = DaskExecutor(client, "local")
        list(executor.map(nap, [0.01] * 2 * workers))
        begun, worked = time.monotonic(), time.process_time()
        futures = [executor.submit(nap, seconds) for _ in range(calls)]
        for future in futures:
            future.result()
        had = workers * (time.monotonic() - begun)
        worked = time.process_time() - worked
        executor.shutdown()
    return calls * seconds / had, 1e3 * (had - calls * seconds) / calls, 1e3 * worked / calls


def overhead() -> str:
    """Time of a call beside its sleep, on four processes."""
    busy, beside, here = napped(WORKERS, 400, ROLLOUT)
    row = {
        "sleep [ms]": f"{1e3 * ROLLOUT:.0f}",
        "beside it, each call [ms]": f"{beside:.1f}",
        "busy": f"{100 * busy:.1f} %",
        "client and scheduler, each call [ms of a core]": f"{here:.1f}",
    }
    table = markdown([row])
    print(table, flush=True)
    if not beside < 5.0:
        raise SystemExit(f"a call costs {beside:.1f} ms beside its rollout, not below 5")
    return table


def busy() -> str:
    """64 workers that sleep, as threads of this process: they need no core each."""
    rows = []
    for seconds in (ROLLOUT, 1.0):
        share, _, here = napped(64, int(64 * 12 / seconds), seconds, threads=True)
        rows.append(
            {"sleep [s]": f"{seconds:g}", "busy": f"{100 * share:.1f} %", "each call [ms of a core]": f"{here:.1f}"}
        )
    table = markdown(rows)
    print(table, flush=True)
    return table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("only", nargs="*", choices=["storm", "overhead", "busy", "constants", []])
    parser.add_argument("--studies", type=int, default=200)
    parser.add_argument("--write-docs", action="store_true")
    options = parser.parse_args()
    from benchmarks.cluster_constants import constants

    runs = {"overhead": overhead, "busy": busy, "constants": constants, "storm": lambda: proof(options.studies)}
    for name, run in runs.items():
        if options.only and name not in options.only:
            continue
        table = run()
        if options.write_docs:
            for part, text in table.items() if isinstance(table, dict) else [(name, table)]:
                publish(f"cluster: {part}", text)


if __name__ == "__main__":
    main()
