"""A stenotic carotid and an occluded posterior communicating artery, on every network at hand."""
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common
from networks import WORK, networks

STENOSIS = "50%"


def mirrored(label):
    """The label of the other side."""
    return {"L": "R", "R": "L"}.get(label[0], label[0]) + label[1:] if label[1:2] in "-. " else label[:-1] + {"L": "R", "R": "L"}.get(label[-1], "")


def one(job):
    network, condition = job
    out = WORK / "controlled-stenosis" / network.name / condition
    perturbation = ["--stenosis", f"{network.artery}={STENOSIS}"]
    if network.collateral:
        perturbation += ["--occlude", network.collateral]
    common.willis("simulate", network.path, "-o", out, *network.conditions[condition], *perturbation)
    record = common.record(out)
    rows = {}
    for row in common.rows(out / "edges.csv"):
        rows.setdefault(row["label"], row)
    flow = lambda label, suffix="": abs(float(rows[label]["flow_mL_per_min" + suffix])) if label in rows else float("nan")
    share = lambda label: flow(label, "_perturbed") / flow(label) if label in rows and flow(label) > 0 else float("nan")
    others = [label for label in ("AComm", "L-PComm", "R-PComm", "PComm L", "PComm R", "ACoA", "L. PCoA", "R. PCoA") if label in rows and label != network.collateral]
    total = lambda suffix: sum(flow(label, suffix) for label in others)
    return {
        "group": network.group,
        "network": network.name,
        "outlets": condition,
        "artery": network.artery,
        "collateral": network.collateral or "",
        "rho_G_W_per_m3": record["rho_G_W_per_m3"],
        "rho_G_W_per_m3_perturbed": record["rho_G_W_per_m3_perturbed"],
        "rho_G_ratio": record["rho_G_W_per_m3_perturbed"] / record["rho_G_W_per_m3"],
        "inflow_ratio": record["total_inflow_mL_per_min_perturbed"] / record["total_inflow_mL_per_min"],
        "ipsilateral_flow_ratio": share(network.artery),
        "contralateral_flow_ratio": share(mirrored(network.artery)),
        "communicating_mL_per_min": total("") if others else float("nan"),
        "communicating_mL_per_min_perturbed": total("_perturbed") if others else float("nan"),
    }


results = common.everywhere(one, [(network, condition) for network in networks() for condition in ("ground", "terminals")])
common.write_results(HERE, results)


def figure(x):
    return "" if x != x else f"{x:.3g}"


literature = [r for r in results if r["group"] == "literature"]
lines = []
for r in sorted(literature, key=lambda r: (r["outlets"], literature.index(r))):
    lines.append([r["network"], r["outlets"], f"{r['artery']}, {r['collateral'] or 'none'}", figure(r["rho_G_W_per_m3"]), figure(r["rho_G_W_per_m3_perturbed"]),
                  figure(r["rho_G_ratio"]), figure(r["inflow_ratio"]), figure(r["ipsilateral_flow_ratio"]), figure(r["contralateral_flow_ratio"]),
                  f"{figure(r['communicating_mL_per_min'])} → {figure(r['communicating_mL_per_min_perturbed'])}"])
header = ["network", "outlets", "narrowed, occluded", "ρ_G W/m³", "perturbed", "ratio", "inflow ratio", "ipsilateral flow ratio", "contralateral", "communicating arteries mL/min"]
common.splice(HERE / "README.md", "literature", common.table(header, lines))

lines, groups = [], {}
for r in results:
    groups.setdefault((r["outlets"], r["group"]), []).append(r)
for (outlets, group), some in sorted(groups.items()):
    ratios = [r["rho_G_ratio"] for r in some]
    inflow = [r["inflow_ratio"] for r in some]
    lines.append([outlets, group, len(some), f"{sum(x < 1 for x in ratios)}", figure(common.quantile(ratios, 0.5)), f"{figure(min(ratios))} to {figure(max(ratios))}", figure(common.quantile(inflow, 0.5))])
common.splice(HERE / "README.md", "subjects", common.table(["outlets", "networks", "n", "ρ_G falls in", "median ratio", "range", "median inflow ratio"], lines))

plt = common.pyplot()
if plt:
    drawing, axes = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True, layout="constrained")
    for axis, outlets in zip(axes, ("ground", "terminals")):
        strips = {group: [r["rho_G_ratio"] for r in some] for (o, group), some in groups.items() if o == outlets}
        common.strips(axis, strips, log=True)
        axis.axhline(1, color="grey", lw=0.8, ls=":")
        axis.set_title("outlets at ground" if outlets == "ground" else "outlets behind terminal resistances", fontsize=9)
        axis.tick_params(axis="x", labelsize=7)
    paper = {"complete": 20.8 / 23.7, "second": 16.0 / 18.0, "third": 15.5 / 17.0}
    for axis in axes:
        axis.hlines(list(paper.values()), -0.45, 0.45, color="black", lw=1, ls="--", label="the paper's three phenotypes")
    axes[0].set_ylabel("ρ_G, perturbed over unperturbed")
    axes[1].legend(frameon=False, fontsize=8)
    drawing.savefig(HERE / "resilience.png", dpi=150)
