#!/bin/sh
# Makes table.md: how far answers move where nothing of the vessels changes, over the shipped circle and every traced circle of ../shared.
set -eu
cd "$(dirname "$0")/../.."
WILLIS_METAMORPHIC=table cargo test --release --test inference metamorphic -- --nocapture | grep '^|' > experiments/metamorphic/table.md
cat experiments/metamorphic/table.md
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record metamorphic
