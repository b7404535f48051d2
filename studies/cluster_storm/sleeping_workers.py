"""Runs several Dask workers with one thread each in this process. They can share a process because they only sleep.

The command's arguments are the address of the scheduler and the number of workers.
"""

from __future__ import annotations

import asyncio
import sys

from distributed import Worker


async def work(address: str, count: int) -> None:
    """Run `count` Dask workers until their scheduler ends."""
    workers = [Worker(address, nthreads=1, host="127.0.0.1", dashboard=False, memory_limit=0) for _ in range(count)]
    await asyncio.gather(*workers)
    await asyncio.gather(*(worker.finished() for worker in workers))


if __name__ == "__main__":
    asyncio.run(work(sys.argv[1], int(sys.argv[2])))
