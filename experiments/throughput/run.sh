#!/usr/bin/env bash
# Time of one simulation (flow, resilience, forest, sums) on every network, one thread and all of them:
#
#   willis infer NETWORK -o OUT --uncertain all --prior uniform --epsilon 0.3 -n 200000 --seed 0 --threads T
#
# WILLIS_SHARED_DATA names the folder of real subjects (../shared/data), WILLIS_PYTHON a Python.
set -euo pipefail
cd "$(dirname "$0")/../.."
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --bin willis
"${WILLIS_PYTHON:-python3}" experiments/throughput/run.py
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record throughput
