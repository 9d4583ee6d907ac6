"""Whether complete circles stay complete when contacts are cut. rings.py GAPBENCH DATA.

Tracings of INSIST in which GAPBENCH draws the communicating arteries that they lack, and circles that `willis phantom` draws as masks of voxels of .25 to .7 mm,
unbroken. WILLIS names the program.
"""
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, sys.argv[1])
import make_cases

WILLIS = os.environ.get("WILLIS", "target/release/willis")


def counts(vessels, out, cut):
    command = [WILLIS, "infer", vessels, "-o", out, "--cut", cut, "-n", "1", "--dpi", "36", "--json", "--quiet", "--force"]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["counts"]


def tracings(work):
    for folder in sorted(path for path in Path(sys.argv[2], "insist-cow").iterdir() if path.is_dir()):
        rng = np.random.default_rng(int(hashlib.sha256(f"ring/{folder.name}".encode()).hexdigest()[:12], 16))
        points, radii, edges, *_ = make_cases.complete_ring(*make_cases.read_insist(folder), rng)
        file = work / f"{folder.name}.npz"
        np.savez(file, coords=points, edges=np.array(edges), radii=radii)
        yield file


def phantoms(work):
    for voxel in range(25, 75, 5):
        file = work / f"{voxel}.nii.gz"
        subprocess.run([WILLIS, "phantom", "cerebral", "--spacing", f"{voxel / 100}mm", "-o", file, "--force"], check=True, capture_output=True)
        yield file


print("| circles | cases with a cycle | cycles | cut | cycles kept |\n|---|---|---|---|---|")
with tempfile.TemporaryDirectory() as work:
    work = Path(work)
    for name, cases, cut in (
        ("tracings, completed; default", tracings, "auto"),
        ("tracings, completed; `--cut always`", tracings, "always"),
        ("drawn as masks; default", phantoms, "auto"),
    ):
        rings = before = cuts = after = 0
        for vessels in cases(work):
            plain, found = (counts(vessels, work / "out", how) for how in ("never", cut))
            cycles = plain["topology"]["cycles"]
            rings, before, cuts = rings + (cycles > 0), before + cycles, cuts + found["cut"]
            after += min(cycles, found["topology"]["cycles"])
        print(f"| {name} | {rings} | {before} | {cuts} | {after} |")
