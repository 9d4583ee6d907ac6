"""The cases of the benchmark: how they are made, where they stand, and who is held out together."""
import hashlib
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
# What weights are trained on: each is one data set of `willis train`.
SOURCES = {"brains": ("brains",), "insist": ("circles", "rings")}


class Case(namedtuple("Case", "data level name folder")):
    """One broken tracing: data set, level of damage, name, folder."""

    @property
    def subject(self):
        return self.name.rpartition("_")[0] if self.data in ("circles", MANY) else self.name

    @property
    def fold(self):
        """The fold in which the subject is held out, by the md5 of its name."""
        return int(hashlib.md5(self.subject.encode()).hexdigest(), 16) % FOLDS

    def within(self, root):
        return Path(root) / self.data / self.level / self.name


def missing():
    """What of the shared data and of Python is not there."""
    wanted = [GAPBENCH / "score.py"] + [SHARED / folder for folder, _ in SETS.values()]
    packages = [name for name in ("numpy", "scipy", "networkx", "sklearn") if find_spec(name) is None]
    return [str(path) for path in dict.fromkeys(wanted) if not path.exists()] + packages


def broken(work, seed, sets):
    """Makes the cases of some data sets."""
    jobs = [
        subprocess.Popen([sys.executable, str(GAPBENCH / "make_cases.py"), str(SHARED / folder), str(work / "cases" / data), "--seed", seed, *options], stdout=subprocess.DEVNULL)
        for data, (folder, options) in sets.items()
    ]
    if any([job.wait() for job in jobs]):
        raise SystemExit("make_cases.py failed")
    # The benchmark heads this file a,b; willis reads id_a,id_b, and the benchmark passes over the line.
    for data in sets:
        for loops in (work / "cases" / data).glob("*/*/loops.csv"):
            loops.write_text(loops.read_text().replace("a,b\n", "id_a,id_b\n", 1))


def listed(work, sets, every):
    """The cases of every n-th subject, in order."""
    found = [Case(data, level, folder.name, folder) for data in sets for level in LEVELS for folder in sorted((work / "cases" / data / level).iterdir())]
    keep = {data: sorted({case.subject for case in found if case.data == data})[::every] for data in sets}
    return [case for case in found if case.subject in keep[case.data]]


def make(work, seed, every=1):
    """The cases of a seed, made unless a kept work folder holds them."""
    made = work / "cases" / "seed"
    if not made.exists():
        broken(work, str(seed), SETS)
        made.write_text(f"{seed}\n")
    if made.read_text().strip() != str(seed):
        raise SystemExit(f"{work} holds the cases of seed {made.read_text().strip()}, not {seed}")
    return listed(work, SETS, every)


def many_rings(work, cases):
    """More draws of the rings of the same subjects."""
    if not (work / "cases" / MANY).exists():
        broken(work, (work / "cases" / "seed").read_text().strip(), DRAWS)
    subjects = {case.subject for case in cases}
    return [case for case in listed(work, DRAWS, 1) if case.subject in subjects]


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
