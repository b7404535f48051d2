#!/usr/bin/env bash
# A scheduler here and workers on machines that ssh reaches without a password, with TLS between all of them:
#
#   ./ssh.sh laptop.lab machine-1 machine-2 ..      # the first is this machine, as the others see it
#   . ~/.config/tatamu-cluster/env.sh               # in another terminal
#   tatamu sweep sweep.toml --scheduler tls://laptop.lab:8786 --out runs/sweep
#
# Every machine has the same tatamu[cluster] in ~/tatamu/.venv. Ctrl-C ends all.
set -euo pipefail
here=$1
shift
"$(dirname "$0")/certificate.sh"
. ~/.config/tatamu-cluster/env.sh
export DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES=2 # the third worker that a trial kills is its last
quiet="DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED=False DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL=1s" # cores are for rollouts
trap 'kill $(jobs -p) 2>/dev/null' EXIT
~/tatamu/.venv/bin/dask scheduler --protocol tls --host "$here" --port 8786 --dashboard-address 127.0.0.1:8787 &
for machine in "$@"; do
  tar -C ~ -c .config/tatamu-cluster | ssh "$machine" tar -x
  # -tt: the remote program ends with the connection. One process of one thread for each core.
  ssh -tt "$machine" ". ~/.config/tatamu-cluster/env.sh; $quiet ~/tatamu/.venv/bin/dask worker tls://$here:8786 \
    --nworkers \$(nproc) --nthreads 1 --dashboard-address 127.0.0.1:0" </dev/null &
done
wait
