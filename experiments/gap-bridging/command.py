"""The two commands under test: `willis train` on draws of its own, `willis infer` on subjects that the weights have not seen."""
import csv
import os
import shutil
import tomllib

import bench
import common

# Of the weights that ship.
WHOLE = "weights"


def train(work, name, which=lambda case: True, folds=bench.FOLDS):
    """Weights fitted on the training draws, or on some of their cases, and those of each fold beside them."""
    weights = work / "weights" / f"{name}.toml"
    if weights.exists():
        return weights
    tree = work / "train" / name
    shutil.rmtree(tree, ignore_errors=True)
    sources = {data: source for source, sets in bench.SOURCES.items() for data in sets}
    chosen = [(case, seed) for seed, cases in bench.training(work).items() for case in cases if which(case)]
    for case, seed in chosen:
        source = sources[case.data]
        folder = tree / source / (case.data if case.data != source else "") / case.level / f"{case.name}-{seed}"
        folder.mkdir(parents=True)
        for file in case.folder.iterdir():
            os.link(file, folder / file.name)
    weights.parent.mkdir(exist_ok=True)
    # From within the tree, for the weights say by what command they were made.
    found = dict.fromkeys(sources[case.data] for case, _ in chosen)
    phantoms = tree / "phantoms"
    if not phantoms.exists():
        phantoms.symlink_to(bench.phantoms(work))
    common.willis("train", *found, "--calibrate-with", phantoms.name, "-o", weights, "--folds", folds, *(["--save-folds"] if folds else []), threads=os.cpu_count(), folder=tree)
    return weights


def by_fold(work, name=WHOLE, which=lambda case: True):
    """Per fold the weights that were fitted without its subjects."""
    weights = train(work, name, which)
    return [weights.with_suffix(f".fold-{k}.toml") for k in range(1, bench.FOLDS + 1)]


def held_out(work):
    """{subject: its fold}, as the weights of the folds say."""
    out = {}
    for k, weights in enumerate(by_fold(work)):
        out |= dict.fromkeys(tomllib.loads(weights.read_text())["provenance"]["held_out"], k)
    return out


def infer(job):
    """edges.csv of one case; `job` is (case, folder with the input, --prior, folder of results, inlets are given)."""
    case, source, prior, out, inlets = job
    kept = case.within(out) / "edges.csv"
    if kept.exists():
        return kept
    arguments = ["--bc", source / "conditions.csv"] if inlets else []
    arguments += ["--loops", source / "loops.csv"] if (source / "loops.csv").exists() else []
    scratch = case.within(out).with_suffix(".scratch")
    common.willis("infer", source / "fragments.swc", "-o", scratch, *arguments, "--prior", prior, "--dpi", 72)
    kept.parent.mkdir(parents=True, exist_ok=True)
    os.replace(scratch / "edges.csv", kept)
    shutil.rmtree(scratch)
    return kept


def candidates(path):
    """The candidate rows of an edges.csv."""
    with open(path, newline="") as file:
        return [row for row in csv.DictReader(file) if row["origin"] == "candidate"]
