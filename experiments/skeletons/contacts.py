"""How far P of contacts can be believed, on the answers of run.sh to masks. contacts.py SKELBENCH WORK.

What is one vessel at a contact is said by skelbench's `proofread.py`: the way along the true vessels from one side to the other is at most 1.5 mm longer than
the way through the contact. Contacts at which a side shows no true vessel are left out. ECE has ten bins of .1, all contacts of a row together. "Told" counts
the answers with a note that the vessels are unlike those that P was calibrated on.
"""
import csv
import json
import pathlib
import sys

import numpy as np

sys.path.insert(0, sys.argv[1])
import proofread
import score
from manual import FLIP

work = pathlib.Path(sys.argv[2])


def judged(case, run, flip=(1, 1, 1)):
    """P, whether it is one vessel, and whether it is kept, of each contact of an answer; whether its note says that P may be off."""
    courses = proofread.courses
    proofread.courses = lambda path: [(a, b, points * flip, origin) for a, b, points, origin in courses(path)]
    right = proofread.contact_truth(score.Case(case), run)
    proofread.courses = courses
    rows = list(csv.DictReader(open(run / "edges.csv")))
    known = [(rows[row], one) for row, one in right.items() if one is not None]
    told = any(note.startswith("the vessels are unlike those") for note in json.loads((run / "run.json").read_text())["notes"])
    return np.array([(float(row["probability"]), one, float(row["kept"])) for row, one in known]).reshape(-1, 3), told


def ece(p, one):
    which = np.minimum((p * 10).astype(int), 9)
    return sum(abs((p - one)[which == k].sum()) for k in range(10)) / len(p)


def row(name, kinds):
    p, one, kept = np.vstack([contacts for contacts, _ in kinds]).T
    apart, together = p[one == 0], p[one == 1]
    auc = np.mean((together[:, None] > apart) + .5 * (together[:, None] == apart))
    rng = np.random.default_rng(0)
    chance = np.mean([ece(p, rng.random(len(p)) < p) for _ in range(200)])
    cut = kept == 0
    print(f"| {name} | {len(kinds)} | {sum(told for _, told in kinds)} | {len(p)} | {p.sum():.1f} | {one.sum():.0f} | {ece(p, one):.3f} | {chance:.3f} | {auc:.3f} |"
          f" {cut.sum()} | {p[cut].sum():.1f} | {one[cut].sum():.0f} |", flush=True)


print("| masks | cases | told | contacts | sum of P | one vessel | ECE | ECE by chance | AUC | of these cut | sum of P | one vessel |\n" + "|---" * 12 + "|")
simulated = {}
for case in sorted((work / "cases").glob("*/*/truth.json")):
    run = work / "mask-cut" / case.parent.relative_to(work / "cases")
    if (run / "edges.csv").exists():
        simulated.setdefault(case.parent.parent.name, []).append(judged(case.parent, run))
for level, kinds in simulated.items():
    row(f"simulated, {level}", kinds)
if simulated:
    row("simulated, good and fair", simulated.get("good", []) + simulated.get("fair", []))
    row("simulated, all", sum(simulated.values(), []))
for subject, name in (("002", "manual, 002 (calibrated on)"), ("003", "manual, 003")):
    if (work / "manual" / f"{subject}-auto").exists():
        row(name, [judged(work / "manual" / subject, work / "manual" / f"{subject}-auto", FLIP)])
