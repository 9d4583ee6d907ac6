"""Which contacts of automatic skeletons are false fusions: by the mask or the lines, by the flow, by both. contacts.py SKELBENCH CASES WORK [LEVELS].

CASES/<level>/<subject> hold mask.nii.gz and fragments.npz, as experiments/contacts/unseen.sh makes them. WILLIS names the program. Contacts are opened (`--cut
always`), every vessel is uncertain, and the graph is sampled with P as the prior A, then handed back and sampled with A = 1. AUC: how probably a false fusion
scores higher than a true connection; AP: average precision of false fusions. Intervals by drawing subjects 2,000 times. "P and flow" is a logistic
regression on the logarithms of all four figures, fitted to the other subjects.
"""
import csv
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import average_precision_score, roc_auc_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

sys.path.insert(0, sys.argv[1])
import score

WILLIS = os.environ.get("WILLIS", "target/release/willis")
SAMPLES, EPSILON = 1000, 0.3
FIGURES = ("P", "L, A = P", "L, A = 1", "frequency, A = 1")
SOURCES = (("with mask", "mask.nii.gz"), ("lines alone", "fragments.npz"))


def sampled(source, out, *options):
    """The rows of edges.csv."""
    command = [WILLIS, "infer", source, "-o", out, "-n", SAMPLES, "--epsilon", EPSILON, "--uncertain", "all", "--dpi", 36, "--quiet", "--force", *options]
    subprocess.run([str(word) for word in command], check=True)
    return list(csv.DictReader(open(out / "edges.csv", newline="")))


def contacts(case, source, out):
    """Per contact that the truth judges whether it is a false fusion, and its figures."""
    rows = sampled(case / source, out / "p", "--cut", "always")
    plain = sampled(out / "p" / "candidates.graphml", out / "one", "--prior", "uniform")
    assert len(rows) == len(plain)
    truth = score.Case(case)
    courses = score.courses(truth, rows)
    found = []
    for row, again, course in zip(rows, plain, courses):
        if row["origin"] != "contact":
            continue
        edges = {frozenset(pair) for pair in zip(course[:-1], course[1:])}
        edges |= {edge for edge in [*truth.carry, *truth.ignore] if edge & set(course)}
        is_false = any(edge in truth.carry for edge in edges)
        if is_false or not edges & truth.ignore:
            found.append((is_false, float(row["probability"]), float(row["likelihood"]), float(again["likelihood"]), float(again["frequency"])))
    return np.array(found).reshape(-1, 1 + len(FIGURES))


def scores_of(some):
    """Per figure how much it says that each contact is a false fusion, and what all of them say together; some are the contacts by subject."""
    logs = [np.log(np.maximum(x[:, 1:], 1e-12 * np.maximum(x[:, 1:].max(axis=0, initial=0), 1e-300))) for x in some]
    out = [[-x[:, k] for x in logs] for k in range(len(FIGURES))]
    both = []
    for left, x in enumerate(logs):
        others = [k for k in range(len(some)) if k != left]
        model = make_pipeline(StandardScaler(), LogisticRegression())
        model.fit(np.concatenate([logs[k] for k in others]), np.concatenate([some[k][:, 0] for k in others]))
        both.append(model.decision_function(x) if len(x) else np.zeros(0))
    return [*out, both]


def main():
    cases, work = Path(sys.argv[2]), Path(sys.argv[3])
    levels = (sys.argv[4] if len(sys.argv) > 4 else "good,fair").split(",")
    rng = np.random.default_rng(0)
    print("| contacts | false of all | by | AUC [95 %] | AP [95 %] |\n|---|---|---|---|---|")
    for level in levels:
        folders = sorted(path for path in (cases / level).iterdir() if (path / "truth.json").exists())
        for name, source in SOURCES:
            some = [contacts(case, source, work / level / case.name / source) for case in folders]
            truth = [x[:, 0] for x in some]
            draws = rng.integers(len(some), size=(2000, len(some)))
            for by, values in zip((*FIGURES, "P and flow"), scores_of(some)):
                cells = []
                for measure in (roc_auc_score, average_precision_score):
                    of = lambda chosen: measure(np.concatenate([truth[k] for k in chosen]), np.concatenate([values[k] for k in chosen]))
                    low, high = np.percentile([of(draw) for draw in draws], [2.5, 97.5])
                    cells.append(f"{of(range(len(some))):.3f} [{low:.3f}, {high:.3f}]")
                false, count = int(sum(t.sum() for t in truth)), sum(map(len, truth))
                print(f"| {level}, {name} | {false} of {count} | {by} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
