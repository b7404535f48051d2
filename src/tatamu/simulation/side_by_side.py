"""Simulation of several scenes at the same time."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import contextmanager

from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene


def processors() -> int:
    """Return the number of processors that this process is allowed to use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def executor_of(given: Executor | None, most: int) -> Iterator[Executor]:
    """Yield the given executor, or one with a thread per processor, but at most `most` threads."""
    if given is not None:
        yield given
        return
    with ThreadPoolExecutor(min(most, processors())) as pool:
        try:
            yield pool
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise


def side_by_side(simulate: Callable[[Scene], Rollout], scenes: Sequence[Scene]) -> list[Rollout]:
    """Simulate scenes in threads, one per available processor; the rollouts have the order of the scenes."""
    with ThreadPoolExecutor(max(1, min(len(scenes), processors()))) as pool:
        return list(pool.map(simulate, scenes))
