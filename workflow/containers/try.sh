#!/usr/bin/env bash
# An image of the Dockerfile on two subjects, both levels: without a network, not as root, the data read-only. usage: try.sh [ENGINE]
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
engine=${1:-docker}
here=$(mktemp -d)
trap 'rm -rf "$here"' EXIT
chmod 755 "$here"
for subject in sub-01 sub-02; do
  mkdir -p "$here/study/derivatives/net/$subject/anat"
  cp "$root/data/scan.nii.gz" "$here/study/derivatives/net/$subject/anat/${subject}_desc-vessels_mask.nii.gz"
done
printf '{"Name": "Study", "BIDSVersion": "1.10.0"}' > "$here/study/dataset_description.json"
install -d -m 777 "$here/out"
inside() { "$engine" run --rm --network none -u 1234:1234 -v "$here/study:/data:ro" -v "$here/out:/out" "$@"; }

inside --entrypoint sh willis -c 'echo "user $(id -u), $(($(wc -l < /proc/net/dev) - 3)) devices to a network, the usual user is $(id -un 1000)"'
inside willis /data /out participant -n 64 --dpi 36
inside willis /data /out group
[ "$(wc -l < "$here/out/group_willis.tsv")" = 3 ]
[ "$(stat -c %u "$here/out/group_willis.tsv")" = 1234 ]
for subject in sub-01 sub-02; do [ -s "$here/out/$subject.html" ]; done
inside willis /data /out nonsense 2> "$here/said" && exit 1 || [ $? = 2 ]
echo "two subjects, both levels: $(cut -f 1-3 "$here/out/group_willis.tsv" | tail -n +2 | tr '\t\n' ' ;')"
