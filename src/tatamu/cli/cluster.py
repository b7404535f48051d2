"""The options `--scheduler` and `--storage` of several commands.

They run trials in other processes, and keep studies in a shared database.
"""

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

MOST_AT_A_TIME = 256
"""Largest number of studies that run at the same time.

Each study takes a thread, which proposes trials and waits for their results.
"""
CALLS_PER_THREAD = 2
"""Number of trials that each thread of the worker processes receives at a time: one trial runs, and one waits."""


def at_a_time(executor: Executor | None, pending: int) -> int:
    """Return how many studies must run at the same time to keep all worker processes busy; 1 without workers.

    Each study evaluates `pending` trials at the same time.
    """
    threads = getattr(executor, "threads", None)
    if threads is None:
        return 1
    return min(MOST_AT_A_TIME, 1 + -(-CALLS_PER_THREAD * int(threads) // pending))
