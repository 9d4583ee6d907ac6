#!/usr/bin/env bash
# Each phenotype of the literature is broken up (willis phantom --break), over-connected and pruned as the paper does:
#
#   willis infer EXTRACTION -o OUT --preset paper --epsilon 0.2,0.3,0.5 -n 1000 --seed 0
#
# and so are the real trees. WILLIS_SHARED_DATA names the folder of real subjects (../shared/data), WILLIS_PYTHON a Python.
set -euo pipefail
cd "$(dirname "$0")/../.."
cargo build --release --locked --quiet --bin willis
"${WILLIS_PYTHON:-python3}" experiments/redundant-topologies/run.py
