#!/usr/bin/env bash
# Breaks circles of patients whose arteries are known, and asks for the names of what is left:
#
#   willis train CASES --model labels -o arteries.toml --folds 26 --save-folds
#   willis label CASE/fragments.swc -o OUT.graphml --model arteries.fold-K.toml
#
# each patient by the model that never saw it; then whole brains and masks of other data sets, and the drawn circle of `willis phantom`. Arguments: --only patients|draws|frames|unseen|brava|topcow|drawn,
# --seed N (of the other draw), --work FOLDER, --models FOLDER, --model FILE. WILLIS_SHARED_DATA names the folder of the tracings (../shared/data),
# WILLIS_GAPBENCH that of their damage (../shared/gapbench), WILLIS_PYTHON a Python with numpy, scipy, vtk and nibabel, WILLIS a willis in place of this one.
set -euo pipefail
cd "$(dirname "$0")/../.."
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --features train --bin willis
nice -n 5 "${WILLIS_PYTHON:-python3}" experiments/labels/run.py "$@"
