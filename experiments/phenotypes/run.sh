#!/usr/bin/env bash
# Breaks circles whose anatomy is known, and asks for their variant:
#
#   willis phantom cerebral --without L-PComm --break --seed S -o X.swc
#   willis infer X.swc -o OUT --landmarks X.landmarks.csv
#   willis classify OUT -o PHENOTYPE --landmarks X.landmarks.csv
#
# with landmarks and without, and of patients whose tracings are labelled, whole and damaged. Arguments: --only literature|patients|damaged|cohort,
# --seeds A B (of the phantoms), --seed N (of the patients' damage), --work FOLDER. WILLIS_FOLD_WEIGHTS and WILLIS_FOLD_ARTERIES name folders of models of
# joins and of names that have not seen a patient, WILLIS_SHARED_DATA the folder of the patients (../shared/data), WILLIS_GAPBENCH that of their damage
# (../shared/gapbench), WILLIS_PYTHON a Python with numpy, scipy, networkx and scikit-learn, WILLIS a willis to try in place of this one.
set -euo pipefail
cd "$(dirname "$0")/../.."
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --bin willis
"${WILLIS_PYTHON:-python3}" experiments/phenotypes/run.py "$@"
