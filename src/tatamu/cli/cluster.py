"""The options of commands whose work may go to other processes, and whose studies may be in a shared database."""

from __future__ import annotations

from concurrent.futures import Executor
from typing import Annotated

import typer

SchedulerOption = Annotated[
    str | None,
    typer.Option(
        "--scheduler",
        metavar="ADDRESS",
        help="Work on the workers of a Dask scheduler, tcp://HOST:PORT, or on N processes here, local:N.",
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
"""Studies at a time at most: each is a thread that proposes trials and waits for them."""
CALLS_PER_THREAD = 2
"""Trials under way for each thread of the workers: one runs, one waits."""


def at_a_time(executor: Executor | None, pending: int) -> int:
    """How many studies at a time keep all workers busy, with so many pending trials each; 1 without workers."""
    threads = getattr(executor, "threads", None)
    if threads is None:
        return 1
    return min(MOST_AT_A_TIME, 1 + -(-CALLS_PER_THREAD * int(threads) // pending))
