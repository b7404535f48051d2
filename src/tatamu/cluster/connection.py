"""Connects to a running scheduler, or starts a scheduler and workers that end when the program ends."""

from __future__ import annotations

import asyncio
import logging
import re
import sys
import warnings
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tatamu.base.errors import InputError, UnavailableError
from tatamu.base.extras import lacking

if TYPE_CHECKING:
    import distributed

    from tatamu.cluster.executor import DaskExecutor

CONNECT_SECONDS = 5.0
"""Time limit for a scheduler's answer when the program connects to the scheduler [s]."""
OLDEST_DASK = (2026, 3)
"""Oldest version of Dask that works together with the newest, as in pyproject.toml: year and month."""
CERTIFICATES = tuple(f"distributed.comm.tls.{name}" for name in ("ca-file", "client.cert", "client.key"))
"""Fields of Dask's configuration that a client needs for addresses `tls://`."""
SETTINGS: dict[str, Any] = {
    "logging": {
        **{f"distributed.{part}": "critical" for part in ("client", "nanny", "worker", "scheduler")},
        **{name: "critical" for name in ("distributed", "bokeh", "tornado")},
    },
    "distributed.scheduler.allowed-failures": 2,  # if a third worker dies during a call, the call fails
    "distributed.comm.retry.count": 2,
    "distributed.worker.profile.enabled": False,  # profiling takes 1 % of a core
    "distributed.admin.tick.interval": "1s",  # the default is fifty ticks a second in every Dask process
    "distributed.deploy.lost-worker-timeout": "1 day",  # with less, a worker that dies twice in 15 s is not restarted
}


@dataclass(frozen=True)
class SchedulerAddress:
    """The address of a scheduler."""

    text: str
    """The address as the user gave it."""
    local: int | None
    """Number of worker processes to start on this machine; None if the scheduler is already running."""


def parse_address(text: str) -> SchedulerAddress:
    """Read an address.

    Raises:
        InputError: If the text is not an address.
    """
    if found := re.fullmatch(r"local:([0-9]{1,6})", text):
        count = int(found[1])
        if not 1 <= count <= 1024:
            raise InputError(f"--scheduler: local:N must have from 1 to 1024 workers, given {text!r}")
        return SchedulerAddress(text, count)
    if found := re.fullmatch(r"(?:tcp|tls)://(?:\[[0-9a-fA-F:.%]+\]|[\w.-]+):([0-9]{1,5})", text):
        if 1 <= int(found[1]) <= 65535:
            return SchedulerAddress(text, None)
    raise InputError(
        "--scheduler: must be tcp://HOST:PORT, tls://HOST:PORT, or local:N for N processes on this machine, "
        f"given {text!r}"
    )


def executor_at(address: str | None) -> AbstractContextManager[Executor | None]:
    """Return a context with the workers of a scheduler as an executor; None if no address is given.

    Args:
        address: Address of the scheduler: `tcp://HOST:PORT`, `tls://HOST:PORT` or `local:N`; None to use no scheduler.

    Raises:
        InputError: If the address is invalid, Dask is not installed, or versions differ.
        UnavailableError: If no scheduler answers.
    """
    return nullcontext() if address is None else connected(address)


@contextmanager
def connected(address: str) -> Iterator[DaskExecutor]:
    """Yield the workers of a scheduler as an executor. `executor_at` lists the possible errors."""
    parsed = parse_address(address)
    _configure()
    if address.startswith("tls://"):
        _check_certificates(address)
    from tatamu.cluster.executor import DaskExecutor

    with _client(parsed) as client:
        refuse_other_versions(client, address)
        executor = DaskExecutor(client, address)
        try:
            yield executor
        finally:
            executor.shutdown(wait=False, cancel_futures=True)


def _configure() -> None:
    """Import Dask with the configuration `SETTINGS`, which also suppresses Dask's log messages."""
    try:
        import dask

        dask.config.set(SETTINGS)
        import distributed  # noqa: F401
    except ImportError:
        raise lacking("dask", "cluster", "--scheduler") from None


