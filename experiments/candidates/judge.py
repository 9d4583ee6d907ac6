"""Rows of results.csv for one rule: python judge.py CASES RESULTS RULE, with the benchmark's score.py on the path.

Only the ceiling is asked for: which true links have a candidate. `tuned` are the twelve brains on which the rules were chosen.
"""
import csv
import json
import pathlib
import sys

import score

TUNED = 12


def links_found(case, rows):
    """How many true links some candidate makes, as score.score counts them."""
    union, found = {}, 0
    for row in rows:
        a, b = ([float(row[side + axis + "_mm"]) for axis in "xyz"] for side in "ab")
        match = case.match(a, b)
        if match:
            found += union.setdefault(match[0], score.Union(16)).join(match[1], match[2])
    return found


def main():
    cases, results, rule = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3]
    for level in sorted(cases.glob("*/*")):
        folders = sorted(level.iterdir())
        parts = [(level.parent.name, folders)]
        if level.parent.name == "brava":
            parts = [("brava tuned", folders[:TUNED]), ("brava others", folders[TUNED:])]
        for name, part in parts:
            links = found = candidates = 0
            for folder in part:
                case = score.Case(json.loads((folder / "truth.json").read_text()))
                with open(results / folder.relative_to(cases) / "edges.csv") as file:
                    rows = list(csv.DictReader(file))
                links, found, candidates = links + case.n_links, found + links_found(case, rows), candidates + len(rows)
            print(name, level.name, len(part), rule, links, found, "%.4f" % (found / links), "%.0f" % (candidates / len(part)), sep=",")


if __name__ == "__main__":
    main()
