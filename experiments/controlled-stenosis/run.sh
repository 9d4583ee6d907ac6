#!/usr/bin/env bash
# Every network: the left carotid (the widest inflow artery where nothing is labelled) narrowed by half its diameter, the
# posterior communicating artery of its side occluded.
#
#   willis simulate NETWORK -o OUT --stenosis "L-ICA I=50%" --occlude "L-PComm" [--outlets ground|murray] [--bc FILE]
#
# No random numbers. WILLIS_SHARED_DATA names the folder of real subjects (../shared/data), WILLIS_PYTHON a Python.
set -euo pipefail
cd "$(dirname "$0")/../.."
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --bin willis
"${WILLIS_PYTHON:-python3}" experiments/controlled-stenosis/run.py
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record controlled-stenosis
