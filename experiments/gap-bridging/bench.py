"""The cases of the benchmark: how they are made, where they stand, and who is held out together."""
import os
import subprocess
import sys
from collections import namedtuple
from functools import partial
from importlib.util import find_spec
from multiprocessing import Pool
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common
from networks import ROOT, SHARED

GAPBENCH = Path(os.environ.get("WILLIS_GAPBENCH", ROOT / "../shared/gapbench")).resolve()
sys.path.insert(0, str(GAPBENCH))

FOLDS = 3
LEVELS = ("easy", "medium", "hard")
# Name -> folder of tracings, options of make_cases.py. Circles and rings are the same subjects.
SETS = {
    "brains": ("brava/vtp", []),
    "circles": ("insist-cow", ["--phenotype", "--variants", "4"]),
    "rings": ("insist-cow", ["--phenotype", "--ring"]),
}
# Many draws of the rings, on which closures of loops are counted: one ring case in thirty holds one.
MANY = "many rings"
DRAWS = {MANY: ("insist-cow", ["--phenotype", "--ring", "--variants", "8"])}
# What weights are trained on: each is one data set of `willis train`, and draws of their own, which are never judged.
SOURCES = {"brains": ("brains",), "insist": ("circles", "rings")}
TRAINING_SEEDS = (1, 2, 3)
# Drawn arteries, to which the calibration is fitted too, by their seeds. In them what is joined is more often true than in patients.
PHANTOMS = range(1001, 1961)
# {subject: its fold}, from the weights of the folds: see command.held_out.
FOLD_OF = {}


class Case(namedtuple("Case", "data level name folder")):
    """One broken tracing: data set, level of damage, name, folder."""

    @property
    def subject(self):
        return self.name.rpartition("_")[0] if self.data in ("circles", MANY) else self.name

    @property
    def fold(self):
        """The fold in which the subject is held out."""
        return FOLD_OF[self.subject]

    def within(self, root):
        return Path(root) / self.data / self.level / self.name


def missing():
    """What of the shared data and of Python is not there."""
    wanted = [GAPBENCH / "score.py"] + [SHARED / folder for folder, _ in SETS.values()]
    packages = [name for name in ("numpy", "scipy", "networkx", "sklearn") if find_spec(name) is None]
    return [str(path) for path in dict.fromkeys(wanted) if not path.exists()] + packages


def broken(draws):
    """Makes draws of the damage, each (folder for them, data set, seed)."""

    def draw(job):
        root, data, seed = job
        folder, options = (SETS | DRAWS)[data]
        command = [sys.executable, GAPBENCH / "make_cases.py", SHARED / folder, root / data, "--seed", seed, *options]
        failed = subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL).returncode
        for table in (root / data).rglob("inlets.csv"):
            state_inlets(table)
        return failed

    if any(common.everywhere(draw, draws)):
        raise SystemExit("make_cases.py failed")


def state_inlets(table):
    """Writes what --bc takes, conditions.csv, beside a table of inlets."""
    heading, *rows = table.read_text().split()
    lines = [f"{heading},kind", *(f"{row},inlet" for row in rows)]
    table.with_name("conditions.csv").write_text("\n".join(lines) + "\n")


def listed(root, sets, every=1):
    """The cases of every n-th subject, in order."""
    found = [Case(data, level, folder.name, folder) for data in sets for level in LEVELS for folder in sorted((root / data / level).iterdir())]
    keep = {data: sorted({case.subject for case in found if case.data == data})[::every] for data in sets}
    return [case for case in found if case.subject in keep[case.data]]


def make(work, seed, every=1):
    """The cases of a seed, made unless a kept work folder holds them."""
    made = work / "cases" / "seed"
    if not made.exists():
        broken([(work / "cases", data, seed) for data in SETS])
        made.write_text(f"{seed}\n")
    if made.read_text().strip() != str(seed):
        raise SystemExit(f"{work} holds the cases of seed {made.read_text().strip()}, not {seed}")
    return listed(work / "cases", SETS, every)


def training(work):
    """{seed: cases} to train on, made unless a kept work folder holds them."""
    roots = {seed: work / "training" / str(seed) for seed in TRAINING_SEEDS}
    made = work / "training" / "made"
    if not made.exists():
        broken([(root, data, seed) for data in SETS for seed, root in roots.items()])
        made.touch()
    return {seed: listed(root, SETS) for seed, root in roots.items()}


def phantom(job):
    """Makes a broken phantom, a case of one folder: (folder, seed)."""
    folder, seed = job
    folder.mkdir(parents=True)
    common.willis("phantom", "cerebral", "--break", "--seed", seed, "-o", folder / "fragments.swc")
    (folder / "fragments.truth.json").rename(folder / "truth.json")


def phantoms(work):
    """The folder of the phantoms to calibrate with, made unless a kept work folder holds them."""
    root = work / "training" / "phantoms"
    if not root.exists():
        common.everywhere(phantom, [(root / "cerebral" / f"cerebral-{seed}", seed) for seed in PHANTOMS])
    return root


def many_rings(work, cases):
    """More draws of the rings of the same subjects."""
    if not (work / "cases" / MANY).exists():
        broken([(work / "cases", MANY, (work / "cases" / "seed").read_text().strip())])
    subjects = {case.subject for case in cases}
    return [case for case in listed(work / "cases", DRAWS) if case.subject in subjects]


def guarded(job, item):
    """An exit would only end the worker, and its task would be waited for for ever."""
    try:
        return job(item)
    except SystemExit as end:
        raise RuntimeError(end) from None


def each(job, items):
    """`job` of each item in two processes, in order."""
    with Pool(2) as pool:
        return pool.map(partial(guarded, job), items, chunksize=1)
