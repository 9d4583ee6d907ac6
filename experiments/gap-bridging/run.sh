#!/usr/bin/env bash
# Breaks real artery trees, fits willis and the other methods on two thirds of the subjects, and judges them on the rest:
#
#   willis train brains insist --calibrate-with phantoms -o weights.toml --folds 3 --save-folds
#   willis infer CASE/fragments.swc -o OUT --bc CASE/inlets.csv [--loops CASE/loops.csv] --prior weights.fold-k.toml
#
# Arguments: --seed N, --work FOLDER (kept, and gone on from), --only main|flow|hydraulics|robust|loops|draws. WILLIS_GAPBENCH names the folder of the
# benchmark (../shared/gapbench), WILLIS_SHARED_DATA that of the real subjects (../shared/data), WILLIS_PYTHON a Python with numpy,
# scipy, networkx, scikit-learn and matplotlib, WILLIS a willis to try in place of this one.
set -euo pipefail
cd "$(dirname "$0")/../.."
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --bin willis
"${WILLIS_PYTHON:-python3}" experiments/gap-bridging/run.py "$@"
