"""Resistances modulated at random in three classes, in every reading and with both ways to draw u, on every network at hand."""
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common
from networks import WORK, networks

SAMPLES = 1000
# Where u of a class lies: between its borders, or, of the paper's U(0, m), from zero to its upper border. The first class is the same.
CLASSES = {"0:0.2": ["0:0.2"], "0.2:0.3": ["0.2:0.3", "0:0.3"], "0.3:0.5": ["0.3:0.5", "0:0.5"]}
RANGES = [*CLASSES, "0:0.3", "0:0.5"]
READINGS = {"increment": "R(1+u)", "conductance": "R/(1-u)", "literal": "R(1-u)", "geometry": "r(1-u), l(1+u')"}


def one(job):
    network, condition, reading = job
    out = WORK / "resistance-modulation" / network.name / condition / reading
    arguments = ["-n", SAMPLES, "--seed", 0, "--classes", ",".join(RANGES), "--reading", reading]
    common.willis("modulate", network.path, "-o", out, *arguments, *network.conditions[condition])
    results = []
    rows = common.rows(out / "classes.csv")
    for name, u in ((name, u) for name, ranges in CLASSES.items() for u in ranges):
        figures = {row["quantity"]: row for row in rows if row["class"] == u}
        pressure = figures["mean_pressure_mmHg"]
        results.append({
            "group": network.group, "network": network.name, "outlets": condition, "reading": reading, "class": name, "u": u,
            "rho_G_ratio": float(figures["rho_G_W_per_m3"]["ratio"]),
            "inflow_ratio": float(figures["total_inflow_mL_per_min"]["ratio"]),
            "mean_pressure_change_mmHg": float(pressure["mean"] or "nan") - float(pressure["unperturbed"] or "nan"),
            "pressure_std_error_mmHg": float(pressure["std"] or "nan") / SAMPLES**0.5,
        })
    return results


jobs = [(network, condition, reading) for network in networks() for condition in ("ground", "terminals") for reading in READINGS]
results = [row for rows in common.everywhere(one, jobs) for row in rows]
common.write_results(HERE, results)


def mean(rows, key):
    values = [row[key] for row in rows if row[key] == row[key]]
    return sum(values) / len(values)


def select(**keys):
    return [row for row in results if all(row[key] == value for key, value in keys.items())]


lines = []
for name, u in ((name, u) for name, ranges in CLASSES.items() for u in ranges):
    for reading, formula in READINGS.items():
        line = [name.replace(":", "-"), u.replace(":", "-"), formula]
        for outlets in ("ground", "terminals"):
            some = select(group="literature", outlets=outlets, reading=reading, u=u)
            line += [f"{mean(some, 'rho_G_ratio'):.3f}", f"{mean(some, 'inflow_ratio'):.3f}", f"{mean(some, 'mean_pressure_change_mmHg'):+.2f}"]
        lines.append(line)
header = ["class", "u", "reading", "ρ_G, ground", "flow, ground", "ΔP mmHg, ground", "ρ_G, terminals", "flow, terminals", "ΔP mmHg, terminals"]
common.splice(HERE / "README.md", "literature", common.table(header, lines))

lines, groups = [], list(dict.fromkeys(row["group"] for row in results))
for group in groups:
    for outlets in ("ground", "terminals"):
        for reading, formula, u in ((*reading, u) for reading in READINGS.items() for u in CLASSES["0.3:0.5"]):
            some = select(group=group, outlets=outlets, reading=reading, u=u)
            all_three = sum(r["rho_G_ratio"] < 1 and r["inflow_ratio"] < 1 and r["mean_pressure_change_mmHg"] > 3 * r["pressure_std_error_mmHg"] for r in some)
            ratios = [r["rho_G_ratio"] for r in some]
            lines.append([group, len(some), outlets, u.replace(":", "-"), formula, f"{common.quantile(ratios, 0.5):.3f} ({min(ratios):.3f}-{max(ratios):.3f})",
                          f"{mean(some, 'inflow_ratio'):.3f}", f"{mean(some, 'mean_pressure_change_mmHg'):+.2f}", f"{all_three} of {len(some)}"])
header = ["networks", "n", "outlets", "u", "reading", "ρ_G ratio, median (range)", "flow ratio, mean", "ΔP mmHg, mean", "flow falls, pressure rises, ρ falls"]
common.splice(HERE / "README.md", "subjects", common.table(header, lines))

plt = common.pyplot()
if plt:
    drawing, axes = plt.subplots(2, 3, figsize=(10, 5.6), sharey="row", layout="constrained")
    for row, outlets in zip(axes, ("ground", "terminals")):
        for axis, name in zip(row, CLASSES):
            strips = {group: [r["rho_G_ratio"] for r in select(group=group, outlets=outlets, reading="increment", u=name)] for group in groups}
            common.strips(axis, strips)
            axis.axhline(1, color="grey", lw=0.8, ls=":")
            axis.set_title(f"u in {name.replace(':', '-')}, {'outlets at ground' if outlets == 'ground' else 'terminal resistances'}", fontsize=9)
            axis.tick_params(axis="x", labelsize=6)
        row[0].set_ylabel("ρ_G, R(1+u) over unperturbed")
    drawing.savefig(HERE / "resilience.png", dpi=150)
