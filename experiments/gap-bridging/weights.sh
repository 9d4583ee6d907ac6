#!/usr/bin/env bash
# Fits the weights that ship on three draws of the damage (seeds 1, 2, 3; what run.sh judges is another):
#
#   willis train brains insist --calibrate-with phantoms -o crates/models/src/candidates/model/weights.toml --folds 3 --save-folds
#
# Same draws, same bytes. Arguments: --work FOLDER (kept, and gone on from; run.sh goes on from it too). The environment is that of run.sh.
set -euo pipefail
cd "$(dirname "$0")/../.."
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --features train --bin willis
"${WILLIS_PYTHON:-python3}" experiments/gap-bridging/weights.py "$@"
