#!/usr/bin/env bash
# One certificate for scheduler, workers and clients in ~/.config/tatamu-cluster, and settings that make Dask use it:
#
#   ./certificate.sh                    # once; does nothing where the certificate exists already
#   . ~/.config/tatamu-cluster/env.sh
#   tatamu sweep sweep.toml --scheduler tls://HOST:8786 --out runs/sweep
#
# Whoever has the folder can run programs on all machines of the cluster, so only its owner can read it.
set -euo pipefail
umask 077
folder=$HOME/.config/tatamu-cluster
[ -e "$folder/env.sh" ] && exit
mkdir -p "$folder"
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 365 -subj /CN=tatamu-cluster \
  -keyout "$folder/key.pem" -out "$folder/cert.pem" 2>/dev/null
cat >"$folder/env.sh" <<'END'
export DASK_DISTRIBUTED__COMM__REQUIRE_ENCRYPTION=True
export DASK_DISTRIBUTED__COMM__TLS__CA_FILE="$HOME/.config/tatamu-cluster/cert.pem"
for role in SCHEDULER WORKER CLIENT; do
  export "DASK_DISTRIBUTED__COMM__TLS__${role}__CERT=$HOME/.config/tatamu-cluster/cert.pem"
  export "DASK_DISTRIBUTED__COMM__TLS__${role}__KEY=$HOME/.config/tatamu-cluster/key.pem"
done
END
