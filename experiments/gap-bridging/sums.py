"""How far the P of candidates between the same two fragments add up: sums.py NAME FILE... prints a row of the table on the page Theory of the book
("What each P means"). WILLIS names the program; needs nothing but Python."""
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parent.parent.parent
WILLIS = os.environ.get("WILLIS", str(ROOT / "target/release/willis"))
XML = "{http://graphml.graphdrawing.org/xmlns}"


def candidates(file, folder):
    """The number of fragments, and of each candidate between two: these, P, and how probably the fragment at either end hangs there."""
    out = Path(folder) / "graph.graphml"
    subprocess.run([WILLIS, "candidates", file, "-o", out, "--force", "--quiet"], check=True)
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


def main():
    name, *files = sys.argv[1:]
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
    most = lambda sums: f"{sum(x > 1 + 1e-9 for x in sums):,} of {len(sums):,}; {max(sums, default=0):.2f}"
    print(f"| {name}, {len(files)} | {most(of_p)} | {above} | {above_largest} |")


if __name__ == "__main__":
    main()
