#!/usr/bin/env bash
# The workflow from end to end: killed midway, resumed, and every file compared with those of one willis infer.
# usage: workflow/test.sh [WILLIS [SNAKEMAKE [OPTION...]]]; the options, of Snakemake, apply to all runs but the one that is killed.
set -euo pipefail
root=$(cd "$(dirname "$0")/.." && pwd)
willis=$(realpath "${1:-$root/target/release/willis}")
snakemake=$(realpath "$(command -v "${2:-snakemake}")")
shift $(($# < 2 ? $# : 2))

here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
cd "$here"
mkdir scans
cp "$root/data/circle-of-willis/without-L-PComm.graphml" scans
# Its subject has the name without both endings.
gzip -c "$root/data/broken-circle-of-willis.swc" > scans/broken-circle-of-willis.swc.gz
printf '1 0 a b c d -1\n' > scans/unreadable.swc

# A path to the command with a space would need quotes of its own.
ln -s "$willis" willis
config=("willis=$here/willis" samples=1000 "options=--seed 5 --landmarks auto")
run() { "$snakemake" --snakefile "$root/workflow/Snakefile" "$@" > log 2>&1 || { cat log; exit 1; }; }
same() { python3 "$root/workflow/same.py" whole "$1"; }

./willis infer 'scans/*' -n 1000 --seed 5 -o whole --quiet && status=0 || status=$?
[ "$status" = 1 ] # one of the subjects cannot be read

echo "killed when the first of three subjects stands"
set -m
run --cores 1 --config "${config[@]}" &
leader=$!
set +m
runs() { find results/runs -mindepth 2 -maxdepth 2 \( -name run.json -o -name failed.json \) ! -path '*/.willis-*' 2> /dev/null || true; }
for _ in $(seq 1200); do
  [ "$(runs | wc -l)" -lt 1 ] || break
  sleep 0.05
done
kill -KILL -- "-$leader"
wait "$leader" 2> /dev/null && exit 1 || true
stood=$(runs | wc -l)
[ "$stood" -ge 1 ] && [ "$stood" -lt 3 ] || { cat log; exit 1; }
[ ! -e results/cohort ]

echo "resumed: $stood of 3 runs stood"
run --config "${config[@]}" --unlock
run "$@" --config "${config[@]}"
[ "$(runs | wc -l)" = 3 ]
same results
