#!/usr/bin/env bash
# Every network with redundant connections between nearest ends, and broken phenotypes (willis phantom --break), pruned as the paper does:
#
#   willis infer NETWORK -o OUT --observed --preset paper --epsilon 0.2,0.3,0.5 -n 1000 --seed 0
#
# WILLIS_SHARED_DATA names the folder of real subjects (../shared/data), WILLIS_PYTHON a Python.
# contacts.py has the table of automatic skeletons; run.sh does not run it, for it needs the cases of experiments/skeletons.
set -euo pipefail
cd "$(dirname "$0")/../.."
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --bin willis
"${WILLIS_PYTHON:-python3}" experiments/redundant-topologies/run.py
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record redundant-topologies ""
