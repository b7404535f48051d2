"""Reads addresses of schedulers.

An address is `tcp://HOST:PORT` or `tls://HOST:PORT`. The address `local:N` starts N processes on this machine.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from tatamu.base.errors import InputError

MOST_LOCAL = 1024
"""Largest number of worker processes that can be started on this machine."""


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
        if not 1 <= count <= MOST_LOCAL:
            raise InputError(f"--scheduler: local:N takes from 1 to {MOST_LOCAL} workers, given {text!r}")
        return SchedulerAddress(text, count)
    if found := re.fullmatch(r"(?:tcp|tls)://(?:\[[0-9a-fA-F:.%]+\]|[\w.-]+):([0-9]{1,5})", text):
        if 1 <= int(found[1]) <= 65535:
            return SchedulerAddress(text, None)
    raise InputError(
        f"--scheduler: must be tcp://HOST:PORT, tls://HOST:PORT, or local:N for N processes here, given {text!r}"
    )
