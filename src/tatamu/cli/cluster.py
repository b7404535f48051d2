"""The options of commands whose work may go to other processes, and whose studies may be in a shared database."""

from __future__ import annotations

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
