"""The commands under test, and what they answer."""
import json
import os
import shutil
import tomllib
from pathlib import Path

import common

RING = ("L-A1", "R-A1", "AComm", "L-P1", "R-P1", "L-PComm", "R-PComm")


def phenotype(folder):
    return json.loads((folder / "phenotype.json").read_text())


def answer(source, landmarks, out, extra=(), prior=()):
    """phenotype.json after infer and classify, and that of the median topology."""
    scratch = out.with_suffix(".run")
    loops = source.with_suffix(".loops.csv") if not extra else None
    extra = list(extra) + (["--loops", loops] if loops and loops.exists() else [])
    common.willis("infer", source, "-o", scratch, "--landmarks", landmarks, *extra, *prior, "--dpi", 72)
    folder = out.with_suffix(".classified")
    common.willis("classify", scratch, "-o", folder, "--landmarks", landmarks)
    found = phenotype(folder)
    # The same question asked of the folder again gives the same answer.
    assert found["probabilities"] == phenotype(scratch)["probabilities"]
    median = fixed(scratch / "topology-median.graphml", landmarks, out.with_suffix(".median"))
    shutil.rmtree(scratch)
    shutil.rmtree(folder)
    return found, median


# What stands for an answer where classify says that no arteries could be named.
REFUSED = {"variant": "refused", "segments": dict.fromkeys(RING), "anterior": {"3rd-A2": False}, "probabilities": {"segments": {}, "variant": 0.0}}


def alone(source, out, extra=(), keep=()):
    """phenotype.json after infer and classify that got nothing but the file, and the files `keep` of the run beside `out`."""
    scratch, folder = out.with_suffix(".run"), out.with_suffix(".classified")
    loops = [path for path in (source.with_suffix(".loops.csv"), source.with_name("loops.csv")) if path.exists()]
    common.willis("infer", source, "-o", scratch, *(["--loops", loops[0]] if loops else []), *extra, "--dpi", 72)
    for name in keep:
        os.replace(scratch / name, out.with_name(f"{out.name}.{name}"))
    common.willis("classify", scratch, "-o", folder)
    found = phenotype(folder)
    shutil.rmtree(scratch)
    shutil.rmtree(folder)
    return found


def fixed(network, landmarks, folder, extra=()):
    """The segments of a topology taken as it stands."""
    common.willis("classify", network, "-o", folder, "--landmarks", landmarks, *extra)
    found = phenotype(folder)
    shutil.rmtree(folder)
    return found["segments"]


def missing(segments):
    """The segments of the ring that are not there."""
    return tuple(name for name in RING if not segments[name])


def with_third(found):
    """The segments of an answer, with the third A2."""
    return {**found["segments"], "3rd-A2": found["anterior"]["3rd-A2"]}


def unseeing(subject, variable, pattern):
    """The fitted file that has not seen the subject, of those in the folder that an environment variable names; None without it."""
    folder = os.environ.get(variable)
    for path in sorted(Path(folder).glob(pattern)) if folder else []:
        if subject in tomllib.loads(path.read_text())["provenance"]["held_out"]:
            return path
    return None


def folds(subject):
    """Options by which a subject's own tracing has no part in the answer: joins (WILLIS_FOLD_WEIGHTS) and names (WILLIS_FOLD_ARTERIES)."""
    weights, arteries = unseeing(subject, "WILLIS_FOLD_WEIGHTS", "weights.fold-*.toml"), unseeing(subject, "WILLIS_FOLD_ARTERIES", "arteries.fold-*.toml")
    return (["--prior", weights] if weights else []) + (["--arteries", arteries] if arteries else [])
