#!/usr/bin/env bash
# 100 random geometries of the published circle with redundant connections between junctions, pruned as the paper does:
#
#   willis infer GRAPH -o OUT --preset paper --epsilon 0.2,0.3,0.5 -n 1000 --seed GEOMETRY --bc data/outlets-at-ground.csv
#
# WILLIS_PYTHON names a Python.
set -euo pipefail
cd "$(dirname "$0")/../.."
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --bin willis
"${WILLIS_PYTHON:-python3}" experiments/median-circle/run.py
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record median-circle
