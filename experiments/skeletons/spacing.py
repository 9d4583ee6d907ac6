"""How many decisions stay the same when the points of the same centerlines lie at other distances. spacing.py SKELBENCH WORK CASES... [-- OPTIONS].

CASES are folders with fragments.npz or fragments.swc. OPTIONS go to `willis infer`, such as --cut always. WILLIS names the program.
"""
import csv
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, sys.argv[1])
import make_cases

WILLIS = os.environ.get("WILLIS", "target/release/willis")
STEPS = (.05, .1, .25, .5, 1)
# Ends that are no further apart, mm, are at one place, or nearly.
NEAR, NEARLY = 1.5, 4


def willis(*words):
    subprocess.run([str(word) for word in (WILLIS, *words, "--quiet", "--force")], check=True)


def decisions(lines, out, options):
    """The ends of kept candidates, and how many contacts are cut."""
    willis("infer", lines, "-o", out, "--dpi", 36, "-n", 1, *options)
    rows = list(csv.DictReader(open(out / "edges.csv", newline="")))
    kept = [[float(row[end + axis + "_mm"]) for end in "ab" for axis in "xyz"] for row in rows if (row["origin"], row["kept"]) == ("candidate", "1")]
    return np.array(kept).reshape(-1, 2, 3), sum((row["origin"], row["kept"]) == ("contact", "0") for row in rows)


def shared(some, others, near):
    """How many of some candidates are among others, but for so many mm."""
    both = np.concatenate([others, others[:, ::-1]])
    away = np.linalg.norm(some[:, None] - both[None], axis=3).max(axis=2)
    return int((away.min(axis=1, initial=np.inf) <= near).sum())


def main():
    work, words = Path(sys.argv[2]), sys.argv[3:]
    options = words[words.index("--") + 1:] if "--" in words else []
    totals = {step: np.zeros(6, int) for step in STEPS}
    for number, case in enumerate(map(Path, words[:len(words) - len(options) - bool(options)])):
        own = work / str(number)
        own.mkdir(parents=True, exist_ok=True)
        lines = next(case / name for name in ("fragments.npz", "fragments.swc") if (case / name).exists())
        willis("convert", lines, own / "fragments.npz")
        (own / "truth.json").write_text('{"level": ""}')
        kept, cut = decisions(own / "fragments.npz", own / "out", options)
        for step in STEPS:
            make_cases.respace(own, own / str(step), step)
            others, cut_there = decisions(own / str(step) / "fragments.npz", own / str(step) / "out", options)
            totals[step] += [len(kept), len(others), shared(kept, others, NEAR), shared(kept, others, NEARLY), cut, cut_there]
    print(f"| mm | kept | kept then | within {NEAR} mm | within {NEARLY} mm | cuts | cuts then |\n|---|---|---|---|---|---|---|")
    for step, (kept, then, same, nearly, cut, cut_then) in totals.items():
        of_both = 2 / max(kept + then, 1)
        print(f"| {step} | {kept} | {then} | {of_both * same:.3f} | {of_both * nearly:.3f} | {cut} | {cut_then} |")


if __name__ == "__main__":
    main()
