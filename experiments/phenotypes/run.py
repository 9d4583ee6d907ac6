"""Which variant: run.py [--only literature|patients|damaged|cohort] [--seeds A B] [--seed N] [--work FOLDER]."""
import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import cohort
import common
import damaged
import literature
import patients
import tables
import topcow

PARTS = {"literature": literature.run, "patients": patients.run, "damaged": damaged.run, "cohort": cohort.run}

SEEDS = [(200, 220)]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=PARTS)
    parser.add_argument("--seeds", type=int, nargs=2, action="append", metavar=("A", "B"), help=f"of the phantoms' damage, from A to B - 1; may be given again {SEEDS}")
    parser.add_argument("--seed", type=int, default=101, help="of the patients' damage [101]")
    parser.add_argument("--work", type=Path, help="a folder to keep cases and answers in [a temporary one]")
    options = parser.parse_args()
    options.seeds = [tuple(pair) for pair in options.seeds or SEEDS]
    topcow.check()
    with tempfile.TemporaryDirectory(prefix="phenotypes-") as scratch:
        work = (options.work or Path(scratch)).resolve()
        for name in (options.only,) if options.only else PARTS:
            (work / name).mkdir(parents=True, exist_ok=True)
            text = PARTS[name](work / name, options)
            if text is None:
                continue
            print(text)
            if options.seeds == SEEDS and options.seed == 101:
                tables.put(name, text)
                common.made_with("phenotypes", name)


if __name__ == "__main__":
    main()
