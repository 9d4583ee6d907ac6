"""The benchmark gapbench as a command: run.py [--seed N] [--work FOLDER] [--only main|flow|hydraulics|robust|loops|draws] [--every N]."""
import argparse
import sys
import tempfile
import time
from pathlib import Path

import bench

if bench.missing():
    print("skipped: there is no " + ", ".join(bench.missing()), file=sys.stderr)
    sys.exit()

import command
import common
import contest
import figures
import hydraulics
import questions
import tables

PARTS = ("main", "flow", "hydraulics", "robust", "loops", "draws")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=101, help="of the damage [101]")
    parser.add_argument("--work", type=Path, help="a folder to keep cases, weights and answers in, and to go on from [a temporary one]")
    parser.add_argument("--only", choices=PARTS, help="one of the parts [all]")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="every N-th subject only: a quick look that leaves results.csv and README.md alone, with --work")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="gap-bridging-") as scratch:
        work = (options.work or Path(scratch)).resolve()
        work.mkdir(parents=True, exist_ok=True)
        (work / "cases").mkdir(exist_ok=True)
        cases = bench.make(work, options.seed, options.every)
        if options.every > 1:
            tables.FOLDER = work
        bench.FOLD_OF.update(command.held_out(work))
        contest.ALL.extend(cases)
        for part in (options.only,) if options.only else PARTS:
            begun = time.monotonic()
            if part == "main":
                rows, results = contest.run(work, cases)
                figures.draw(cases, results)
            else:
                rows = (hydraulics.hydraulics if part == "hydraulics" else getattr(questions, part))(work, cases)
            tables.save(rows)
            tables.write(part)
            if options.every == 1:
                common.made_with("gap-bridging", part)
            print(f"{part}: {time.monotonic() - begun:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
