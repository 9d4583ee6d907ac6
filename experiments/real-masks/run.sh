#!/usr/bin/env bash
# Ten masks of a segmentation challenge, as they are, with gaps and fusions put into them, and with specks, answered by what ships:
#
#   willis infer MASK -o OUT [--cut never]
#
# Writes results.csv and the table of README.md. Argument: a folder for cases and answers, which is kept and gone on from (about half an hour on two
# cores, most of it for making the cases). SEEDS names other seeds than "1,2,3". ../skelbench.sh says what the environment names.
set -euo pipefail
work=$(mkdir -p "$1" && cd "$1" && pwd)
. "$(dirname "$0")/../skelbench.sh"
here=experiments/real-masks
"$python" $here/measure.py "$bench" "$data" "$work" --seeds "${SEEDS:-1,2,3}" >"$work/results.csv"
[ -z "$tried" ] || exit 0
cat "$work/results.csv" >$here/results.csv
"$python" $here/measure.py table
cargo run --release --locked --quiet --example fingerprints -- record real-masks
