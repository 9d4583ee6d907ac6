"""`willis label` of every case by the model that never saw its patient: answer.py CASES ANSWERS MODELS [--levels ...] [--every N]; MODELS holds arteries.fold-K.toml."""
import argparse
import json
import sys
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import common


def models(folder):
    """{subject: the model that it was held out of}."""
    out = {}
    for path in sorted(Path(folder).glob("arteries.fold-*.toml")):
        out |= dict.fromkeys(tomllib.loads(path.read_text())["provenance"]["held_out"], path)
    return out


def label(source, out, model=None, extra=()):
    """Names the arteries of a file; the tables stand beside `out`, a .graphml."""
    loops = source.parent / "loops.csv"
    extra = [*extra, *(["--loops", loops] if loops.exists() else []), *(["--model", model] if model else [])]
    common.willis("label", source, "-o", out, *extra)


def answer(folder, out, folds, levels=None, every=1, extra=()):
    """Answers to the cases of a folder that are not there yet, two at a time."""
    out.mkdir(parents=True, exist_ok=True)
    of = models(folds)
    if not of:
        raise SystemExit(f"{folds}: no arteries.fold-K.toml; make them by willis train --model labels --folds 26 --save-folds")
    listed = [case for case in sorted(folder.iterdir()) if (case / "truth.json").exists() and (levels is None or case.name.split("-")[1] in levels)]

    def one(case):
        to = out / f"{case.name}.graphml"
        if not (out / f"{case.name}.names.csv").exists():
            label(case / "fragments.swc", to, of[json.loads((case / "truth.json").read_text())["subject"]], extra)

    common.everywhere(one, listed[::every])
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", type=Path)
    parser.add_argument("answers", type=Path)
    parser.add_argument("models", type=Path)
    parser.add_argument("--levels", type=lambda text: text.split(","))
    parser.add_argument("--every", type=int, default=1, help="only every n-th case [1]")
    options = parser.parse_args()
    answer(options.cases, options.answers, options.models, options.levels, options.every)


if __name__ == "__main__":
    main()
