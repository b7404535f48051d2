"""Runs work on other processes and machines through a Dask scheduler, used like a `concurrent.futures.Executor`.

The extra `tatamu[cluster]` installs Dask. Dask is imported only if the address of a scheduler is given.
"""

from tatamu.cluster.connection import connected, executor_at

__all__ = ["connected", "executor_at"]
