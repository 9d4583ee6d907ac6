"""Scores answers to the manual masks of two people by skelbench, cut and not cut, with the expert's tubes as truth. manual.py SKELBENCH DATA WORK [SUBJECT].

With SUBJECT it only makes the case of that one, with its mask in the frame of the tubes, as weights.sh asks for it.

DATA holds tubetk-masks. WILLIS names the program. The tubes lie in a frame with x and y the other way round, so that answers are turned into it.
"""
import os
import subprocess
import sys
from pathlib import Path

import nibabel
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


def made(bench, data, case):
    """The case of a subject, with its mask turned into the frame of the tubes."""
    if not (case / "truth.json").exists():
        mask, tubes = (data / f"tubetk-masks/{name}-{case.name}{ending}" for name, ending in (("labels", ".nii.gz"), ("tubes", ".vtp")))
        run(sys.executable, bench / "make_cases.py", "real", mask, tubes, case, "--tubes", f"--flip={','.join(map(str, FLIP))}")
        image = nibabel.load(mask)
        turned = (np.asarray(image.dataobj) > 0).astype(np.uint8)
        nibabel.save(nibabel.Nifti1Image(turned, np.diag([*FLIP, 1.0]) @ image.affine), case / "mask.nii.gz")


def main(bench, data, work):
    print("| mask | answer | " + " | ".join(FIGURES) + " |\n" + "|---" * (len(FIGURES) + 2) + "|")
    for subject in ("002", "003"):
        made(bench, data, work / subject)
        truth = score.Case(work / subject)
        for cut, name in (("never", "nothing cut"), ("auto", "cut (default)")):
            lines = answer(data / f"tubetk-masks/labels-{subject}.nii.gz", work / f"{subject}-{cut}", cut)
            found = score.score(truth, *score.read_answer(lines, truth))
            print(f"| {subject} | {name} | " + " | ".join("%.4g" % found[key] for key in FIGURES) + " |", flush=True)


if __name__ == "__main__":
    bench, data, work = (Path(word).resolve() for word in sys.argv[1:4])
    if len(sys.argv) > 4:
        made(bench, data, work / sys.argv[4])
    else:
        main(bench, data, work)
