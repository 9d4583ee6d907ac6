#!/usr/bin/env bash
# Breaks up artery trees, searches them by every rule, has the benchmark's scorer judge, and writes results.csv and the table of
# README.md. WILLIS_GAPBENCH names the folder of the benchmark (../shared/gapbench), WILLIS_SHARED_DATA that of the real subjects
# (../shared/data), WILLIS_PYTHON a Python with numpy and scipy. Takes about five minutes.
set -euo pipefail
export LC_ALL=C
cd "$(dirname "$0")/../.."
here=experiments/candidates
python=${WILLIS_PYTHON:-python3}
bench=${WILLIS_GAPBENCH:-../shared/gapbench}
data=${WILLIS_SHARED_DATA:-../shared/data}
if [ ! -f "$bench/score.py" ] || [ ! -d "$data/brava" ] || [ ! -d "$data/insist-cow" ]; then
    echo "skipped: $bench or $data is not there" >&2
    exit
fi
cargo build --release --locked --quiet --features experiments --example candidates
work=target/candidates
rm -rf "$work"
mkdir -p "$work"
"$python" "$bench/make_cases.py" "$data/brava/vtp" "$work/cases/brava" --levels medium,hard --seed 5
"$python" "$bench/make_cases.py" "$data/insist-cow" "$work/cases/circle" --levels medium,hard --seed 5 --phenotype --ring

{
    echo "data,level,cases,rule,links,found,ceiling,candidates"
    for rule in reference behind behind+kinks behind+kinks+three default default+branch; do
        for case in "$work"/cases/*/*/*; do
            out=$work/$rule/${case#"$work/cases/"}
            mkdir -p "$out"
            target/release/examples/candidates "$rule" "$case/fragments.swc" "$case/inlets.csv" "$out/edges.csv" 2>>"$work/$rule.log"
        done
        PYTHONPATH=$bench "$python" "$here/judge.py" "$work/cases" "$work/$rule" "$rule"
    done
} >"$here/results.csv"
"$python" "$here/table.py"
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record candidates
