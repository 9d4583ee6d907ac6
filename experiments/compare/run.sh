#!/usr/bin/env bash
# Compares groups of phantoms 640 times, writes results.csv, and tries the intervals of 96 runs; writes both tables of README.md. Takes about twenty minutes.
set -euo pipefail
cd "$(dirname "$0")/../.."
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet
"${WILLIS_PYTHON:-python3}" experiments/compare/run.py
"${WILLIS_PYTHON:-python3}" experiments/compare/intervals.py
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record compare "" intervals
