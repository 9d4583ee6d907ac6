"""Names of arteries: run.py [--only PART ...] [--seed N] [--work FOLDER] [--models FOLDER] [--model FILE]."""
import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import brava
import cases
import common
import drawn
import patients
import topcow

README = Path(__file__).resolve().parent / "README.md"
OTHER_DRAW = 2
PARTS = {"patients": patients.patients, "draws": patients.draws, "frames": patients.frames, "unseen": patients.unseen, "brava": brava.run, "topcow": topcow.run, "drawn": drawn.run}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=PARTS, nargs="+", default=list(PARTS))
    parser.add_argument("--seed", type=int, default=OTHER_DRAW, help=f"of the other draw of damage [{OTHER_DRAW}]")
    parser.add_argument("--work", type=Path, help="a folder to keep cases, models and answers in [a temporary one]")
    parser.add_argument("--models", type=Path, help="a folder with arteries.toml and arteries.fold-K.toml instead of training them")
    parser.add_argument("--model", type=Path, help="what names brains and masks [the weights that ship]")
    options = parser.parse_args()
    options.models, options.model = (path and path.resolve() for path in (options.models, options.model))
    if cases.missing():
        print("skipped: there is no " + ", ".join(cases.missing()))
        return
    with tempfile.TemporaryDirectory(prefix="labels-") as scratch:
        work = (options.work or Path(scratch)).resolve()
        for name in options.only:
            part = work / name if name in ("brava", "topcow", "drawn") else work
            part.mkdir(parents=True, exist_ok=True)
            text = PARTS[name](part, options)
            if text is not None:
                print(text + "\n", flush=True)
                if options.seed == OTHER_DRAW:
                    common.splice(README, name, text)
                    common.made_with("labels", name)


if __name__ == "__main__":
    main()
