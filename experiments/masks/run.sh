#!/usr/bin/env bash
# Measures radii of tubes, a dense mask and real masks, and writes the results here and the tables of radii into README.md and into the
# guide. WILLIS_SHARED_DATA names the folder of real masks (../shared/data), WILLIS_PYTHON a Python, with scikit-image, edt and skan for
# the comparison. Takes about two minutes.
set -euo pipefail
export LC_ALL=C
cd "$(dirname "$0")/../.."
here=experiments/masks
python=${WILLIS_PYTHON:-python3}
data=${WILLIS_SHARED_DATA:-../shared/data}
cargo build --release --locked --quiet --bin willis --features experiments --example masks
masks=target/release/examples/masks
"$masks" radii >"$here/radii.csv"
{
    "$masks" dense
    "$masks" dense-map
} | tee "$here/dense.txt"
# The median of five times of a command on one core, s.
median() {
    for _ in 1 2 3 4 5; do
        local begun=$EPOCHREALTIME
        RAYON_NUM_THREADS=1 "$@" >/dev/null 2>&1
        awk "BEGIN { printf \"%.2f\\n\", $EPOCHREALTIME - $begun }"
    done | sort -n | sed -n 3p
}

if compgen -G "$data/tubetk-masks/*.nii.gz" >/dev/null; then
    scratch=$(mktemp -d)
    trap 'rm -rf "$scratch"' EXIT
    {
        echo "mask,skeleton_s,infer_s"
        for mask in "$data"/tubetk-masks/*.nii.gz; do
            skeleton=$(median target/release/willis skeleton "$mask" -o "$scratch/lines.vtp" --force)
            infer=$(median target/release/willis infer "$mask" -o "$scratch/out" --force)
            echo "$(basename "$mask"),$skeleton,$infer"
        done
    } | tee "$here/commands.csv"
    "$masks" volume "$data"/tubetk-masks/*.nii.gz "$data"/topcow-masks/*.nii.gz | tee "$here/volumes.csv"
    if "$python" -c "import skimage, edt, skan, nibabel" 2>/dev/null; then
        "$python" "$here/peers.py" "$data"/tubetk-masks/*.nii.gz | tee "$here/peers.csv"
    else
        echo "skipped: no Python with scikit-image, edt, skan and nibabel" >&2
    fi
else
    echo "skipped: $data has no masks" >&2
fi
"$python" "$here/table.py"
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record masks
