#!/bin/sh
# Makes the folder of one version: what it wrote, which every later version must read. make.sh WILLIS VERSION, run once for a release.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
willis=$1
here=$root/tests/compatibility/$2
mkdir -p "$here"
cd "$here"

# A grid of 4 x 3 nodes; the vessels along the second axis are candidates.
awk 'BEGIN {
    print "node_a,node_b,length_mm,radius_mm,origin"
    for (y = 0; y < 3; y++) for (x = 0; x < 4; x++) {
        if (x < 3) printf "%d,%d,%.1f,%.2f,observed\n", 4 * y + x, 4 * y + x + 1, 5 + x + 0.5 * y, 0.6 + 0.05 * x
        if (y < 2) printf "%d,%d,%.1f,%.2f,candidate\n", 4 * y + x, 4 * y + x + 4, 4 + 0.3 * x, 0.4 + 0.03 * y
    }
}' > grid.csv
run="grid.csv --inlet 0=100mmHg --outlet 11=0mmHg --seed 3 --threads 1 --dpi 36 -q"
for first in 0 640; do
    rm -rf shard-$first
    # shellcheck disable=SC2086
    "$willis" infer $run -n 1280 --range $first..$((first + 640)) -o shard-$first
done
rm -rf merged
"$willis" merge shard-0 shard-640 -o merged -q
mv merged/edges.csv edges.csv
rm -r merged

rm -rf run whole
cp "$root/data/broken-circle-of-willis.swc" circle.swc
cp "$root/data/broken-circle-of-willis.landmarks.csv" circle.landmarks.csv
"$willis" infer circle.swc --landmarks circle.landmarks.csv -n 128 -o whole -q --dpi 36
mkdir run
mv whole/run.json whole/candidates.graphml whole/landmarks.csv run
rm -r whole circle.swc circle.landmarks.csv
cp "$root/src/candidates/model/weights.toml" weights.toml
