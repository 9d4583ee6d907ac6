"""Scores answers of willis on held-out subjects by skelbench, from skeletons and from masks, and how spacing changes decisions.

    python measure.py SKELBENCH CASES MODELS LEVEL [N]

CASES/<level>/<subject> are those of weights.sh, MODELS the beginning of its models of folds (final: final.fold-1.toml and so on). Of each
fold N subjects are taken, or all. Prints the means of score.py, and for the first subject of each fold the share of kept joins that
stay, by their middles within 1 mm, when the skeleton has points every so many mm.
"""
import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib

import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, sys.argv[1])
import make_cases
import score

WILLIS = os.environ.get("WILLIS", "target/release/willis")
STEPS = (.05, .1, .25, .5, 1.)
FIGURES = ("join_ap", "join_f1", "join_precision", "join_recall", "path", "nrun")


def infer(source, model, folder):
    subprocess.run([WILLIS, "infer", source, "-o", folder, "--prior", model, "-n", "1", "--force", "--quiet"], check=True)
    return folder


def middles(folder):
    with open(folder / "edges.csv") as file:
        rows = [row for row in csv.DictReader(file) if row["origin"] == "candidate" and row["kept"] == "1"]
    return np.array([[(float(row[f"a{k}_mm"]) + float(row[f"b{k}_mm"])) / 2 for k in "xyz"] for row in rows])


cases, models, level = pathlib.Path(sys.argv[2]), sys.argv[3], sys.argv[4]
most = int(sys.argv[5]) if len(sys.argv) > 5 else None
found, same = {"fragments.npz": [], "mask.nii.gz": []}, {step: [] for step in STEPS}
with tempfile.TemporaryDirectory() as work:
    work = pathlib.Path(work)
    for model in sorted(pathlib.Path(models).parent.glob(pathlib.Path(models).name + ".fold-*.toml")):
        subjects = tomllib.loads(model.read_text())["provenance"]["held_out"][:most]
        for subject in subjects:
            case = cases / level / subject
            for source, results in found.items():
                truth = score.Case(case)
                lines, rows = score.read_answer(infer(case / source, model, work / "out"), truth)
                results.append(score.score(truth, lines, rows))
        first = cases / level / subjects[0]
        whole = middles(infer(first / "fragments.npz", model, work / "out"))
        for step in STEPS:
            make_cases.respace(first, work / f"{step}", step)
            other = middles(infer(work / f"{step}" / "fragments.npz", model, work / "out"))
            same[step].append((cKDTree(other).query(whole)[0] < 1).mean())
print("| source | " + " | ".join(FIGURES) + " |")
for source, results in found.items():
    print(f"| {source} ({len(results)}) | " + " | ".join("%.3f" % np.nanmean([r[k] for r in results]) for k in FIGURES) + " |")
print("same joins: " + ", ".join("%g mm %.3f" % (step, np.mean(shares)) for step, shares in same.items()))
