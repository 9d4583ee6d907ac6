"""Which observed vessels and contacts of automatic skeletons are false fusions: by P, by the flow, by both. contacts.py SKELBENCH CASES WORK [LEVELS].

CASES/<level>/<subject> hold mask.nii.gz and fragments.npz, as experiments/skeletons/run.sh makes them. WILLIS names the program. Contacts are opened (`--cut
always`), every vessel is uncertain, and the graph is sampled with P as the prior A, then handed back and sampled with A = 1. AUC: how probably a false fusion
scores higher than a true connection; AP: average precision of false fusions. Intervals by drawing subjects 500 times. "P and size" is a logistic
regression on the logarithms of P, radius and length, "P, size and flow" one on all figures, each fitted to the other subjects.
"""
import csv
import subprocess
import sys
from pathlib import Path

import numpy as np
from sklearn.linear_model import LogisticRegression
from sklearn.metrics import average_precision_score, roc_auc_score
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import StandardScaler

sys.path[:0] = [sys.argv[1], str(Path(__file__).resolve().parent.parent)]
import common
import score

SAMPLES, EPSILON = 1000, 0.3
FIGURES = ("P", "L, A = P", "L, A = 1", "frequency, A = 1")
SIZE = ("radius_mm", "length_mm")
SOURCES = (("with mask", "mask.nii.gz"), ("lines alone", "fragments.npz"))


def sampled(source, out, *options):
    """The rows of edges.csv, from an earlier run if there is one."""
    if (out / "edges.csv").exists():
        return list(csv.DictReader(open(out / "edges.csv", newline="")))
    command = [common.WILLIS, "infer", source, "-o", out, "-n", SAMPLES, "--epsilon", EPSILON, "--uncertain", "all", "--dpi", 36, "--quiet", "--force", *options]
    subprocess.run([str(word) for word in command], check=True)
    return list(csv.DictReader(open(out / "edges.csv", newline="")))


def vessels(case, source, out):
    """Per observed vessel and contact that the truth judges whether it holds a false fusion, and its figures."""
    rows = sampled(case / source, out / "p", "--cut", "always")
    plain = sampled(out / "p" / "candidates.graphml", out / "one", "--prior", "uniform")
    assert len(rows) == len(plain)
    truth = score.Case(case)
    courses = score.courses(truth, rows)
    found = []
    for at, (row, again) in enumerate(zip(rows, plain)):
        if row["origin"] == "candidate":
            continue
        course = courses[at]
        edges = {frozenset(pair) for pair in zip(course[:-1], course[1:])}
        if row["origin"] == "contact":  # Which stands for all that meets there.
            edges |= {edge for edge in [*truth.carry, *truth.ignore] if edge & set(course)}
        is_false = any(edge in truth.carry for edge in edges)
        if is_false or not edges & truth.ignore:
            flow = (row["likelihood"], again["likelihood"], again["frequency"])
            found.append([is_false, *map(float, (row["probability"] or 1, *flow, *(row[name] for name in SIZE)))])
    return np.array(found)


def scores_of(some):
    """Per way to tell how much it says that each is a false fusion; some are the vessels by subject."""
    # The least that a figure says where it is 0.
    logs = [np.log(np.maximum(x[:, 1:], 1e-12 * x[:, 1:].max(axis=0))) for x in some]
    out = {name: [-x[:, k] for x in logs] for k, name in enumerate(FIGURES)}
    size = [0, *range(len(FIGURES), len(FIGURES) + len(SIZE))]
    for name, columns in (("P and size", size), ("P, size and flow", slice(None))):
        out[name] = []
        for left, x in enumerate(logs):
            others = [k for k in range(len(some)) if k != left]
            model = make_pipeline(StandardScaler(), LogisticRegression())
            model.fit(np.concatenate([logs[k][:, columns] for k in others]), np.concatenate([some[k][:, 0] for k in others]))
            out[name].append(model.decision_function(x[:, columns]))
    return out


def main():
    cases, work = Path(sys.argv[2]), Path(sys.argv[3])
    levels = (sys.argv[4] if len(sys.argv) > 4 else "good,fair").split(",")
    rng = np.random.default_rng(0)
    lines = []
    for level in levels:
        folders = sorted(path for path in (cases / level).iterdir() if (path / "truth.json").exists())
        for name, source in SOURCES:
            some = [vessels(case, source, work / level / case.name / source) for case in folders]
            truth = [x[:, 0] for x in some]
            draws = rng.integers(len(some), size=(500, len(some)))
            for by, values in scores_of(some).items():
                cells = []
                for measure in (roc_auc_score, average_precision_score):
                    of = lambda chosen: measure(np.concatenate([truth[k] for k in chosen]), np.concatenate([values[k] for k in chosen]))
                    low, high = np.percentile([of(draw) for draw in draws], [2.5, 97.5])
                    cells.append(f"{of(range(len(some))):.3f} [{low:.3f}, {high:.3f}]")
                false, count = int(sum(t.sum() for t in truth)), sum(map(len, truth))
                lines.append([f"{level}, {name}", f"{false:,} of {count:,}", by, *cells])
    table = common.table(["vessels and contacts", "false of all", "by", "AUC [95 %]", "AP [95 %]"], lines)
    print(table)
    common.splice(Path(__file__).with_name("README.md"), "contacts", table)
    common.made_with("redundant-topologies", "contacts")


if __name__ == "__main__":
    main()
