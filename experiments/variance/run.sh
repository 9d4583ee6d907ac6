#!/usr/bin/env bash
# Measures every scheme on every graph, writes results.csv and the tables of README.md from it. Takes about four minutes.
set -euo pipefail
cd "$(dirname "$0")/../.."
here=experiments/variance
cargo build --release --locked --quiet --features experiments --example variance
measure() { target/release/examples/variance "$@"; }

new=$(mktemp)
trap 'rm -f "$new" "$new.md"' EXIT
measure header >"$new"
for graph in circle-20 cow-30-80 extraction-45-165 brain-206-726 brain-206-726-13-terminals; do
    measure "$graph" >>"$new"
done
cat "$new" >"$here/results.csv"

# A table of one column of results.csv for one kind of row: schemes down, graphs across.
table() {
    awk -F, -v kind="$1" -v column="$2" '
        NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
        $at["kind"] != kind { next }
        {
            if (!($1 in seen)) { seen[$1] = 1; graph[++graphs] = $1 }
            if (!($3 in row)) { row[$3] = 1; name[++rows] = $3 }
            cell[$3, $1] = column == "quantiles" ? $at["median"] " (" $at["q10"] "-" $at["q90"] "), " $at["near"] : $at[column]
        }
        END {
            line = "| |"; rule = "|---|"
            for (g = 1; g <= graphs; g++) { line = line " " graph[g] " |"; rule = rule "---|" }
            print line; print rule
            for (r = 1; r <= rows; r++) {
                line = "| " name[r] " |"
                for (g = 1; g <= graphs; g++) line = line " " cell[name[r], graph[g]] " |"
                gsub(/\|  \|/, "| - |", line); gsub(/\|  \|/, "| - |", line)
                print line
            }
        }' "$here/results.csv"
}

# Replaces what stands between <!-- table KIND COLUMN --> and <!-- end --> in README.md.
while IFS= read -r line; do
    if [ "${inside:-}" ] && [ "$line" != "<!-- end -->" ]; then continue; fi
    inside=
    printf '%s\n' "$line"
    if [[ $line =~ ^"<!-- table "([a-z]+)" "([a-z_]+)" -->"$ ]]; then
        table "${BASH_REMATCH[1]}" "${BASH_REMATCH[2]}"
        inside=1
    fi
done <"$here/README.md" >"$new.md"
cat "$new.md" >"$here/README.md"
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record variance ""
