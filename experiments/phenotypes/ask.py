"""The commands under test, and what they answer."""
import json
import shutil
from pathlib import Path

import common

RING = ("L-A1", "R-A1", "AComm", "L-P1", "R-P1", "L-PComm", "R-PComm")


def answer(source, landmarks, out, extra=(), prior=()):
    """phenotype.json after infer and classify, and that of the median topology."""
    scratch = out.with_suffix(".run")
    loops = source.with_suffix(".loops.csv") if not extra else None
    extra = list(extra) + (["--loops", loops] if loops and loops.exists() else [])
    common.willis("infer", source, "-o", scratch, "--landmarks", landmarks, *extra, *prior, "--dpi", 72)
    folder = out.with_suffix(".classified")
    common.willis("classify", scratch, "-o", folder, "--landmarks", landmarks)
    found = json.loads((folder / "phenotype.json").read_text())
    # The same question asked of the folder again gives the same answer.
    assert found["probabilities"] == json.loads((scratch / "phenotype.json").read_text())["probabilities"]
    median = fixed(scratch / "topology-median.graphml", landmarks, out.with_suffix(".median"))
    shutil.rmtree(scratch)
    shutil.rmtree(folder)
    return found, median


def fixed(network, landmarks, folder, extra=()):
    """The segments of a topology taken as it stands."""
    common.willis("classify", network, "-o", folder, "--landmarks", landmarks, *extra)
    found = json.loads((folder / "phenotype.json").read_text())
    shutil.rmtree(folder)
    return found["segments"]


def missing(segments):
    """The segments of the ring that are not there."""
    return tuple(name for name in RING if not segments[name])


def with_third(found):
    """The segments of an answer, with the third A2."""
    return {**found["segments"], "3rd-A2": found["anterior"]["3rd-A2"]}
