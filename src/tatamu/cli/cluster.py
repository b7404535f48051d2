"""The options `--scheduler` and `--storage` of several commands."""

from __future__ import annotations

from concurrent.futures import Executor
from typing import Annotated

import typer

SchedulerOption = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Use the workers of a Dask scheduler, tcp://HOST:PORT, or N processes on this machine, local:N.",
    ),
]
StorageOption = Annotated[
    str | None,
    typer.Option(
        "--storage",
        metavar="URL",
        help="Keep studies in postgresql://USER@HOST/DB; the password is in PGPASSWORD or ~/.pgpass.",
    ),
]

MAX_AT_A_TIME = 256
"""Largest number of studies at a time, each of which takes a thread."""
CALLS_PER_THREAD = 2
"""Trials for each thread of the workers: one runs, and one waits."""


def at_a_time(executor: Executor | None, pending: int) -> int:
    """Return how many studies, each with `pending` trials at a time, keep all workers busy; 1 without workers."""
    threads = getattr(executor, "threads", None)
    if threads is None:
        return 1
    return min(MAX_AT_A_TIME, 1 + -(-CALLS_PER_THREAD * int(threads) // pending))
