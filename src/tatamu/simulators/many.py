"""Several scenes at a time."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

from tatamu.rollout import Rollout
from tatamu.scene import Scene


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def side_by_side(simulate: Callable[[Scene], Rollout], scenes: Sequence[Scene]) -> list[Rollout]:
    """Run scenes in threads, as many at a time as this process may use processors; rollouts in the order given."""
    with ThreadPoolExecutor(max(1, min(len(scenes), processors()))) as pool:
        return list(pool.map(simulate, scenes))
