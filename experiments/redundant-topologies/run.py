"""Phenotypes with redundant connections, and broken ones, pruned at the median for three occlusion probabilities."""
import json
import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common
from networks import WORK, literature, networks

EPSILONS = ["0.2", "0.3", "0.5"]
SEEDS = range(5)
# The arteries that make the circle.
CIRCLE = re.compile(r"A1|P1|PComm|AComm|PCoA|ACoA")


def infer(source, out, extra):
    common.willis("infer", source, "-o", out, "--preset", "paper", "--epsilon", ",".join(EPSILONS), "-n", 1000, "--seed", 0, "--dpi", 72, *extra)


def redundant(network):
    """The network's own vessels are known; candidates between nearest ends are added, and all is uncertain."""
    out = WORK / "redundant-topologies" / network.name
    infer(network.path, out, ["--observed", *network.conditions["ground"]])
    results = []
    for epsilon in EPSILONS:
        edges = common.rows(out / f"epsilon-{epsilon}" / "edges.csv")
        true = [e for e in edges if e["origin"] == "observed"]
        false = [e for e in edges if e["origin"] == "candidate"]
        circle = [e for e in true if CIRCLE.search(e["label"])]
        above = lambda some: sum(e["above_median"] == "1" for e in some)
        results.append({
            "extraction": "whole", "group": network.group, "network": network.name, "epsilon": epsilon,
            "true": len(true), "true_above": above(true), "false": len(false), "false_above": above(false),
            "circle": len(circle), "circle_above": above(circle),
        })
    return results


def without(name):
    """The option that leaves out the vessels of without-LABEL-LABEL."""
    labels = re.findall(r"[LR]-\w+|AComm", name)
    return ["--without", ",".join(labels)] if labels else []


def broken(job):
    """A broken extraction of a phenotype: the breaks of known place are what is to be found."""
    network, seed = job
    folder = WORK / "redundant-topologies" / f"{network.name}-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / "extraction.swc"
    common.willis("phantom", "cerebral", *without(network.name), "--break", "--spacing", "1mm", "--seed", seed, "-o", source)
    breaks = {frozenset(map(str, b["ids"])) for b in json.loads(source.with_suffix(".truth.json").read_text())["breaks"]}
    infer(source, folder / "out", [])
    results = []
    for epsilon in EPSILONS:
        out = folder / "out" / f"epsilon-{epsilon}"
        ids = {row["node"]: row["id"] for row in common.rows(out / "nodes.csv")}
        candidates = [e for e in common.rows(out / "edges.csv") if e["origin"] == "candidate"]
        right = [frozenset((ids[e["node_a"]], ids[e["node_b"]])) in breaks for e in candidates]
        above = [e["above_median"] == "1" for e in candidates]
        results.append({
            "extraction": f"broken, seed {seed}", "group": network.group, "network": network.name, "epsilon": epsilon,
            "true": len(breaks), "true_above": sum(r and a for r, a in zip(right, above)),
            "false": len(right) - sum(right), "false_above": sum(a and not r for r, a in zip(right, above)),
            "circle": "", "circle_above": "",
        })
    return results


results = [row for rows in common.everywhere(redundant, [n for n in networks() if n.has_positions]) for row in rows]
results += [row for rows in common.everywhere(broken, [(network, seed) for network in literature() for seed in SEEDS]) for row in rows]
common.write_results(HERE, results)


def total(some, key):
    return sum(row[key] for row in some)


def share(some, what):
    return f"{total(some, what + '_above')} of {total(some, what)} ({100 * total(some, what + '_above') / max(1, total(some, what)):.0f} %)"


whole = [r for r in results if r["extraction"] == "whole"]
lines = []
for group in dict.fromkeys(r["group"] for r in whole):
    for epsilon in EPSILONS:
        some = [r for r in whole if r["group"] == group and r["epsilon"] == epsilon]
        labelled = [r for r in some if r["circle"]]
        kept = f"{sum(r['circle'] == r['circle_above'] for r in labelled)} of {len(labelled)}" if labelled else ""
        lines.append([group, len(some), epsilon, share(some, "true"), share(some, "false"), share(labelled, "circle") if labelled else "", kept])
header = ["networks", "n", "ε", "true vessels above the median", "redundant ones", "vessels of the circle", "phenotype kept whole"]
common.splice(HERE / "README.md", "whole", common.table(header, lines))
lines = []
for epsilon in EPSILONS:
    some = [r for r in results if r["extraction"] != "whole" and r["epsilon"] == epsilon]
    lines.append([len(some), epsilon, share(some, "true"), share(some, "false")])
common.splice(HERE / "README.md", "broken", common.table(["extractions", "ε", "true breaks bridged above the median", "false bridges"], lines))

plt = common.pyplot()
if plt:
    drawing, axis = plt.subplots(figsize=(6.5, 3.6), layout="constrained")
    groups = list(dict.fromkeys(r["group"] for r in whole))
    for i, epsilon in enumerate(EPSILONS):
        for j, (what, name) in enumerate((("true", "true vessels"), ("false", "redundant connections"))):
            some = [[r for r in whole if r["group"] == group and r["epsilon"] == epsilon] for group in groups]
            at = [place + 0.27 * (i - 1) + 0.12 * (j - 0.5) for place in range(len(groups))]
            shares = [total(rows, what + "_above") / total(rows, what) for rows in some]
            axis.bar(at, shares, 0.11, color=["#0072B2", "#D55E00"][j], label=name if i == 0 else None)
            for x, y in zip(at, shares):
                axis.annotate(f"ε {epsilon}" if j == 0 else "", (x, y), fontsize=6, ha="center", va="bottom", xytext=(0, 2), textcoords="offset points")
    axis.set_xticks(range(len(groups)), [f"{g}\n(n = {sum(r['group'] == g for r in whole) // len(EPSILONS)})" for g in groups])
    axis.set(ylabel="share above the median", ylim=(0, 0.65))
    axis.legend(frameon=False, fontsize=8, ncols=2, loc="upper center")
    drawing.savefig(HERE / "kept.png", dpi=150)
