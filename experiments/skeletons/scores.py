"""Scores the answers that run.sh left in WORK by skelbench, and writes results.csv, the tables of README.md and scores.png. scores.py SKELBENCH WORK.

WORK has cases/<level>/<subject>, a folder of answers for each name of ANSWERS, and the tables that the other scripts printed, <name>.md. Intervals are
95 %, by drawing subjects 2,000 times.
"""
import json
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

bench, work = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(bench), str(HERE.parent)]
import common
import passes
import score

ANSWERS = {
    "as-is": "lines as they are",
    "thinnest": "lines, cycles cut at their thinnest vessel",
    "paper": "lines, `--preset paper`",
    "uncertain-all": "lines, `--uncertain all`",
    "fragments": "lines (default: not cut)",
    "fragments-cut": "lines, cut (`--cut always`)",
    "mask-uncut": "mask, nothing cut",
    "mask-cut": "mask, cut (default)",
    "image-0-0": "mask and image",
    "image-.4-.05": "the same, dropouts .4, texture .05",
    "image-.8-.15": "the same, dropouts .8, texture .15",
}
# The answer that a gain is over.
BASES = {"fragments-cut": "fragments", "mask-cut": "mask-uncut", "image-0-0": "mask-cut", "image-.4-.05": "mask-cut", "image-.8-.15": "mask-cut"}
FIGURES = (
    "path", "strict", "nrun", "cut_recall", "cut_wrong", "lost_connections", "through_kept", "splits", "merges", "cycles", "join_precision", "join_recall",
    "join_f1", "join_ap",
)
GAINS = ("path", "nrun", "join_ap")
SHOWN = ("path", "strict", "nrun", "cut_recall", "lost_connections", "cycles", "join_f1", "join_ap")
HEADINGS = ("cases", "answer", "path", "strict path", "nrun", "cut recall", "lost", "cycles", "join F1", "join AP")


def scored(job):
    """Level, name and figures of an answer."""
    name, level, folder, answer = job
    case = score.Case(folder)
    lines, rows = score.read_answer(answer, case)
    found = score.score(case, lines, rows)
    return level, name, dict(found, strict=passes.pair_errors(case, lines)["strict"], subject=case.t["subject"])


def jobs():
    for folder in sorted(path.parent for path in (work / "cases").glob("*/*/truth.json")):
        for name in ANSWERS:
            answer = work / name / folder.parent.name / folder.name
            answer = next((path for path in (answer, answer.with_name(answer.name + ".npz")) if path.exists()), None)
            if answer:
                yield name, folder.parent.name, folder, answer


def interval(values):
    """Mean, and the ends of its interval."""
    values = np.array([np.nan if value is None else value for value in values], float)
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    means = values[np.random.default_rng(0).integers(len(values), size=(2000, len(values)))].mean(1)
    return values.mean(), *np.percentile(means, [2.5, 97.5])


def digits(figure, value):
    if figure == "lost_connections":
        return f"{100 * value:.2f} %" if value < .1 else f"{100 * value:.1f} %"
    if figure == "cycles":
        return f"{value:.0f}"
    return f"{value:.3f}".replace("0.", ".", 1) if value < 1 else f"{value:.3f}"


def cell(figure, found):
    if found is None:
        return ""
    value, low, high = (digits(figure, x) for x in found)
    return f"{value} [{low}, {high}]" if figure in ("path", "nrun") else value


def calibration(found):
    """The calibration error over the candidates of all cases of a level, in ten bins."""
    rows = [row for of in found for row in of["_joins"]]
    return score.reliability(rows)["ece"] if rows else None


def draw(results):
    plt = common.pyplot()
    if plt is None:
        return
    levels, shown = ("good", "fair"), ("path", "nrun", "cut_recall")
    fig, axes = plt.subplots(1, len(shown), figsize=(10, 3.2), sharey=True, layout="constrained")
    names = [name for name in ANSWERS if any((level, name, "path") in results for level in levels)]
    for axis, figure in zip(axes, shown):
        for level, off, colour in zip(levels, (-.17, .17), ("#0072B2", "#D55E00")):
            for at, name in enumerate(reversed(names)):
                found = results.get((level, name, figure))
                if found:
                    value, low, high, _ = found
                    axis.barh(at - off, value, .3, color=colour, label=level if at == 0 else None)
                    axis.hlines(at - off, low, high, color="0.2", lw=1)
        axis.set(title=figure.replace("_", " "), xlim=(0, 1))
    axes[0].set_yticks(range(len(names)), [ANSWERS[name].replace("`", "") for name in reversed(names)])
    axes[-1].legend(frameon=False, loc="lower right")
    fig.savefig(HERE / "scores.png", dpi=110, metadata={"Software": None})


def main():
    found = {}
    with ProcessPoolExecutor() as pool:
        for level, name, figures in pool.map(scored, jobs()):
            found.setdefault((level, name), []).append(figures)
    results = {}
    for (level, name), of in found.items():
        for figure in FIGURES:
            mean = interval([one.get(figure) for one in of])
            if mean:
                results[level, name, figure] = (*mean, len(of))
        error = calibration(of)
        if error is not None:
            results[level, name, "join_calibration"] = (error, None, None, len(of))
        if name in BASES:
            plain = {one["subject"]: one for one in found.get((level, BASES[name]), [])}
            for figure in GAINS:
                pairs = [one[figure] - plain[one["subject"]][figure] for one in of if one["subject"] in plain and one.get(figure) is not None]
                gain = interval(pairs)
                if gain:
                    results[level, name, f"{figure}_less_base"] = (*gain, len(pairs))
    round4 = lambda x: "" if x is None else f"{x:.4f}"
    common.write_results(HERE, [
        dict(level=level, answer=name, figure=figure, value=round4(value), low=round4(low), high=round4(high), cases=cases)
        for (level, name, figure), (value, low, high, cases) in results.items()
    ])
    order = sorted(found, key=lambda key: (list(dict.fromkeys(level for level, _ in found)).index(key[0]), list(ANSWERS).index(key[1])))
    row = lambda key: [key[0].replace("-crop", ", cropped"), ANSWERS[key[1]]] + [cell(figure, (results.get((*key, figure)) or (None,))[:3] if (*key, figure) in results else None) for figure in SHOWN]
    common.splice(HERE / "README.md", "answers", common.table(HEADINGS, map(row, order)))
    lines = [
        [level.replace("-crop", ", cropped"), ANSWERS[name], ANSWERS[BASES[name]]] + ["{:+.3f} [{:+.3f}, {:+.3f}]".format(*results[level, name, f"{figure}_less_base"][:3]) for figure in GAINS]
        for level, name in order
        if all((level, name, f"{figure}_less_base") in results for figure in GAINS)
    ]
    common.splice(HERE / "README.md", "paired", common.table(("cases", "answer", "over", "path", "nrun", "join AP"), lines))
    for printed in sorted(work.glob("*.md")):
        common.splice(HERE / "README.md", printed.stem, printed.read_text().strip())
    draw(results)
    (work / "scores.json").write_text(json.dumps({"/".join(key): value for key, value in results.items()}, indent=1))


if __name__ == "__main__":
    main()
