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
cargo build --release --locked --quiet --example masks
masks=target/release/examples/masks
"$masks" radii >"$here/radii.csv"
{
    "$masks" dense
    "$masks" dense-map
} | tee "$here/dense.txt"
if compgen -G "$data/tubetk-masks/*.nii.gz" >/dev/null; then
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
