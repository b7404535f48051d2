"""Constants of one trial, measured, and what 1,000 workers would need, computed from them."""

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
from typing import Any
from unittest.mock import patch

from benchmarks.tables import markdown
from tests import postgres

WORKERS = 1000
SECONDS = 1.0
"""Of a rollout, on the page's cluster."""
CALLS = 200
STUDIES = 50
"""Trials of a study."""


def nothing(number: int) -> int:
    """A call that takes no time."""
    return number


@dataclass
class Constants:
    """Time, messages and bytes of one trial."""

    messages: float = 0.0
    """That the scheduler receives."""
    scheduler: float = 0.0
    """Time of a core at the scheduler and at the client together [ms]."""
    call: int = 0
    """Bytes of a call, without what goes over once."""
    result: int = 0
    """Bytes of a result without its rollout."""
    scene: int = 0
    """Bytes that a study sends once to each worker."""
    rollout: int = 0
    """Bytes of a rollout, of which a few come for each study."""
    ask: float = 0.0
    """Time of a core that a proposal takes, median over a study [ms]."""
    commits: float = 0.0
    """Transactions of the database."""
    tell: float = 0.0
    """Time that recording takes [ms]."""
    connections: int = 0
    """Of one client at most."""
    row: float = 0.0
    """Bytes in the database."""


def constants() -> dict[str, str]:
    """Both tables, by the names of their marks."""
    found = Constants()
    _dask(found)
    _bytes(found)
    _search(found)
    measured = markdown([{"of one trial": name, "measured": value} for name, value in _rows(found)])
    computed = markdown([{f"{WORKERS:,} workers": name, "computed": value} for name, value in _needs(found)])
    print(f"{measured}\n\n{computed}", flush=True)
    return {"constants": measured, "thousand": computed}


def _dask(found: Constants) -> None:
    """Messages that the scheduler handles, and time: scheduler and client are this process, workers are not."""
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
    """Sizes of what goes over, for the default towel."""
    from tatamu.cluster.versions import versions
    from tatamu.evaluation import Incumbent, Nominal
    from tatamu.folding.task import make_task

    evaluate = Nominal(make_task("towel"))
    parameters = {"x1": 0.1, "z1": 0.1, "x2": 0.3, "z2": 0.1, "g1": 0, "g2": 0}
    evaluation = evaluate(parameters)
    bare = replace(evaluation, rollout=None)
    found.scene = len(pickle.dumps(evaluate))
    found.call = len(pickle.dumps((parameters, Incumbent(1.0), dict(versions()))))
    found.result = len(pickle.dumps(bare))
    found.rollout = len(pickle.dumps(evaluation)) - found.result


def _search(found: Constants) -> None:
    """Proposals and the database: one study of a small towel, one trial after another."""
    from tatamu.api import learn
    from tatamu.folding.task import make_task
    from tatamu.options import LearnOptions
    from tatamu.search.gp import GPSearch
    from tatamu.study.database import CONNECTIONS, shared_database
    from tatamu.study.store import StudyStore

    asked, told = [], []
    ask, add = GPSearch.ask, StudyStore.add

    def timed_ask(self: GPSearch, *args: Any) -> Any:
        begun = time.thread_time()
        proposed = ask(self, *args)
        asked.append(time.thread_time() - begun)
        return proposed

    def timed_add(self: StudyStore, *args: Any) -> None:
        begun = time.perf_counter()
        add(self, *args)
        told.append(time.perf_counter() - begun)

    def options(trials: int) -> LearnOptions:
        return LearnOptions(trials=trials, disturbances="none", coarse=False, parallel=1, baselines=False)

    os.environ["PGPASSWORD"] = postgres.PASSWORD
    task = make_task("towel", size=(0.24, 0.5), spacing=0.04)
    with (
        patch.object(GPSearch, "ask", timed_ask),
        patch.object(StudyStore, "add", timed_add),
        TemporaryDirectory() as folder,
        postgres.running() as server,
    ):
        with shared_database(server.address) as database:
            learn(task, options(1), out=folder, database=database)
            before = _state(server)
            learn(task, options(STUDIES), out=folder, database=database)
        after = _state(server)
    found.ask = 1e3 * median(asked)
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
