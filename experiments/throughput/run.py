"""Time of one simulation on every network."""
import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common
from networks import WORK, networks

SAMPLES = 200_000
THREADS = sorted({1, os.cpu_count()})

results = []
for network in networks():
    for threads in THREADS:
        out = WORK / "throughput" / network.name
        arguments = ["--uncertain", "all", "--prior", "uniform", "--epsilon", 0.3, "-n", SAMPLES, "--seed", 0, "--dpi", 36]
        common.willis("infer", network.path, "-o", out, *arguments, *network.conditions["terminals"], threads=threads)
        record = common.record(out)
        vessels = len(common.rows(out / "edges.csv"))
        per_sample = 1e6 / record["time"]["samples_per_s"]
        results.append({"group": network.group, "network": network.name, "vessels": vessels, "threads": threads, "microseconds": per_sample})
common.write_results(HERE, results)

lines, groups = [], {}
for r in results:
    groups.setdefault((r["group"], r["threads"]), []).append(r)
for (group, threads), some in groups.items():
    times = [r["microseconds"] for r in some]
    vessels = [r["vessels"] for r in some]
    span = f"{min(vessels)}" if min(vessels) == max(vessels) else f"{min(vessels)}-{max(vessels)}"
    median = common.quantile(times, 0.5)
    lines.append([group, len(some), span, threads, f"{median:.2f}", f"{min(times):.2f} to {max(times):.2f}", f"{400 / median:,.0f}"])
header = ["networks", "n", "vessels", "threads", "µs a simulation (median)", "range", "the paper's 400 µs over ours"]
common.splice(HERE / "README.md", "times", common.table(header, lines))

plt = common.pyplot()
if plt:
    drawing, axis = plt.subplots(figsize=(5, 3.6), layout="constrained")
    one = [r for r in results if r["threads"] == 1]
    for group in dict.fromkeys(r["group"] for r in one):
        some = [r for r in one if r["group"] == group]
        axis.plot([r["vessels"] for r in some], [r["microseconds"] for r in some], "o", ms=4, color=common.COLOURS[group], label=group, alpha=0.8, mec="none")
    axis.axhspan(200, 600, color="grey", alpha=0.25, lw=0, label="the paper: 0.4 ± 0.2 ms")
    axis.set(xscale="log", yscale="log", xlabel="vessels", ylabel="µs a simulation, one thread")
    axis.set_xticks([10, 20, 50, 100, 200, 300], ["10", "20", "50", "100", "200", "300"])
    axis.minorticks_off()
    axis.legend(frameon=False, fontsize=8, loc="center right")
    drawing.savefig(HERE / "throughput.png", dpi=150)
