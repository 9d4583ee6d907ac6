#!/usr/bin/env bash
# Fits the weights for tubes that ship, on three draws of trees that are drawn vessel by vessel, and tries them on the tubes of two experts:
#
#   willis train brains circles -o crates/models/src/candidates/model/tubes.toml --folds 3
#   willis infer tubes-002.vtp -o OUT
#
# Same draws, same bytes. Arguments: --work FOLDER (kept, and gone on from), --only weights|experts. The environment is that of run.sh; the
# Python needs vtk too.
set -euo pipefail
cd "$(dirname "$0")/../.."
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --features train --bin willis
"${WILLIS_PYTHON:-python3}" experiments/gap-bridging/tubes.py "$@"
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record gap-bridging tubes
