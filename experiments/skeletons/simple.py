"""Two simple answers to fragments: as they are, and each cycle cut at its thinnest vessel. simple.py CASES AS_IS THINNEST LEVELS...

CASES/<level> has folders with fragments.npz; the answers get the same names. A vessel is a run between nodes of other than two neighbours, as wide as its points
are on average; a cut leaves out the link at its thinnest point.
"""
import sys
from pathlib import Path

import networkx as nx
import numpy as np


def vessels(graph):
    """Runs of points."""
    seen = set()
    for start in (node for node in graph if graph.degree(node) != 2):
        for after in graph[start]:
            if frozenset((start, after)) in seen:
                continue
            run = [start, after]
            while graph.degree(run[-1]) == 2:
                run.append(next(node for node in graph[run[-1]] if node != run[-2]))
            seen.update((frozenset(run[:2]), frozenset(run[-2:])))
            yield run


cases, as_is, thinnest = map(Path, sys.argv[1:4])
for file in sorted(file for level in sys.argv[4:] for file in (cases / level).glob("*/fragments.npz")):
    case, lines = file.parent.relative_to(cases), np.load(file)
    graph, radii = nx.Graph(lines["edges"].tolist()), lines["radii"]
    runs = sorted(vessels(graph), key=lambda run: -radii[run].mean())
    parts = nx.utils.UnionFind(graph)
    for run in runs:
        if parts[run[0]] == parts[run[-1]]:
            thin = min(range(1, len(run)), key=lambda at: radii[run[at - 1]] + radii[run[at]])
            graph.remove_edge(run[thin - 1], run[thin])
        parts.union(run[0], run[-1])
    for folder, edges in ((as_is, lines["edges"]), (thinnest, np.array(graph.edges))):
        (folder / case.parent).mkdir(parents=True, exist_ok=True)
        np.savez(folder / f"{case}.npz", coords=lines["coords"], radii=radii, edges=edges)
