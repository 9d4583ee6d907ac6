#!/usr/bin/env bash
# Measures the sampling loop and tabulates it.
#
#   benches/run.sh               every figure: results.csv, and the pages made from it
#   benches/run.sh --check       instruction counts only; fails when one grew by more than 3 % over instructions.csv
#   benches/run.sh --accept      writes the instruction counts of this build to instructions.csv
#   benches/run.sh --large       large graphs beside the best Python pipeline: large.csv, and the pages made from it
#
# The pages are docs/src/performance.md and the table in benches/README.md. benches/page.py makes them from existing figures.
# WILLIS_BENCH_GRAPHS names the folder of graphs and of scipy_baseline.py (../shared/bench), WILLIS_PYTHON a Python with
# NumPy and SciPy. What is missing is skipped, and the script says so.
set -euo pipefail
export LC_ALL=C
cd "$(dirname "$0")/.."

samples=6400
rounds=3
growth=1.03
folder="${WILLIS_BENCH_GRAPHS:-../shared/bench}"
python="${WILLIS_PYTHON:-python3}"
threads=$(nproc)
skipped=()
skip() { skipped+=("$1"); echo "skipped: $1" >&2; }

# The stages are compiled with the bench, which is of the package that a release compiles fast.
build=(cargo build --release --locked --config profile.release.package.willis.opt-level=3)
"${build[@]}" --quiet --bench sampling --bin willis
bench=$("${build[@]}" --bench sampling --message-format json 2>/dev/null |
    sed -n 's/.*"name":"sampling".*"executable":"\([^"]*\)".*/\1/p')

mkdir -p target/bench
if [ "${1:-}" = --large ]; then
    BENCH="$bench" "$python" benches/large.py target/bench/large >target/bench/large.csv
    mv target/bench/large.csv benches/large.csv
    exec "$python" benches/page.py
fi

# The graphs: the one that ships with the project, and the shared ones.
shipped=target/bench/broken-circle.graphml
target/release/willis candidates data/broken-circle-of-willis.swc -o "$shipped" --force 2>/dev/null
graphs=("$shipped")
for name in cow-30-80 extraction-45-165 brain-206-726 brain-206-726-13-terminals; do
    if [ -f "$folder/$name.graphml" ]; then graphs+=("$folder/$name.graphml"); else skip "$name: not in $folder"; fi
done

# Instructions of a fixed job, in the instruction set that valgrind knows.
instructions() {
    WILLIS_SIMD=baseline valgrind --tool=callgrind --callgrind-out-file=/dev/null "$bench" count "$1" "$samples" 2>&1 |
        sed -n 's/.*Collected *: *\([0-9]*\).*/\1/p'
}

counts() {
    echo "graph,samples,instructions"
    for graph in "${graphs[@]}"; do echo "$(basename "$graph" .graphml),$samples,$(instructions "$graph")"; done
}

case "${1:-}" in
--accept)
    counts | tee target/bench/instructions.csv
    mv target/bench/instructions.csv benches/instructions.csv
    exit
    ;;
--check)
    if ! command -v valgrind >/dev/null; then skip "instruction counts: no valgrind"; exit 0; fi
    counts >target/bench/instructions.csv
    awk -F, -v growth="$growth" '
        FNR == 1 { next }
        NR == FNR { accepted[$1] = $3; next }
        !($1 in accepted) { print "new: " $1 ": " $3; next }
        {
            ratio = $3 / accepted[$1]
            verdict = ratio > growth ? "GREW" : "ok"
            printf "%-4s %-28s %13d instructions, %+.2f %%\n", verdict, $1, $3, 100 * (ratio - 1)
            failed = failed || ratio > growth
        }
        END { exit failed }' benches/instructions.csv target/bench/instructions.csv
    exit
    ;;
"") ;;
*)
    sed -n '2,/^set/s/^# \{0,1\}//p' "$0"
    exit 2
    ;;
esac

peer="$folder/scipy_baseline.py"
[ -f "$peer" ] || { skip "Python peer: no $peer"; peer=; }
if [ -n "$peer" ] && ! "$python" -c 'import numpy, scipy' 2>/dev/null; then
    skip "Python peer: $python has no NumPy and SciPy"
    peer=
fi

results=benches/results.csv
echo "figure,graph,round,value" >"$results"
record() { echo "$1,$name,$round,$2" >>"$results"; }

# Everything that is compared alternates within a round.
for round in $(seq "$rounds"); do
    for graph in "${graphs[@]}"; do
        name=$(basename "$graph" .graphml)
        echo "round $round: $name" >&2
        record one "$("$bench" time "$graph" 1 lanes)"
        record all "$("$bench" time "$graph" "$threads" lanes)"
        record reference "$("$bench" time "$graph" 1 reference)"
        if [ -n "$peer" ] && [ "$graph" != "$shipped" ]; then
            record python "$(OPENBLAS_NUM_THREADS=1 "$python" "$peer" "$graph" --epsilon 0.3 --seconds 2 | cut -d' ' -f1)"
        fi
        IFS=, read -r mask solve forest joins_solve joins_forest < <("$bench" stages "$graph")
        for figure in mask solve forest; do record "$figure" "${!figure}"; done
        IFS=, read -r lanes kruskal petgraph petgraph_ready < <("$bench" forests "$graph")
        for figure in lanes kruskal petgraph petgraph_ready; do record "$figure" "${!figure}"; done
        if [ "$round" = 1 ]; then
            record joins_solve "$joins_solve"
            record joins_forest "$joins_forest"
        fi
    done
done

round=1
for graph in "${graphs[@]}"; do
    name=$(basename "$graph" .graphml)
    if command -v valgrind >/dev/null; then record instructions "$(instructions "$graph")"; fi
    if [ -x /usr/bin/time ]; then
        record memory "$(/usr/bin/time -f %M target/release/willis infer "$graph" -o target/bench/out --force --uncertain all \
            --epsilon 0.3 -n "$samples" 2>&1 >/dev/null | tail -1)"
    fi
done
command -v valgrind >/dev/null || skip "instruction counts: no valgrind"
[ -x /usr/bin/time ] || skip "peak memory: no /usr/bin/time"

name=extraction-45-165
if [ -f "$folder/$name.graphml" ]; then
    for round in $(seq "$rounds"); do
        for t in 1 2; do record "million_$t" "$("$bench" seconds "$folder/$name.graphml" "$t" 1000000)"; done
    done
fi

round=1 name=machine
record cpu "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1 | tr ',' ' ')"
record threads "$threads"
record samples "$samples"
record load "$(cut -d' ' -f1 /proc/loadavg)"
for what in "${skipped[@]}"; do record skipped "${what//,/;}"; done

exec "$python" benches/page.py
