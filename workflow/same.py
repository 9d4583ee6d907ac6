"""Whether the workflow's output (second argument) is that of a cohort of willis infer (first argument), byte for byte."""

import csv
import json
import re
import sys
from pathlib import Path

TIMESTAMP = ".snakemake_timestamp"


def files(folder):
    """The bytes of every file by name, run.json without its times."""
    found = {path.name: path.read_bytes() for path in folder.iterdir() if path.name != TIMESTAMP}
    record = json.loads(found["run.json"])
    del record["time"]
    return found | {"run.json": record}


def rows(folder):
    """The table of a cohort without its times, by subject."""
    with open(folder / "cohort.csv", newline="") as table:
        return {row["subject"]: {name: row[name] for name in row if name != "wall_s"} for row in csv.DictReader(table)}


whole, made = map(Path, sys.argv[1:])
expected = rows(whole)
assert rows(made / "cohort") == expected, (rows(made / "cohort"), expected)
assert sorted(row["status"] for row in expected.values()) == ["failed", "ok", "ok"]
for subject, row in expected.items():
    run = made / "runs" / subject
    if row["status"] == "failed":
        assert {path.name for path in run.iterdir()} - {TIMESTAMP} == {"failed.json"}
        continue
    one, other = files(whole / subject), files(run)
    assert one.keys() == other.keys(), one.keys() ^ other.keys()
    differing = [name for name in one if one[name] != other[name]]
    assert not differing, f"{run}: {differing} differ"
page = (made / "cohort" / "cohort.html").read_text()
links = [link for link in json.loads(re.search(r'"pages":(\[.*?\])', page)[1]) if link]
assert len(links) == 2 and all((made / "cohort" / link).is_file() for link in links), links
print(f"{made}: {len(expected)} subjects, the bytes of willis infer")
