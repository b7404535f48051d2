#!/usr/bin/env bash
# A scheduler here and workers on machines that ssh reaches without a password:
#
#   ./ssh.sh laptop.lab machine-1 machine-2 ..      # the first is this machine, as the others see it
#   tatamu sweep sweep.toml --scheduler tcp://laptop.lab:8786 --out runs/sweep
#
# Every machine has the same tatamu[cluster] in ~/tatamu/.venv. Ctrl-C ends all.
set -euo pipefail
here=$1
shift
export DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES=2 # the third worker that a trial kills is its last
quiet="DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED=False DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL=1s" # cores are for rollouts
trap 'kill $(jobs -p) 2>/dev/null' EXIT
"$HOME/tatamu/.venv/bin/dask" scheduler --port 8786 &
for machine in "$@"; do
  # -tt: the remote program ends with the connection. One process of one thread for each core.
  ssh -tt "$machine" "$quiet ~/tatamu/.venv/bin/dask worker tcp://$here:8786 --nworkers \$(nproc) --nthreads 1" </dev/null &
done
wait
