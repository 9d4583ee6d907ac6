"""What the experiments share: running willis, quantiles, results tables, README tables between marks."""
import csv
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from networks import ROOT, WORK

WILLIS = os.environ.get("WILLIS", str(ROOT / "target/release/willis"))


def willis(*arguments, threads=1, folder=None):
    """Runs willis, from within a folder if one is given; a failure is shown with its command."""
    command = [str(Path(WILLIS).absolute()), *map(str, arguments), "--quiet", "--force", "--threads", str(threads)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=folder)
    if done.returncode:
        raise SystemExit(f"{' '.join(command)}\n{done.stderr}")


def made_with(experiment, *parts):
    """Writes down that parts of an experiment were just made with the answers of this version; not of a willis that is only tried."""
    if "WILLIS" in os.environ:
        print(f"not recorded, for WILLIS is set: experiments/{experiment}", file=sys.stderr)
        return
    subprocess.run(["cargo", "run", "--release", "--locked", "--quiet", "--example", "fingerprints", "--", "record", experiment, *parts], check=True, cwd=ROOT)


def record(folder):
    """run.json of an output folder."""
    return json.loads((Path(folder) / "run.json").read_text())


def rows(path):
    """The rows of a CSV file."""
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def everywhere(job, items):
    """`job` of each item, two at a time, in order."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(job, items))


def quantile(values, q):
    """By linear interpolation."""
    values = sorted(values)
    at = q * (len(values) - 1)
    low = int(at)
    high = min(low + 1, len(values) - 1)
    return values[low] + (at - low) * (values[high] - values[low])


def write_results(folder, results, name="results.csv"):
    """A file of results: a list of dictionaries with the same keys."""
    with open(Path(folder) / name, "w", newline="") as file:
        out = csv.DictWriter(file, list(results[0]), lineterminator="\n")
        out.writeheader()
        out.writerows(results)


def table(header, lines):
    """A Markdown table."""
    return "\n".join(["| " + " | ".join(header) + " |", "|" + "---|" * len(header)] + ["| " + " | ".join(map(str, line)) + " |" for line in lines])


def splice(path, mark, text):
    """Puts `text` between the marks of a Markdown file."""
    begin, end = f"<!-- {mark}:begin -->\n", f"<!-- {mark}:end -->"
    whole = Path(path).read_text()
    head, rest = whole.split(begin)
    _, tail = rest.split(end)
    Path(path).write_text(head + begin + text + "\n" + end + tail)


def pyplot():
    """matplotlib.pyplot, or None, said aloud, where it is not installed."""
    try:
        import matplotlib

        matplotlib.use("Agg")
        import matplotlib.pyplot as plt

        plt.rcParams.update({"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "svg.hashsalt": "willis"})
        return plt
    except ImportError:
        print("skipped: figures, for there is no matplotlib")
        return None


# Okabe and Ito's colours.
COLOURS = {"literature": "#0072B2", "insist-cow": "#D55E00", "brava": "#009E73", "padmos-patient0": "#CC79A7"}


def strips(axis, groups, log=False):
    """One column of dots a group, with its median; `groups` maps a name to figures."""
    for at, (group, values) in enumerate(groups.items()):
        n = len(values)
        spread = [at + 0.3 * ((i * 0.618034) % 1 - 0.5) for i in range(n)]
        axis.plot(spread, values, "o", ms=3.5, alpha=0.75, color=COLOURS[group], mec="none")
        axis.plot([at - 0.25, at + 0.25], [quantile(values, 0.5)] * 2, color="black", lw=1.5)
    axis.set_xticks(range(len(groups)), [f"{group}\n(n = {len(values)})" for group, values in groups.items()])
    axis.set_xlim(-0.6, len(groups) - 0.4)
    if log:
        axis.set_yscale("log")
