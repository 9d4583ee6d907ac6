"""Scores answers to the manual masks of two people by skelbench, cut and not cut, with the expert's tubes as truth. manual.py SKELBENCH DATA WORK.

DATA holds tubetk-masks. WILLIS names the program. The tubes lie in a frame with x and y the other way round, so that answers are turned into it.
"""
import os
import subprocess
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, sys.argv[1])
import score

WILLIS = os.environ.get("WILLIS", "target/release/willis")
FIGURES = ("path", "nrun", "cut_recall", "lost_connections", "cycles")
FLIP = (-1, -1, 1)


def run(*words):
    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL)


def answer(mask, out, cut):
    """The lines of the topology, in the frame of the tubes."""
    run(WILLIS, "infer", mask, "-o", out, "--cut", cut, "-n", 1, "--force", "--quiet")
    turned = out.with_suffix(".npz")
    run(WILLIS, "convert", out / "topology.graphml", turned, "--force", "--quiet")
    lines = dict(np.load(turned))
    np.savez(turned, **lines | {"coords": lines["coords"] * FLIP})
    return turned


bench, data, work = (Path(word).resolve() for word in sys.argv[1:4])
print("| mask | answer | " + " | ".join(FIGURES) + " |\n" + "|---" * (len(FIGURES) + 2) + "|")
for subject in ("002", "003"):
    mask, case = data / f"tubetk-masks/labels-{subject}.nii.gz", work / subject
    if not (case / "truth.json").exists():
        flip = ",".join(map(str, FLIP))
        run(sys.executable, bench / "make_cases.py", "real", mask, data / f"tubetk-masks/tubes-{subject}.vtp", case, "--tubes", f"--flip={flip}")
    truth = score.Case(case)
    for cut, name in (("never", "nothing cut"), ("auto", "cut (default)")):
        found = score.score(truth, *score.read_answer(answer(mask, work / f"{subject}-{cut}", cut), truth))
        print(f"| {subject} | {name} | " + " | ".join("%.4g" % found[key] for key in FIGURES) + " |", flush=True)
