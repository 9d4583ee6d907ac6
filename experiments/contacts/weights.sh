#!/usr/bin/env bash
# Fits the model of contacts that ships, to the skeletons of simulated scans of 24 brains at five levels with their masks:
#
#   willis train scikit-image -o contacts.toml --model contacts --folds 3 --save-folds
#
# Argument: the folder of cases that experiments/skeleton-joins/weights.sh made. WILLIS names a willis to try in place of this one.
set -euo pipefail
work=$(cd "$1" && pwd)
cd "$(dirname "$0")/../.."
if [ ! -d "$work/scikit-image" ]; then
    echo "skipped: $work/scikit-image is not there; experiments/skeleton-joins/weights.sh makes it" >&2
    exit 0
fi
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --bin willis
export WILLIS=${WILLIS:-$PWD/target/release/willis}
cd "$work"
"$WILLIS" train scikit-image -o contacts.toml --model contacts --folds 3 --save-folds --force
