#!/usr/bin/env bash
# Simulates the published Circle of Willis and its variants, writes results.csv, and puts the shares of flow beside measured ones in README.md.
set -euo pipefail
export LC_ALL=C
cd "$(dirname "$0")/../.."
here=experiments/flow-shares
measured=../shared/data/cow-flow-reference/flows.csv
if [ ! -f "$measured" ]; then
    echo "skipped: $measured is not there" >&2
    exit
fi
[ -n "${WILLIS:-}" ] || cargo build --release --locked --quiet --bin willis
work=target/flow-shares
mkdir -p "$work"

# simulate OUTLETS NETWORK [OPTION...]: the flow of every vessel, a row each.
simulate() {
    local outlets=$1 network=$2
    shift 2
    "${WILLIS:-target/release/willis}" simulate "data/circle-of-willis/$network.graphml" -o "$work/$outlets-$network" --force --quiet "$@"
    awk -F, -v run="$outlets,$network" '
        NR == 1 { for (i = 1; i <= NF; i++) at[$i] = i; next }
        { printf "%s,%s,%.6g\n", run, $at["label"], $at["flow_mL_per_min"] }' "$work/$outlets-$network/edges.csv"
}

{
    echo "outlets,network,vessel,flow_mL_per_min"
    for file in data/circle-of-willis/*.graphml; do simulate resistance "$(basename "$file" .graphml)"; done
    grounded=()
    for node in 23 24 27 28 29 30; do grounded+=(--outlet "$node=ground"); done
    simulate ground complete "${grounded[@]}"
} >"$work/results.csv"
cat "$work/results.csv" >"$here/results.csv"

# The complete circle beside what was measured. Shares are of both internal carotids and both vertebrals, for Enzmann of
# both internal carotids and the basilar.
shares() {
    awk -F, '
        FNR == 1 { next }
        NR == FNR {
            if ($1 ~ /^Zarrinkoob/) zarrinkoob[$4] = $6
            if ($1 ~ /^Zarrinkoob/ && $7 != "") spread[$4] = $7
            if ($1 ~ /^Enzmann/) enzmann[$4] = $6
            next
        }
        $2 == "complete" { flow[$1, $3] = $4 }
        function both(run, stem) { return flow[run, "L-" stem] + flow[run, "R-" stem] }
        function total(run) { return both(run, "ICA I") + both(run, "VA") }
        function share(run, q) { return sprintf("%.1f %%", 100 * q / total(run)) }
        function known(x, format) { return x == "" ? "-" : sprintf(format, x) }
        function beat(x) { return x == "" ? "-" : sprintf("%.1f %%", 100 * x / (2 * enzmann["ICA"] + enzmann["basilar"])) }
        function row(title, z, e, ours, ground) { print "| " title " | " z " | " e " | " ours " | " ground " |" }
        function each(title, key, stem) {
            row(title, known(zarrinkoob[key], "%.0f %%"), beat(enzmann[key]),
                share("resistance", both("resistance", stem) / 2), share("ground", both("ground", stem) / 2))
        }
        END {
            print "| | Zarrinkoob 2015 | Enzmann 1994 | terminal resistances | outlets at ground |"
            print "|---|---:|---:|---:|---:|"
            all = "total_CBF(ICA+VA both sides)"
            row("total, mL/min", sprintf("%.0f ± %.0f", zarrinkoob[all], spread[all]), "-",
                sprintf("%.0f", total("resistance")), sprintf("%.0f", total("ground")))
            zarrinkoob["ICA"] = zarrinkoob["ICA_pair_share"] / 2
            each("internal carotid, each", "ICA", "ICA I")
            row("both vertebrals", known(zarrinkoob["VA_pair_share"], "%.0f %%"), "-",
                share("resistance", both("resistance", "VA")), share("ground", both("ground", "VA")))
            row("basilar", known(zarrinkoob["basilar"], "%.0f %%"), beat(enzmann["basilar"]),
                share("resistance", flow["resistance", "BA"]), share("ground", flow["ground", "BA"]))
            each("middle cerebral, each", "MCA", "M1")
            each("anterior cerebral (A1), each", "ACA", "A1")
            each("posterior cerebral (P2), each", "PCA", "P2")
        }' "$measured" "$here/results.csv"
}

# Every network with terminal resistances, and the territory whose supply differs most from the complete circle.
variants() {
    awk -F, '
        NR == 1 || $1 != "resistance" { next }
        { flow[$2, $3] = $4; if (!($2 in seen)) { seen[$2] = 1; name[++n] = $2 } }
        END {
            print "| | total, mL/min | left carotid | right carotid | vertebrals | supply that differs most |"
            print "|---|---:|---:|---:|---:|---|"
            ends = split("L-M1 R-M1 L-A2 R-A2 L-P2 R-P2", end, " ")
            for (i = 1; i <= n; i++) {
                v = name[i]
                l = flow[v, "L-ICA I"]; r = flow[v, "R-ICA I"]; b = flow[v, "L-VA"] + flow[v, "R-VA"]
                most = ""; change = 0
                for (e = 1; e <= ends; e++) {
                    d = 100 * (flow[v, end[e]] / flow["complete", end[e]] - 1)
                    if (d * d > change * change) { change = d; most = end[e] }
                }
                differs = change * change < 0.0025 ? "-" : sprintf("%s %+.1f %%", most, change)
                t = l + r + b
                printf "| %s | %.0f | %.1f %% | %.1f %% | %.1f %% | %s |\n", v, t, 100 * l / t, 100 * r / t, 100 * b / t, differs
            }
        }' "$here/results.csv"
}

# Puts a text between the marks NAME:begin and NAME:end of README.md.
splice() {
    awk -v begin="<!-- $1:begin -->" -v end="<!-- $1:end -->" '
        FNR == NR { text = text $0 "\n"; next }
        $0 == end { inside = 0 }
        !inside { print }
        $0 == begin { inside = 1; printf "%s", text }' "$work/$1.md" "$here/README.md" >"$work/spliced"
    cat "$work/spliced" >"$here/README.md"
}

shares >"$work/shares.md"
variants >"$work/variants.md"
splice shares
splice variants
cat "$work/shares.md" "$work/variants.md"
[ -n "${WILLIS:-}" ] || cargo run --release --locked --quiet --example fingerprints -- record flow-shares
