"""The drawn circle of `willis phantom`, whole and broken: cases to train its atlas on, and how well each variant is named without it."""
import csv
import json
import sys
import tempfile
import tomllib
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common
from cases import OTHER, OWNERS, RING, bare

# What each variant lacks: those of experiments/phenotypes.
VARIANTS = ("", "AComm", "L-A1", "R-A1", "L-P1", "R-P1", "L-PComm", "R-PComm", "L-PComm,R-PComm", "L-PComm,R-P1", "R-PComm,L-P1")
# A vessel of the phantom -> its name here. The last state of the basilar artery holds the vertebral ones.
NAMES = {f"{s}-ICA {part}": f"{s}-ICA" for s in "LR" for part in ("I", "II")} | {f"{s}-{a}": f"{s}-{a}" for s in "LR" for a in ("M1", "A1", "A2", "P1", "P2", "PComm")} | {"BA": "BA", "L-VA": "BA", "R-VA": "BA", "AComm": "AComm"}
# Seeds of the damage: none of experiments/phenotypes.
SEEDS = range(1000, 1008)
# Points of a broken circle further from every vessel (mm) are spurious.
FAR = 1.5


def rows_of(path):
    """(ids, vessel numbers, points, parents) of an SWC, and the names of its vessels by number."""
    named, rows = {}, []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:2] == ["#", "label"]:
            named[int(words[2])] = " ".join(words[3:])
        elif words and words[0] != "#":
            rows.append([float(word) for word in words])
    rows = np.array(rows)
    return rows[:, 0].astype(int), rows[:, 1].astype(int), rows[:, 2:5], rows[:, 6].astype(int), named


def write(out, lacks, level, source, tree, names):
    """The folder of one case."""
    ids, _, points, _, _ = rows_of(source)
    far, near = tree.query(points)
    own = [OTHER if d > FAR else names[k] for d, k in zip(far, near)]
    folder = out / f"{(lacks or 'complete').replace(',', '_')}-{level}"
    folder.mkdir(parents=True)
    source.rename(folder / "fragments.swc")
    loops = source.with_suffix(".loops.csv")
    if loops.exists():
        loops.rename(folder / "loops.csv")
    with open(folder / "labels.csv", "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([("id", "label"), *zip(ids, own)])
    present = [{"segment": s, "present": s not in lacks.split(",")} for s in RING]
    (folder / "truth.json").write_text(json.dumps({"subject": lacks or "complete", "level": level.split("-")[0], "whole": level == "whole", "frame": "RAS", "phenotype": present}) + "\n")


def make(out):
    """Writes OUT/VARIANT-whole and OUT/VARIANT-broken-SEED."""
    with tempfile.TemporaryDirectory() as scratch:
        for lacks in VARIANTS:
            without = ["--without", lacks] if lacks else []
            source = Path(scratch) / "case.swc"
            common.willis("phantom", "cerebral", *without, "-o", source)
            _, vessels, points, _, named = rows_of(source)
            names = [NAMES.get(named.get(v), OTHER) for v in vessels]
            # A point where arteries meet is that of the first of OWNERS, as in the cases of patients.
            tree = cKDTree(points)
            names = [min((names[k] for k in tree.query_ball_point(p, 1e-6)), key=lambda name: OWNERS.index(bare(name))) for p in points]
            write(out, lacks, "whole", source, tree, names)
            for seed in SEEDS:
                common.willis("phantom", "cerebral", *without, "--break", "--seed", seed, "-o", source)
                write(out, lacks, f"broken-{seed}", source, tree, names)
                for path in Path(scratch).iterdir():
                    path.unlink()


def run(work, _):
    """Each variant named by an atlas of the ten others."""
    if not (work / "train").exists():
        make(work / "train")
    common.willis("train", "train", "--model", "labels", "-o", work / "drawn.toml", "--folds", len(VARIANTS), threads=2, folder=work)
    lines = []
    for row in tomllib.loads((work / "drawn.toml").read_text())["figures"]:
        lines.append([row["of"], row["cases"], *(f"{row[share]:.3f}" for share in ("length_right", "presence_right", "exact"))])
    return common.table(["damage", "cases", "length right", "segments right", "all of a case right"], lines)
