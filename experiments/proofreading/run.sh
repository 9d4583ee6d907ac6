#!/usr/bin/env bash
# A person who knows the truth decides on the answers to simulated scans, to two masks that people drew, and to six with gaps and fusions put into them:
#
#   willis infer mask.nii.gz -o OUT --decisions decisions.csv
#
# Writes results.csv, alone.csv, beside.csv, scales.csv, carried.csv, weighed.csv and the tables of README.md. Argument: a folder for cases and answers, which is kept and gone on from (two hours on two busy cores).
# ../skelbench.sh says what the environment names.
set -euo pipefail
work=$(mkdir -p "$1" && cd "$1" && pwd)
. "$(dirname "$0")/../skelbench.sh"
here=experiments/proofreading
for subject in 002 003; do
    "$python" experiments/skeletons/manual.py "$bench" "$data" "$work/cases/real" $subject
done
for level in good fair real; do
    [ -d "$work/cases/$level" ] || "$python" "$bench/make_cases.py" make "$data/brava/vtp" "$work/cases" --level $level --seed 2 --save-mask --subjects BG0003,BG08,BG11,BG18,BH0012,BH0014,BH0018,BH0024
    "$python" $here/measure.py "$bench" "$work/cases" "$work/answers" $level >"$work/$level.csv"
    "$python" $here/measure.py "$bench" "$work/cases" "$work/answers" $level --alone 20 >"$work/alone-$level.csv"
done
"$python" $here/implants.py "$bench" "$data" "$work/cases/implants" --masks 005,006,007,008,009,010
"$python" $here/measure.py "$bench" "$work/cases" "$work/answers" implants --orders review >"$work/implants.csv"
[ -z "$tried" ] || exit 0
{ cat "$work/good.csv"; tail -qn +2 "$work/fair.csv" "$work/real.csv" "$work/implants.csv"; } >$here/results.csv
{ cat "$work/alone-good.csv"; tail -qn +2 "$work/alone-fair.csv" "$work/alone-real.csv"; } >$here/alone.csv
"$python" $here/measure.py table
"$python" $here/beside.py "$bench" "$work/cases" "$work/answers"
for level in good fair; do
    [ -d "$work/others/cases/$level" ] || "$python" "$bench/make_cases.py" make "$data/brava/vtp" "$work/others/cases" --level $level --seed 3 --save-mask --subjects BG0002,BG07,BH0002,BH0017,BH0029,Set9
done
"$python" $here/scales.py "$bench" "$work/cases" "$work/answers" "$work/others"
cargo run --release --locked --quiet --example fingerprints -- record proofreading