def _check_certificates(address: str) -> None:
    """Refuse an address `tls://` without the files of certificates."""
    import dask

    for field in CERTIFICATES:
        given = dask.config.get(field, None)
        if given is None:
            raise InputError(f"--scheduler: {address}: needs certificates; set {field} in the Dask configuration")
        if not Path(given).is_file():
            raise InputError(
                f"--scheduler: {address}: {field} in the Dask configuration must name an existing file, given {given}"
            )


@contextmanager
def _client(address: SchedulerAddress) -> Iterator[distributed.Client]:
    import distributed

    with ExitStack() as stack:
        to: Any = address.text
        if address.local is not None:
            to = stack.enter_context(
                distributed.LocalCluster(
                    n_workers=address.local,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address="127.0.0.1:0",
                    host="127.0.0.1",
                    silence_logs=logging.CRITICAL,
                    memory_limit=0,
                )
            )
        try:
            if address.local is None:
                _refuse_old_scheduler(address.text)
            client = distributed.Client(to, timeout=CONNECT_SECONDS, set_as_default=False, name="tatamu")
        except (OSError, TimeoutError, ValueError) as error:
            reason = " ".join(str(error).split())[:160] or f"no answer after {CONNECT_SECONDS:g} s"
            raise UnavailableError(
                f"--scheduler: {address.text} does not answer ({reason}); correct the address, or start the scheduler"
            ) from None
        try:
            yield client
        finally:
            client.close(timeout=5)


def _refuse_old_scheduler(address: str) -> None:
    """Ask a scheduler for its version of Dask, because a client that does not understand the scheduler ends oddly.

    Raises:
        InputError: If the version is too old.
        OSError: If the scheduler does not answer.
    """
    import distributed

    async def ask() -> Any:
        security = distributed.Security().get_connection_args("client")
        async with distributed.rpc(address, timeout=CONNECT_SECONDS, connection_args=security) as scheduler:
            return await asyncio.wait_for(scheduler.versions(), CONNECT_SECONDS)

    with ThreadPoolExecutor(1) as thread:  # the caller may have an event loop of its own, as notebooks have
        _refuse_old_dask(address, "the scheduler", thread.submit(asyncio.run, ask()).result())


def _refuse_old_dask(address: str, process: str, found: Any) -> None:
    """Raise an error if a process has a version of Dask that does not work together with this one."""
    text = str(found["packages"]["distributed"]) if isinstance(found, dict) and "packages" in found else "?"
    if tuple(map(int, re.findall("[0-9]+", text)[:2])) < OLDEST_DASK:
        here = version("distributed")
        raise InputError(
            f"--scheduler: {address}: {process} runs Dask {text}, but this machine has {here}; install the same version"
        )


def refuse_other_versions(client: distributed.Client, name: str) -> None:
    """Compare the versions of packages on all workers with the versions in this process.

    If the kinds of processors differ, a warning is printed.

    Raises:
        InputError: If a version differs.
    """
    from tatamu.cluster.versions import difference, identify, processor

    with warnings.catch_warnings(action="ignore"):  # of Dask's own, in a table of several lines
        of_dask: Any = client.get_versions()
    for worker, found in of_dask["workers"].items():
        _refuse_old_dask(name, f"worker {worker}", found)
    kinds = {processor()}
    for worker, found in client.run(identify, on_error="return").items():
        if isinstance(found, OSError):  # the worker has died; the first call on its successor checks the versions
            continue
        if isinstance(found, BaseException):
            raise InputError(f"--scheduler: {name}: worker {worker} cannot run tatamu ({found}); install tatamu there")
        there, kind = found
        if differing := difference(there):
            raise InputError(
                f"--scheduler: {name}: worker {worker} has {differing} as on this machine; install the same versions"
            )
        kinds.add(kind)
    if len(kinds) > 1:
        named = ", ".join(sorted(kinds))
        text = f"warning: {name}: different processors ({named}), so last digits of results may differ"
        print(text, file=sys.stderr)
