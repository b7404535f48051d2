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
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
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


@dataclass
class Cluster:
    """A scheduler and workers as processes of their own."""

    workers: int
    address: str = ""
    processes: list[subprocess.Popen[bytes]] = field(default_factory=list)

    @contextmanager
    def running(self) -> Iterator[Cluster]:
        """The processes, until the block ends."""
        environment = {**os.environ, "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "3"}
        environment |= {"DASK_LOGGING__DISTRIBUTED": "error"}
        dask = [sys.executable, "-m", "dask"]
        with TemporaryDirectory() as folder:
            said = Path(folder) / "scheduler.json"
            common: dict[str, Any] = {"env": environment, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
            told = ["--scheduler-file", str(said)]
            where = ["--host", "127.0.0.1", "--port", "0", "--dashboard-address", "127.0.0.1:0"]
            self.processes.append(subprocess.Popen([*dask, "scheduler", *told, *where], **common))
            while not said.exists() or not said.read_text():
                time.sleep(0.1)
            self.address = json.loads(said.read_text())["address"]
            options = ["--nworkers", str(self.workers), "--nthreads", "1", "--local-directory", folder]
            options += ["--memory-limit", "0", "--host", "127.0.0.1"]
            self.processes.append(subprocess.Popen([*dask, "worker", self.address, *options], **common))
            try:
                yield self
            finally:
                for process in reversed(self.processes):
                    process.terminate()
                for process in self.processes:
                    process.wait(30)

    def worker_ids(self) -> list[int]:
        """The processes that work: children of the one that starts them again."""
        lists = Path(f"/proc/{self.processes[1].pid}/task").glob("*/children")
        children = [int(word) for path in lists for word in path.read_text().split()]
        return [child for child in children if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes()]


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
        try:
            os.kill(chance.choice(cluster.worker_ids()), signal.SIGKILL)
        except (OSError, IndexError):  # it ended by itself
            continue
        storm.workers += 1


def run_storm(file: Path, out: Path, studies: int, server: postgres.Server) -> Storm:
    """A sweep to its end, whatever is killed meanwhile."""
    storm, calm, begun = Storm(), Event(), time.monotonic()
    restarts, kills = list(DATABASE_RESTARTED_AT), list(CLIENT_KILLED_AT)
    with Cluster(WORKERS).running() as cluster:
        options = ["--scheduler", cluster.address, "--storage", server.address]
        killer = Thread(target=kill_workers, args=(cluster, storm, calm))
        killer.start()
        try:
            client = start(file, out, *options)
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
                if int(time.monotonic()) % 30 == 0:
                    print(f"{time.monotonic() - begun:.0f} s: {done:.0%}, {storm}", flush=True)
            if code != 0:
                raise SystemExit(
                    f"the client ended with {code}: {client.stderr.read().decode() if client.stderr else ''}"
                )
        finally:
            calm.set()
            killer.join()
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
