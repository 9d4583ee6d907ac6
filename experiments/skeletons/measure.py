"""Scores answers of willis on held-out subjects by skelbench, with vessels cut apart at contacts and without.

    python measure.py SKELBENCH CASES JOINS CONTACTS LEVELS [N]

CASES/<level>/<subject> are those of weights.sh, JOINS and CONTACTS the beginnings of the models of folds (final:
final.fold-1.toml and so on). Of each fold N subjects are taken, or all. Writes a table of means to standard output, and the paired
difference of path to the same joins uncut, with the 95 % interval by drawing subjects 2,000 times.
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import tomllib

import numpy as np

sys.path.insert(0, sys.argv[1])
import score

WILLIS = os.environ.get("WILLIS", "target/release/willis")
FIGURES = ("path", "nrun", "cut_recall", "cut_wrong", "lost_connections", "through_kept", "cycles", "join_f1")
# What is read, what is cut, how the rows are called.
WAYS = (
    ("mask.nii.gz", "never", "mask, nothing cut"),
    ("mask.nii.gz", "contacts", "mask, cut (default)"),
    ("fragments.npz", "never", "fragments, nothing cut"),
    ("fragments.npz", "contacts", "fragments, cut by the skeleton alone"),
)


def answer(source, joins, cut, folder):
    command = [WILLIS, "infer", source, "-o", folder, "--prior", joins, "--cut", cut, "-n", "1", "--force", "--quiet"]
    subprocess.run(command, check=True)
    return folder


def interval(values):
    values, rng = np.asarray(values), np.random.default_rng(0)
    means = values[rng.integers(len(values), size=(2000, len(values)))].mean(1)
    return "%+.3f [%+.3f, %+.3f]" % (values.mean(), *np.percentile(means, [2.5, 97.5]))


cases, joins, contacts = (pathlib.Path(path) for path in sys.argv[2:5])
most = int(sys.argv[6]) if len(sys.argv) > 6 else None
print("| level | cases | answer | " + " | ".join(FIGURES) + " | path less uncut |")
print("|---" * (len(FIGURES) + 4) + "|")
with tempfile.TemporaryDirectory() as work:
    for level in sys.argv[5].split(","):
        found = {name: [] for _, _, name in WAYS}
        for model in sorted(joins.parent.glob(joins.name + ".fold-*.toml")):
            held = tomllib.loads(model.read_text())["provenance"]["held_out"]
            cut_model = contacts.with_name(model.name.replace(joins.name, contacts.name, 1))
            for subject in [s for s in held if (cases / level / s).exists()][:most]:
                folder = cases / level / subject
                for source, cut, name in WAYS:
                    truth = score.Case(folder)
                    out = answer(folder / source, model, "never" if cut == "never" else cut_model, pathlib.Path(work) / "out")
                    lines, rows = score.read_answer(out, truth)
                    found[name].append(score.score(truth, lines, rows))
        for at, (_, _, name) in enumerate(WAYS):
            means = [np.nanmean([r[k] if r[k] is not None else np.nan for r in found[name]]) for k in FIGURES]
            less = ""
            if at % 2:
                less = interval([a["path"] - b["path"] for a, b in zip(found[name], found[WAYS[at - 1][2]])])
            print(f"| {level} | {len(found[name])} | {name} | " + " | ".join("%.4g" % m for m in means) + f" | {less} |", flush=True)
