"""Runs work on other processes and machines, through a Dask scheduler used as a `concurrent.futures.Executor`.

Dask is installed with the extra `tatamu[cluster]`. It is only imported if the address of a scheduler is given.
"""

from tatamu.cluster.connection import connected, executor_at

__all__ = ["connected", "executor_at"]
