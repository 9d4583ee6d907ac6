#!/usr/bin/env bash
# Compares groups of phantoms 260 times, writes results.csv and the table of README.md. Takes about ten minutes.
set -euo pipefail
cd "$(dirname "$0")/../.."
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet
"${WILLIS_PYTHON:-python3}" experiments/compare/run.py
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record compare ""
