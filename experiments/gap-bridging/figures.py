"""Precision-recall curves and reliability diagrams."""
import bench
import common
import contest
import numpy as np
import tables

COLOURS = dict(zip(contest.METHODS, ("black", "#0072B2", "#56B4E9", "#D55E00", "#CC79A7", "#E69F00", "#009E73")))
LEVEL = "medium"


def curves(plt, cases, results):
    """Precision against recall over all bridges of a data set, of medium damage, in one order of their scores."""
    fig, axes = plt.subplots(1, len(bench.SETS), figsize=(10, 3.6), sharey=True, layout="constrained")
    for axis, data in zip(axes, bench.SETS):
        at = [k for k, c in enumerate(cases) if (c.data, c.level) == (data, LEVEL)]
        for method in reversed(contest.METHODS):
            rows = np.vstack([results[method][k]["curve"][0] for k in at])
            rows = rows[np.argsort(-rows[:, 0], kind="stable")]
            found, false = np.cumsum(rows[:, 1]), np.cumsum(rows[:, 2])
            last = np.flatnonzero(np.r_[np.diff(rows[:, 0]) != 0, True])
            last = last[found[last] > 0]
            recall = found[last] / sum(results[method][k]["curve"][1] for k in at)
            axis.plot(recall, found[last] / (found[last] + false[last]), color=COLOURS[method], lw=2 if method == "willis" else 1.2, label=method)
        axis.set(title=f"{data}, {LEVEL}, {len(at)} cases", xlabel="recall", xlim=(0, 1), ylim=(0, 1.02))
    axes[0].set_ylabel("precision")
    axes[0].legend(*[x[::-1] for x in axes[0].get_legend_handles_labels()], frameon=False, loc="lower left")
    fig.savefig(tables.FOLDER / "precision-recall.png", dpi=110, metadata={"Software": None})


def interval(right, count):
    """Wilson's 95 % interval of a share."""
    z2 = 1.96**2
    middle, half = right + z2 / (2 * count), 1.96 * np.sqrt(right * (1 - right) / count + z2 / (4 * count**2))
    return (middle - half) / (1 + z2 / count), (middle + half) / (1 + z2 / count)


def reliability(plt, cases, results):
    """Share of right bridges against P, a point a tenth, all levels together."""
    fig, axes = plt.subplots(1, len(bench.SETS), figsize=(10, 3.6), sharey=True, layout="constrained")
    for axis, data in zip(axes, bench.SETS):
        axis.plot([0, 1], [0, 1], color="0.7", lw=1)
        for at, method in enumerate(("boosting", "forest2", "willis")):
            some = [r["bins"][0] for c, r in zip(cases, results[method]) if c.data == data and "bins" in r]
            count, p, right = np.sum(some, axis=0)
            use = count > 0
            p, right, count = p[use] / count[use] + 0.008 * (at - 1), right[use] / count[use], count[use]
            low, high = interval(right, count)
            axis.plot(p, right, "o-", color=COLOURS[method], lw=1.5 if method == "willis" else 1, ms=4, label=method)
            axis.vlines(p, low, high, color=COLOURS[method], lw=0.8)
        axis.set(title=f"{data}, all levels", xlabel="P, mean of a tenth", xlim=(0, 1), ylim=(0, 1))
    axes[0].set_ylabel("share of right bridges")
    axes[0].legend(*[x[::-1] for x in axes[0].get_legend_handles_labels()], frameon=False, loc="upper left")
    fig.savefig(tables.FOLDER / "reliability.png", dpi=110, metadata={"Software": None})


def draw(cases, results):
    plt = common.pyplot()
    if plt and {(data, LEVEL) for data in bench.SETS} <= {(c.data, c.level) for c in cases}:
        curves(plt, cases, results)
        reliability(plt, cases, results)
