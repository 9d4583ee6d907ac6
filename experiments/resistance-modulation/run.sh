#!/usr/bin/env bash
# Every network, every reading of the modulation, outlets at ground and behind terminal resistances:
#
#   willis modulate NETWORK -o OUT -n 1000 --seed 0 --classes 0:0.2,0.2:0.3,0.3:0.5,0:0.3,0:0.5 --reading READING
#
# WILLIS_SHARED_DATA names the folder of real subjects (../shared/data), WILLIS_PYTHON a Python.
set -euo pipefail
cd "$(dirname "$0")/../.."
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --bin willis
"${WILLIS_PYTHON:-python3}" experiments/resistance-modulation/run.py
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record resistance-modulation
