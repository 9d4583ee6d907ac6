# The subjects with their inputs.
from collections import Counter
from glob import glob
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

min_version("9.0")

OUT = config["output"]
# What stands before and after the input.
INFER = [f"{config['willis']} infer", f"-n {config['samples']} {config['options']}"]


def stem_of(path):
    """The name of a file without its ending, of which .nii.gz is one."""
    bare = Path(path).stem
    return Path(bare).stem if path.lower().endswith(".gz") else bare


def subjects(patterns):
    """The input of every subject by its name, which is what willis infer calls it in a cohort of the same inputs."""
    found = [
        path
        for pattern in ([patterns] if isinstance(patterns, str) else patterns)
        for path in sorted(glob(pattern, recursive=True), key=lambda path: path.split("/"))
        if Path(path).is_file()
    ]
    found = list(dict.fromkeys(found))
    if not found:
        raise WorkflowError(f"inputs {patterns!r}: matches no file; set inputs to a pattern of centerline files")
    for path in found:
        if "{" in path and "}" in path:
            raise WorkflowError(f"{path}: to Snakemake what stands in braces is a wildcard; rename it, or run willis infer on the pattern itself")
    times = Counter(stem_of(path).lower() for path in found)
    named = {}
    for path in found:
        stem, folder = stem_of(path), Path(path).parent.name
        shared = times[stem.lower()]
        if shared > 1 and folder:
            stem = folder if shared == len(found) else f"{folder}-{stem}"
        plain = "".join(c if c.isalnum() or c in "-_." else "_" for c in stem[:80]).strip(".") or "subject"
        taken = [name.lower() for name in named]
        name, number = plain, 1
        while name.lower() in taken:
            number += 1
            name = f"{plain}-{number}"
        named[name] = path
    return named


SUBJECTS = subjects(config["inputs"])


wildcard_constraints:
    subject="[^/]+",


def input_of(wildcards):
    return SUBJECTS[wildcards.subject]
