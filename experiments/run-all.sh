#!/usr/bin/env bash
# All experiments on the paper, one after another, and the table of this folder's README.
set -euo pipefail
cd "$(dirname "$0")"
for experiment in controlled-stenosis resistance-modulation redundant-topologies median-circle throughput flow-shares; do
    echo "== $experiment" >&2
    "$experiment/run.sh"
done
"${WILLIS_PYTHON:-python3}" overview.py
