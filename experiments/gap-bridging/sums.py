"""How far the P of candidates between the same two fragments add up: sums.py [--work FOLDER] writes sums.md, the table on the page Theory of the book
("What each P means"). The environment is that of run.sh, and so is the folder, where one is kept."""
import argparse
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from xml.etree import ElementTree

import bench
import common

HERE = Path(__file__).resolve().parent
XML = "{http://graphml.graphdrawing.org/xmlns}"


def candidates(file, folder):
    """The number of fragments, and of each candidate between two: these, and P."""
    out = Path(folder) / "graph.graphml"
    subprocess.run([common.WILLIS, "candidates", file, "-o", out, "--force", "--quiet"], check=True)
    graph = ElementTree.parse(out).getroot()
    names = {key.get("id"): key.get("attr.name") for key in graph.iter(XML + "key")}
    row = {node.get("id"): number for number, node in enumerate(graph.iter(XML + "node"))}
    part = list(range(len(row)))

    def fragment(node):
        while part[node] != node:
            part[node] = node = part[part[node]]
        return node

    vessels = []
    for edge in graph.iter(XML + "edge"):
        values = {names[data.get("key")]: data.text for data in edge.iter(XML + "data")}
        vessels.append((row[edge.get("source")], row[edge.get("target")], values))
    for a, b, values in vessels:
        if values["origin"] == "observed":
            part[fragment(a)] = fragment(b)
    found = [
        (fragment(a), fragment(b), float(values.get("probability", 0)))
        for a, b, values in vessels
        if values["origin"] == "candidate" and fragment(a) != fragment(b)
    ]
    return len({fragment(node) for node in range(len(row))}), found


def row(name, files):
    """A row of the table."""
    of_p, above, above_largest = [], 0, 0
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            fragments, found = candidates(file, folder)
            p = defaultdict(list)
            for a, b, probability in found:
                p[min(a, b), max(a, b)].append(probability)
            of_p += [sum(each) for each in p.values()]
            above += sum(map(sum, p.values())) > fragments - 1
            above_largest += sum(map(max, p.values())) > fragments - 1
    beyond = f"{sum(x > 1 + 1e-9 for x in of_p):,} of {len(of_p):,}; {max(of_p, default=0):.2f}"
    return [f"{name}, {len(files)}", beyond, above, above_largest]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=101, help="of the damage [101]")
    parser.add_argument("--work", type=Path, help="a folder to keep cases in [a temporary one]")
    options = parser.parse_args()
    if bench.missing():
        sys.exit("skipped: there is no " + ", ".join(bench.missing()))
    with tempfile.TemporaryDirectory(prefix="sums-") as scratch:
        work = (options.work or Path(scratch)).resolve()
        (work / "cases").mkdir(parents=True, exist_ok=True)
        broken = [case.folder / "fragments.swc" for case in bench.make(work, options.seed) if (case.data, case.level) == ("brains", "medium")]
        whole = sorted((bench.SHARED / "insist-cow").glob("INSIST_*/tracing*.swc"))
        rows = [row("tracings of INSIST", whole), row("of BraVa, broken by gapbench at level medium", broken)]
    heading = ["brains", "pairs of fragments with Σ P above 1; the most", "brains with Σ P above fragments − 1", "the same of the largest P of each pair"]
    (HERE / "sums.md").write_text(common.table(heading, rows) + "\n")
    common.made_with("gap-bridging", "sums")


if __name__ == "__main__":
    main()
