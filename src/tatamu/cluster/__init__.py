"""Work on other processes and machines: a Dask scheduler as a `concurrent.futures.Executor`.

Dask is imported only when an address is given; it is the extra `tatamu[cluster]`.
"""

from tatamu.cluster.connection import connected, executor_at

__all__ = ["connected", "executor_at"]
