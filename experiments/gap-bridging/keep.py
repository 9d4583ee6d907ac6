"""How many connections each rule of `--keep` makes, and how many of them are right: keep.py [--seed N] [--work FOLDER].

Brains and circles of a draw of the damage, and the brains undamaged, each by the weights of the fold that held its subject out, fitted to other draws. Needs what run.sh needs;
WILLIS names another willis to try, such as an earlier version."""
import argparse
import csv
import json
import shutil
import sys
import tempfile
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent.parent), str(Path(__file__).resolve().parent)]
import bench
import command
import common
import numpy as np

sys.path.append(str(bench.GAPBENCH))
import score

README = Path(__file__).resolve().parent / "README.md"
RULES = ("probable=3", "probable", "probable=0.6", "probable=0.3")
FIGURES = ("precision", "recall", "f1", "path_after", "fed_spurious", "phenotype_exact", "absent_kept_absent")


def kept(job):
    """edges.csv and run.json of a file by a rule, kept in the work folder."""
    source, rule, out, options = job
    if not (out / "edges.csv").exists():
        scratch = out.with_suffix(".scratch")
        common.willis("infer", source, "-o", scratch, *options, "--keep", rule, "-n", 8, "--dpi", 36)
        out.mkdir(parents=True, exist_ok=True)
        for name in ("edges.csv", "run.json"):
            shutil.move(scratch / name, out / name)
        shutil.rmtree(scratch)
    with open(out / "edges.csv", newline="") as file:
        return list(csv.DictReader(file)), json.loads((out / "run.json").read_text())


def damaged(work, seed):
    folds, held_out = command.by_fold(work), command.held_out(work)
    cases = [case for case in bench.make(work, seed) if case.data in ("brains", "circles")]
    lines = []
    for data in ("brains", "circles"):
        for level in bench.LEVELS:
            own = [case for case in cases if (case.data, case.level) == (data, level)]
            for rule in RULES:
                prior = lambda case: ["--prior", folds[held_out[case.subject]]]
                loops = lambda case: ["--loops", case.folder / "loops.csv"] if (case.folder / "loops.csv").exists() else []
                jobs = [(case.folder / "fragments.swc", rule, case.within(work / "keep" / rule), ["--bc", case.folder / "conditions.csv", *prior(case), *loops(case)]) for case in own]
                answers = [rows for rows, _ in common.everywhere(kept, jobs)]
                found = [score.score(json.loads((case.folder / "truth.json").read_text()), rows) for case, rows in zip(own, answers)]
                count = np.mean([sum(row["origin"] == "candidate" and row["kept"] == "1" for row in rows) for rows in answers])
                means = [np.nanmean([one.get(name, np.nan) for one in found]) if any(name in one for one in found) else np.nan for name in FIGURES]
                lines.append([f"{data}, {level} ({len(own)})", f"`{rule}`", f"{count:.1f}", *("" if np.isnan(x) else f"{x:.3f}" for x in means)])
    return common.table(["cases", "`--keep`", "bridges kept", "precision", "recall", "F1", "path", "false length fed", "exact", "absent"], lines)


def undamaged(work):
    folds, held_out = command.by_fold(work), command.held_out(work)
    files = sorted((bench.SHARED / "brava" / "vtp").glob("*.vtp"))
    subject = lambda file: file.name.partition("_")[0]
    lines = []
    for rule in RULES:
        runs = [run for _, run in common.everywhere(kept, [(file, rule, work / "undamaged" / rule / file.stem, ["--prior", folds[held_out[subject(file)]]]) for file in files])]
        lines.append([f"`{rule}`", len(files), sum(run["counts"]["topology"]["kept_candidates"] for run in runs), f"{sum(run['expected_errors']['wrong'] for run in runs):.1f}", sum(run["convergence"]["undecided"] for run in runs)])
    return common.table(["`--keep`", "undamaged brains", "bridges kept", "of these expected to be wrong", "undecided"], lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=101, help="of the damage [101]")
    parser.add_argument("--work", type=Path, help="a folder to keep cases and answers in [a temporary one]")
    options = parser.parse_args()
    # The methods of others, which are not asked here, are what needs scikit-learn.
    missing = [name for name in bench.missing() if name != "sklearn"]
    if missing:
        print("skipped: there is no " + ", ".join(missing))
        return
    with tempfile.TemporaryDirectory(prefix="keep-") as scratch:
        work = (options.work or Path(scratch)).resolve()
        text = damaged(work, options.seed) + "\n\n" + undamaged(work)
    print(text)
    common.splice(README, "keep", text)
    common.made_with("gap-bridging", "keep")


if __name__ == "__main__":
    main()
