#!/usr/bin/env bash
# The workflow from end to end: killed midway, resumed, and every file compared with those of one willis infer without shards.
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
cp "$root/data/broken-circle-of-willis.swc" "$root/data/circle-of-willis/without-L-PComm.graphml" scans
printf '1 0 a b c d -1\n' > scans/unreadable.swc

# A path to the command with a space would need quotes of its own.
ln -s "$willis" willis
config=("willis=$here/willis" samples=1000 "options=--seed 5 --landmarks auto")
run() { "$snakemake" --snakefile "$root/workflow/Snakefile" --notemp "$@" > log 2>&1 || { cat log; exit 1; }; }
same() { python3 "$root/workflow/same.py" whole "$1"; }

./willis infer 'scans/*' -n 1000 --seed 5 -o whole --quiet && status=0 || status=$?
[ "$status" = 1 ] # one of the subjects cannot be read

echo "three shards a subject, killed when the second of nine stands"
set -m
run --cores 1 --config "${config[@]}" shards=3 &
leader=$!
set +m
shards() { find results/shards -mindepth 3 -name '*.json' ! -path '*/.willis-*' 2> /dev/null || true; }
for _ in $(seq 1200); do
  [ "$(shards | wc -l)" -lt 2 ] || break
  sleep 0.05
done
kill -KILL -- "-$leader"
wait "$leader" 2> /dev/null && exit 1 || true
stood=$(shards | wc -l)
[ "$stood" -ge 2 ] && [ "$stood" -lt 9 ] || { cat log; exit 1; }
[ ! -e results/cohort ]
# One job at a time: the older of the two was finished, and known to be.
first=$(shards | tr '\n' '\0' | xargs -0 ls -tr | head -n 1)
before=$(ls -i "$first")

echo "resumed: $stood of 9 shards stood"
run --config "${config[@]}" shards=3 --unlock
run "$@" --config "${config[@]}" shards=3
[ "$(ls -i "$first")" = "$before" ] || { echo "$first was made again"; exit 1; }
[ "$(shards | wc -l)" = 9 ]
same results

echo "one job a subject"
run "$@" --config "${config[@]}" shards=1 output=single
same single
