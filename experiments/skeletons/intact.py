"""How many contacts are cut in hand tracings that nobody broke, by `--cut always` and by default. intact.py DATA.

DATA holds brava and insist-cow. WILLIS names the program.
"""
import csv
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

WILLIS = os.environ.get("WILLIS", "target/release/willis")


def counts(tracing, out, cut):
    command = [WILLIS, "infer", tracing, "-o", out, "--cut", cut, "-n", "1", "--dpi", "36", "--json", "--quiet", "--force"]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["counts"]


def junctions(out):
    """How many nodes join three observed vessels or more."""
    rows = [row for row in csv.DictReader(open(out / "edges.csv", newline="")) if row["origin"] == "observed"]
    return sum(degree > 2 for degree in Counter(row[end] for row in rows for end in ("node_a", "node_b")).values())


data = Path(sys.argv[1])
print("| tracings | junctions | contacts, `always` | cut, `always` | cut, default |\n|---|---|---|---|---|")
with tempfile.TemporaryDirectory() as work:
    out = Path(work) / "out"
    for name, files in (("BraVa", data.glob("brava/vtp/*.vtp")), ("INSIST", data.glob("insist-cow/*/*.swc"))):
        total = Counter()
        for tracing in sorted(files):
            total["default"] += counts(tracing, out, "auto")["cut"]
            total["junctions"] += junctions(out)
            always = counts(tracing, out, "always")
            total += Counter(files=1, contacts=always["contacts"], cut=always["cut"])
        print(f"| {name}, {total['files']} | {total['junctions']} | {total['contacts']} | {total['cut']} | {total['default']} |")
