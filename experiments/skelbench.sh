# What the scripts on simulated scans begin with; source it. Sets bench, data, python, tried and WILLIS, or ends the script where the benchmark is absent.
# WILLIS_SKELBENCH names the benchmark (../shared/skelbench), WILLIS_SHARED_DATA the tracings (../shared/data), WILLIS_PYTHON a Python with the
# packages of the benchmark, WILLIS a willis to try in place of this one.
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
bench=$(realpath -m "${WILLIS_SKELBENCH:-../shared/skelbench}")
data=$(realpath -m "${WILLIS_SHARED_DATA:-../shared/data}")
python=${WILLIS_PYTHON:-python3}
if [ ! -d "$bench" ] || [ ! -d "$data/brava" ]; then
    echo "skipped: $bench or $data/brava is not there" >&2
    exit 0
fi
# What is only tried is not recorded.
tried=${WILLIS:-}
[ -n "$tried" ] || cargo build --release --locked --quiet --features train --bin willis
export WILLIS=${WILLIS:-$PWD/target/release/willis}
