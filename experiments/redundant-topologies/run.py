"""Broken and over-connected phenotypes, pruned at the median for three occlusion probabilities."""
import json
import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common
from networks import SHARED, WORK, literature

EPSILONS = ["0.2", "0.3", "0.5"]
SEEDS = range(5)


def parts_and_cycles(edges):
    """Connected parts and independent cycles of a list of node pairs."""
    parent = {}

    def root(node):
        parent.setdefault(node, node)
        while parent[node] != node:
            parent[node] = parent[parent[node]]
            node = parent[node]
        return node

    cycles = 0
    for a, b in edges:
        a, b = root(a), root(b)
        if a == b:
            cycles += 1
        parent[a] = b
    return len({root(node) for node in parent}), cycles


def figures(group, name, out, epsilon, truth):
    edges = common.rows(out / "edges.csv")
    ids = {row["node"]: row["id"] for row in common.rows(out / "nodes.csv")}
    above = [e for e in edges if e["above_median"] == "1"]
    parts, cycles = parts_and_cycles([(e["node_a"], e["node_b"]) for e in above])
    row = {"group": group, "network": name, "epsilon": epsilon, "vessels": len(edges), "above_median": len(above), "parts": parts, "cycles": cycles}
    if truth:
        joined = {frozenset((ids[e["node_a"]], ids[e["node_b"]])) for e in above}
        offered = {frozenset((ids[e["node_a"]], ids[e["node_b"]])) for e in edges}
        breaks = [frozenset(map(str, b["ids"])) for b in truth["breaks"]]
        row["breaks"] = len(breaks)
        row["breaks_offered"] = sum(b in offered for b in breaks)
        row["breaks_bridged"] = sum(b in joined for b in breaks)
        row["true_cycles"] = truth["cycles"]
        row["phenotype_kept"] = int(cycles == truth["cycles"] and row["breaks_bridged"] == len(breaks))
    else:
        row.update(dict.fromkeys(("breaks", "breaks_offered", "breaks_bridged", "true_cycles", "phenotype_kept"), ""))
    return row


def infer(source, out, extra=()):
    common.willis("infer", source, "-o", out, "--preset", "paper", "--epsilon", ",".join(EPSILONS), "-n", 1000, "--seed", 0, "--dpi", 72, *extra)


def without(name):
    """The option that leaves out the vessels of without-LABEL-LABEL."""
    labels = re.findall(r"[LR]-\w+|AComm", name)
    return ["--without", ",".join(labels)] if labels else []


def phantom(job):
    network, seed = job
    folder = WORK / "redundant-topologies" / f"{network.name}-{seed}"
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / "extraction.swc"
    common.willis("phantom", "cerebral", *without(network.name), "--break", "--spacing", "1mm", "--seed", seed, "-o", source)
    truth = json.loads(source.with_suffix(".truth.json").read_text())
    out = folder / "out"
    infer(source, out)
    graph = common.ends_in_graph(network.path)
    truth["cycles"] = parts_and_cycles(graph)[1]
    return [figures("literature", f"{network.name}", out / f"epsilon-{e}", e, truth) for e in EPSILONS]


def real(job):
    group, path, extra = job
    out = WORK / "redundant-topologies" / path.stem
    infer(path, out, extra)
    return [figures(group, path.stem, out / f"epsilon-{e}", e, None) for e in EPSILONS]


jobs = [(network, seed) for network in literature() for seed in SEEDS]
results = [row for rows in common.everywhere(phantom, jobs) for row in rows]
trees = sorted(SHARED.glob("brava/*.vtp"))
if not trees:
    print(f"skipped: no {SHARED / 'brava'}", file=sys.stderr)
results += [row for rows in common.everywhere(real, [("brava", path, ()) for path in trees]) for row in rows]
common.write_results(HERE, results)

lines, groups = [], {}
for r in results:
    groups.setdefault((r["group"], r["network"] if r["group"] == "literature" else "all", r["epsilon"]), []).append(r)
for (group, name, epsilon), some in groups.items():
    mean = lambda key: sum(r[key] for r in some) / len(some)
    if group == "literature":
        share = lambda key: f"{sum(r[key] for r in some)} of {sum(r['breaks'] for r in some)}"
        lines.append([name, epsilon, len(some), share("breaks_offered"), share("breaks_bridged"), f"{some[0]['true_cycles']}", f"{mean('cycles'):.1f}", f"{sum(r['phenotype_kept'] for r in some)} of {len(some)}"])
common.splice(HERE / "README.md", "phenotypes", common.table(["phenotype", "ε", "extractions", "breaks among the candidates", "breaks bridged", "true cycles", "cycles above the median", "phenotype kept"], lines))
lines = [[group, epsilon, len(some), f"{common.quantile([r['vessels'] for r in some], 0.5):.0f}", f"{common.quantile([r['above_median'] for r in some], 0.5):.0f}", f"{common.quantile([r['cycles'] for r in some], 0.5):.0f}"]
         for (group, name, epsilon), some in groups.items() if group != "literature"]
common.splice(HERE / "README.md", "subjects", common.table(["subjects", "ε", "n", "vessels (median)", "above the median", "cycles left"], lines))

plt = common.pyplot()
if plt:
    drawing, axis = plt.subplots(figsize=(6.5, 3.6), layout="constrained")
    names = list(dict.fromkeys(r["network"] for r in results if r["group"] == "literature"))
    for i, epsilon in enumerate(EPSILONS):
        shares = []
        for name in names:
            some = groups["literature", name, epsilon]
            shares.append(sum(r["breaks_bridged"] for r in some) / max(1, sum(r["breaks"] for r in some)))
        axis.bar([at + 0.26 * (i - 1) for at in range(len(names))], shares, 0.24, color=["#0072B2", "#E69F00", "#009E73"][i], label=f"ε = {epsilon}")
    axis.set_xticks(range(len(names)), names, rotation=40, ha="right", fontsize=7)
    axis.set(ylabel="true breaks bridged above the median", ylim=(0, 1))
    axis.legend(frameon=False, fontsize=8, ncols=3, loc="upper right")
    drawing.savefig(HERE / "bridged.png", dpi=150)
