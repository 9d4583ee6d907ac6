#!/usr/bin/env bash
# Measures the sampling loop and tabulates it.
#
#   benches/run.sh               every figure: results.csv, the table here and in README.md
#   benches/run.sh --check       instruction counts only; fails when one grew by more than 3 % over instructions.csv
#   benches/run.sh --accept      writes the instruction counts of this build to instructions.csv
#   benches/run.sh --large       large graphs beside the best Python pipeline: large.csv and the table in benches/README.md
#
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

# Puts a text between the marks NAME:begin and NAME:end of a file.
splice() {
    awk -v begin="<!-- $1:begin -->" -v end="<!-- $1:end -->" '
        FNR == NR { text = text $0 "\n"; next }
        $0 == end { inside = 0 }
        !inside { print }
        $0 == begin { inside = 1; printf "%s", text }' "$2" "$3" >target/bench/spliced
    cat target/bench/spliced >"$3"
}

cargo build --release --locked --quiet --bench sampling --bin willis
bench=$(cargo build --release --locked --bench sampling --message-format json 2>/dev/null |
    sed -n 's/.*"name":"sampling".*"executable":"\([^"]*\)".*/\1/p')

mkdir -p target/bench
if [ "${1:-}" = --large ]; then
    BENCH="$bench" "$python" benches/large.py target/bench/large >benches/large.csv
    "$python" benches/large.py --table benches/large.csv >target/bench/large.md
    cat target/bench/large.md
    splice large target/bench/large.md benches/README.md
    exit
fi

# The graphs: the one that ships with the project, and the shared ones.
shipped=target/bench/broken-circle-57-102.graphml
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
        record faer "$("$bench" time "$graph" 1 cholesky)"
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

cpu=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)
awk -F, -v threads="$threads" -v samples="$samples" -v cpu="$cpu" -v load="$(cut -d' ' -f1 /proc/loadavg)" '
    NR == 1 { next }
    !($2 in known) { known[$2] = ++n; graph[n] = $2 }
    {
        each[$1, $2, $3] = $4
        if (!(($1, $2) in least) || $4 < least[$1, $2]) least[$1, $2] = $4
        if ($3 > rounds) rounds = $3
    }
    function figure(x) { return x >= 1000 || x == int(x) ? sprintf("%.0f", x) : x >= 10 ? sprintf("%.1f", x) : sprintf("%.2f", x) }
    function row(title, key, scale,   i, line) {
        line = "| " title " |"
        for (i = 1; i <= n; i++) line = line " " (((key, graph[i]) in least) && least[key, graph[i]] >= 0 ? figure(least[key, graph[i]] * scale) : "-") " |"
        print line
    }
    # How many times as long the other takes, round by round.
    function ratios(title, key, ours,   i, r, line) {
        line = "| " title " |"
        for (i = 1; i <= n; i++) {
            line = line " "
            if (!((key, graph[i]) in least)) line = line "-"
            else for (r = 1; r <= rounds; r++)
                line = line (r > 1 ? " / " : "") figure(each[key, graph[i], r] / each[ours, graph[i], r])
            line = line " |"
        }
        print line
    }
    END {
        line = "| microseconds a sample |"; rule = "|---|"
        for (i = 1; i <= n; i++) { line = line " " graph[i] " |"; rule = rule "---:|" }
        print line; print rule
        row("**one thread**", "one", 1)
        row(threads " threads", "all", 1)
        row("of one thread: mask", "mask", 1)
        row("solve: assemble, eliminate, substitute", "solve", 1)
        row("forest", "forest", 1)
        for (i = 1; i <= n; i++) least["rest", graph[i]] = least["one", graph[i]] - least["mask", graph[i]] - least["solve", graph[i]] - least["forest", graph[i]]
        row("the rest: resilience, keys, sums", "rest", 1)
        row("faer Cholesky + Kruskal, one thread", "faer", 1)
        ratios("times as long, by round", "faer", "one")
        row("NumPy, SciPy, one thread", "python", 1)
        ratios("times as long, by round", "python", "one")
        row("forest alone: Kruskal here", "kruskal", 1)
        row("forest alone: petgraph, graph ready", "petgraph_ready", 1)
        row("forest alone: petgraph, graph built", "petgraph", 1)
        ratios("times as long as ours, by round", "petgraph", "lanes")
        row("joins of the solve", "joins_solve", 1)
        row("joins of the forest", "joins_forest", 1)
        row("thousand instructions a sample, baseline", "instructions", 1e-3 / samples)
        row("peak memory of `willis infer`, MB", "memory", 1e-3)
        print ""
        printf "%s, %d threads, load %s at the end; occlusion probability 0.3, every vessel on trial; least of %d rounds.\n", cpu, threads, load, rounds
        g = "extraction-45-165"
        if (("million_1", g) in least) {
            line = ""
            for (r = 1; r <= rounds; r++) line = line (r > 1 ? " / " : "") figure(each["million_1", g, r] / each["million_2", g, r])
            printf "A million samples of %s: %s s with one thread, %s s with two; ratio by round %s.\n", g, figure(least["million_1", g]), figure(least["million_2", g]), line
        }
    }' "$results" >target/bench/table.md
[ ${#skipped[@]} = 0 ] || printf 'Skipped: %s.\n' "${skipped[@]}" >>target/bench/table.md

cat target/bench/table.md
splice bench target/bench/table.md README.md
