"""Measures the time, the messages and the bytes that a trial takes, and computes from them what 1,000 workers need."""

from __future__ import annotations

import json
import os
import pickle
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from inspect import iscoroutinefunction
from statistics import median
from tempfile import TemporaryDirectory
from typing import Any, ClassVar

from benchmarks.tables import markdown
from tests import postgres

from tatamu import GPSearch, LearnOptions, Nominal, Space, Trial, learn, make_task, register_search
from tatamu.cluster.versions import versions
from tatamu.evaluation import Incumbent
from tatamu.search import HIGH, Proposal
from tatamu.study.database import CONNECTIONS, shared_database
from tatamu.study.store import StudyStore

WORKERS = 1000
SECONDS = 1.0
"""Assumed time of a simulation on the cluster [s]."""
CALLS = 200
STUDIES = 50
"""Number of trials of a study on the cluster."""


def nothing(number: int) -> int:
    """Return `number`. The call takes almost no time, so it shows the cost of a call."""
    return number


@dataclass
class Constants:
    """Time, messages and bytes that a trial of a study on a cluster takes."""

    messages: float = 0.0
    """Number of messages per trial that the scheduler of the cluster receives."""
    scheduler: float = 0.0
    """Processor time of scheduler and client together per trial [ms]."""
    call: int = 0
    """Size of the call that starts a trial on a worker, without data that are sent only once [bytes]."""
    result: int = 0
    """Size of the result of a trial without its rollout, the motion of the cloth [bytes]."""
    scene: int = 0
    """Size of the data that a study sends once to each worker [bytes]."""
    rollout: int = 0
    """Size of a rollout, the motion of the cloth in a simulation [bytes]. Each study sends only a few rollouts."""
    ask: float = 0.0
    """Processor time that the search needs to propose a trial, as a median over a study [ms]."""
    commits: float = 0.0
    """Number of database transactions per trial."""
    tell: float = 0.0
    """Time of recording a trial in the database [ms]."""
    connections: int = 0
    """Largest number of database connections of a client."""
    row: float = 0.0
    """Size of a trial in the database [bytes]."""


def constants() -> dict[str, str]:
    """Return two tables: the measured time and bytes per trial, and the needs of 1,000 workers.

    The keys are the names of the tables' marks in the docs.
    """
    found = Constants()
    _dask(found)
    _bytes(found)
    _search(found)
    measured = markdown([{"of one trial": name, "measured": value} for name, value in _rows(found)])
    computed = markdown([{f"{WORKERS:,} workers": name, "computed": value} for name, value in _needs(found)])
    print(f"{measured}\n\n{computed}", flush=True)
    return {"constants": measured, "thousand": computed}


