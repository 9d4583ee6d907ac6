"""The two commands under test: `willis train` on the other subjects, `willis infer` on those held out."""
import csv
import os
import shutil

import bench
import common


def train(work, name, cases):
    """Weights fitted on some cases; a tree of hard links holds one folder a data set."""
    weights = work / "weights" / f"{name}.toml"
    if weights.exists():
        return weights
    tree = work / "train" / name
    shutil.rmtree(tree, ignore_errors=True)
    folders = []
    for source, sets in bench.SOURCES.items():
        chosen = [case for case in cases if case.data in sets]
        for case in chosen:
            case.within(tree / source).mkdir(parents=True)
            for file in case.folder.iterdir():
                os.link(file, case.within(tree / source) / file.name)
        folders += [tree / source] if chosen else []
    weights.parent.mkdir(exist_ok=True)
    common.willis("train", *folders, "-o", weights, threads=os.cpu_count())
    return weights


def by_fold(work, cases, name="fold"):
    """Per fold the weights that were fitted without its subjects."""
    return [train(work, f"{name}-{k}", [case for case in cases if case.fold != k]) for k in range(bench.FOLDS)]


def infer(job):
    """edges.csv of one case; `job` is (case, folder with the input, --prior, folder of results, inlets are given)."""
    case, source, prior, out, inlets = job
    kept = case.within(out) / "edges.csv"
    if kept.exists():
        return kept
    arguments = ["--bc", source / "inlets.csv"] if inlets else []
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
