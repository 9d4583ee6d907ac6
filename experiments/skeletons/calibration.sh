#!/usr/bin/env bash
# Calibrates a model of contacts, the one that ships unless another is named, on scans that its trees never saw:
#
#   willis train calibration -o MODEL --model contacts --calibrate-onto model.toml
#
# where model.toml is MODEL as it was and `calibration` has scans of six of the brains that the trees were fitted to, drawn anew (seed 3) and thinned by
# willis, and a manual mask (002). Nothing else in the model changes, and a second run gives the same bytes. No brain that run.sh answers is among them.
#
# Arguments: a folder for the cases, which is kept and gone on from (some five minutes), and MODEL. ../skelbench.sh says what the environment names.
set -euo pipefail
work=$(mkdir -p "$1" && cd "$1" && pwd)
model=$(realpath -m "${2:-$(dirname "$0")/../../crates/models/src/contacts/contacts.toml}")
. "$(dirname "$0")/../skelbench.sh"
here=$PWD/experiments/skeletons
cd "$work"
levels() { # levels and subjects of scans that nothing was fitted to
    for level in $1; do
        [ -d "unseen/$level" ] || "$python" "$bench/make_cases.py" make "$data/brava/vtp" unseen --level $level --seed 3 --subjects $2 --save-mask
    done
}
levels "good fair poor" BG0002,BG07,BH0002,BH0017,BH0029,Set9
levels near BG0002,BG07
[ -d unseen/manual ] || "$python" "$here/manual.py" "$bench" "$data" unseen/manual 002
[ -d calibration ] || "$python" "$here/own.py" "$bench" unseen calibration
cp "$model" model.toml
"$WILLIS" train calibration -o "$model" --model contacts --calibrate-onto model.toml --force