def _dask(found: Constants) -> None:
    """Measure the messages and the processor time of a cluster's scheduler and client per trial.

    Scheduler and client run in this process, and the workers run in other processes.
    """
    from tatamu.cluster.connection import _configure
    from tatamu.cluster.executor import DaskExecutor

    _configure()
    import distributed

    seen: Counter[str] = Counter()

    def counted(name: str, handler: Callable[..., Any]) -> Callable[..., Any]:
        async def count_later(*args: Any, **kwargs: Any) -> Any:
            seen[name] += 1
            return await handler(*args, **kwargs)

        def count(*args: Any, **kwargs: Any) -> Any:
            seen[name] += 1
            return handler(*args, **kwargs)

        return count_later if iscoroutinefunction(handler) else count

    options = {"n_workers": 2, "threads_per_worker": 1, "memory_limit": 0, "dashboard_address": "127.0.0.1:0"}
    with (
        distributed.LocalCluster(**options, silence_logs=50) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        executor = DaskExecutor(client, "local")
        list(executor.map(nothing, range(20)))
        for handlers in (cluster.scheduler.stream_handlers, cluster.scheduler.handlers):
            for name in ("update-graph", "client-releases-keys", "task-finished", "gather", "long-running", "add-keys"):
                if name in handlers:
                    handlers[name] = counted(name, handlers[name])
        begun = time.process_time()
        for future in [executor.submit(nothing, number) for number in range(CALLS)]:
            future.result()
        found.scheduler = 1e3 * (time.process_time() - begun) / CALLS
        executor.shutdown()
    found.messages = sum(seen.values()) / CALLS


def _bytes(found: Constants) -> None:
    """Measure the sizes of the data that are sent for a trial with the default towel."""
    evaluate = Nominal(make_task("towel"))
    parameters = {"x1": 0.1, "z1": 0.1, "x2": 0.3, "z2": 0.1, "g1": 0, "g2": 0}
    evaluation = evaluate(parameters)
    found.scene = len(pickle.dumps(evaluate))
    found.call = len(pickle.dumps((parameters, Incumbent(1.0), dict(versions()))))
    found.result = len(pickle.dumps(replace(evaluation, rollout=None)))
    found.rollout = len(pickle.dumps(evaluation)) - found.result


class TimedSearch(GPSearch):
    """The default search, which also measures how long it takes to propose each trial."""

    seconds: ClassVar[list[float]] = []
    """Processor time that each proposal of a trial took [s]."""

    def ask(self, fidelity: int = HIGH) -> Proposal:
        """Propose the next trial, and record the processor time that this takes."""
        started = time.thread_time()
        proposal = super().ask(fidelity)
        self.seconds.append(time.thread_time() - started)
        return proposal


def _search(found: Constants) -> None:
    """Measure the time of the search and of the database per trial.

    The study is of a small towel, with one trial at a time.
    """
    told = []
    add = StudyStore.add

    def timed_add(self: StudyStore, trial: Trial, space: Space) -> None:
        started = time.perf_counter()
        add(self, trial, space)
        told.append(time.perf_counter() - started)

    os.environ["PGPASSWORD"] = postgres.PASSWORD
    task = make_task("towel", size=(0.24, 0.5), spacing=0.04)
    register_search("timed", TimedSearch)
    first = LearnOptions(trials=1, sampler="timed", baselines=False, disturbances="none", parallel=1)
    StudyStore.add = timed_add  # type: ignore[method-assign]
    try:
        with TemporaryDirectory() as folder, postgres.running() as server:
            with shared_database(server.address) as database:
                learn(task, first, out=folder, database=database)
                before = _state(server)
                learn(task, first.model_copy(update={"trials": STUDIES}), out=folder, database=database)
            after = _state(server)
    finally:
        StudyStore.add = add  # type: ignore[method-assign]
    found.ask = 1e3 * median(TimedSearch.seconds)
    found.tell = 1e3 * median(told)
    found.commits = (after["commits"] - before["commits"]) / (STUDIES - 1)
    found.row = (after["size"] - before["size"]) / (STUDIES - 1)
    found.connections = CONNECTIONS + 1


def _state(server: postgres.Server) -> dict[str, int]:
    time.sleep(1.5)  # statistics are written with a delay
    commits = "SELECT xact_commit FROM pg_stat_database WHERE datname = current_database()"
    tables = "SELECT sum(pg_total_relation_size(oid)) FROM pg_class WHERE relkind = 'r' AND relname LIKE 'trial%'"
    return {"commits": int(server.query(commits)), "size": int(server.query(tables))}


def _rows(found: Constants) -> list[tuple[str, str]]:
    return [
        ("messages that the scheduler receives", f"{found.messages:.1f}"),
        ("scheduler and client, of a core", f"{found.scheduler:.1f} ms"),
        ("a proposal of `gp`, of a core, median of a study of 50", f"{found.ask:.0f} ms"),
        ("recording in PostgreSQL", f"{found.tell:.0f} ms, {found.commits:.1f} transactions, {found.row:.0f} bytes"),
        ("the call", f"{found.call / 1e3:.1f} kB"),
        ("its result, without the rollout", f"{found.result / 1e3:.1f} kB"),
        ("the rollout, of the few that are kept (default towel)", f"{found.rollout / 1e6:.1f} MB"),
        ("the scene, once for each study and worker (default towel)", f"{found.scene / 1e6:.2f} MB"),
    ]


def _needs(found: Constants) -> list[tuple[str, str]]:
    rate = WORKERS / SECONDS
    search = rate * found.ask / 1e3
    clients = max(1, round(search + 0.5))
    carried = rate * (found.call + found.result) / 1e6
    kept = rate / STUDIES * (5 * found.rollout + 20 * found.scene) / 1e6
    return [
        ("trials a second, of a second each", f"{rate:,.0f}"),
        ("messages that the scheduler receives, a second", f"{rate * found.messages:,.0f}"),
        ("cores for messages, at scheduler and clients", f"{rate * found.scheduler / 1e3:.1f}"),
        ("cores for proposals, at clients", f"{search:.1f}"),
        ("clients, so that none needs more than a core", f"{clients}"),
        ("connections of the database", f"{clients * found.connections}"),
        ("transactions of the database, a second", f"{rate * found.commits:,.0f}"),
        ("calls and results", f"{carried:.1f} MB/s"),
        ("scenes and rollouts, 5 kept and 20 workers for each study", f"{kept:.1f} MB/s"),
        ("the database grows by", f"{rate * found.row * 3600 / 1e9:.1f} GB/h"),
    ]


if __name__ == "__main__":
    print(json.dumps(constants(), indent=1))
