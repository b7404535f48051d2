"""A Dask scheduler and workers as Slurm jobs, by dask-jobqueue, with TLS between all of them.

    python -m pip install dask-jobqueue 'tatamu[cluster]'
    ./certificate.sh           # once, in a home that all nodes share
    . ~/.config/tatamu-cluster/env.sh
    python slurm.py 200        # on a login node, in a terminal that stays (tmux)
    tatamu sweep sweep.toml --scheduler tls://THIS-NODE:8786 --out runs/sweep

A job is one worker of one core: Slurm finds room wherever a core is free, a worker that dies takes one trial with
it, and Dask replaces jobs that end (it does not where a job holds several workers).
"""

from __future__ import annotations

import socket
import sys
from threading import Event

import dask
from dask_jobqueue import SLURMCluster
from distributed import Security

dask.config.set({"distributed.scheduler.allowed-failures": 2})  # the third worker that a trial kills is its last


def main() -> None:
    """Keep so many workers until the program is ended."""
    wanted = int(sys.argv[1])
    with SLURMCluster(
        cores=1,
        processes=1,
        memory="2GB",
        walltime="12:00:00",
        job_script_prologue=[
            "source $HOME/tatamu/.venv/bin/activate",
            "export DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED=False",  # cores are for rollouts
            "export DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL=1s",
        ],
        worker_extra_args=["--lifetime", "11h", "--lifetime-stagger", "30m", "--dashboard-address", "127.0.0.1:0"],
        protocol="tls://",
        security=Security(),  # the files that env.sh names
        scheduler_options={"port": 8786, "host": socket.gethostname(), "dashboard_address": "127.0.0.1:8787"},
    ) as cluster:
        cluster.adapt(minimum=wanted, maximum=wanted)
        print(f"tatamu .. --scheduler tls://{socket.gethostname()}:8786", flush=True)
        Event().wait()


if __name__ == "__main__":
    main()
