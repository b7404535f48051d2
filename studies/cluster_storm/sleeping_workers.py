"""Several Dask workers with one thread each in one process, which they can share because they only sleep.

Its arguments are the scheduler's address and the number of workers.
"""

from __future__ import annotations

import asyncio
import sys

from distributed import Worker


async def work(address: str, count: int) -> None:
    """Work for a scheduler until it ends."""
    workers = [Worker(address, nthreads=1, host="127.0.0.1", dashboard=False, memory_limit=0) for _ in range(count)]
    await asyncio.gather(*workers)
    await asyncio.gather(*(worker.finished() for worker in workers))


if __name__ == "__main__":
    asyncio.run(work(sys.argv[1], int(sys.argv[2])))
