"""Why gaps stay open and fusions stay fused in the answers of measure.py, one cause each; the table of causes in README.md.

    causes.py SKELBENCH DATA WORK [--masks 005,006,007,008,009] [--seeds 1,2]

WORK is the folder that run.sh kept. A fusion that is left has a way from one vessel to the other inside its ball. Either a contact on that way was cut
and given back, or none is on it: then all of it was judged one vessel. It is on a loop where the two vessels stay connected, by observed vessels, contacts and
kept candidates, with its middle (or the contacts around it) taken out.
"""
import argparse
import collections
import csv
import json
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import nibabel
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

NAMESPACE = "{http://graphml.graphdrawing.org/xmlns}"
#: A fusion is parted by taking out what lies so near its middle, or the contacts so near, mm; an end of a gap is followed so far, mm.
MIDDLE, AROUND, FOLLOWED = 1.2, 3.5, 6.0
USUAL = 0.4


def rows_of(folder):
    """The vessels of the over-connected graph with their points, origin, probability and whether they are kept."""
    kept = {row["edge"]: row["kept"] == "1" for row in csv.DictReader((folder / "edges.csv").open())}
    root = ElementTree.parse(folder / "candidates.graphml").getroot()
    names = {key.get("id"): key.get("attr.name") for key in root.iter(NAMESPACE + "key")}
    data = lambda element: {names[d.get("key")]: d.text or "" for d in element.iter(NAMESPACE + "data")}
    places = {node.get("id"): [float(data(node)[k]) for k in ("x_mm", "y_mm", "z_mm")] for node in root.iter(NAMESPACE + "node")}
    for edge in root.iter(NAMESPACE + "edge"):
        found, ends = data(edge), [edge.get("source"), edge.get("target")]
        points = [[float(x) for x in point.split()[:3]] for point in found.get("points", "").split(";") if point.strip()]
        if points and np.linalg.norm(np.subtract(points[0], places[ends[0]])) > np.linalg.norm(np.subtract(points[-1], places[ends[0]])):
            points.reverse()
        yield dict(points=np.array([places[ends[0]], *points, places[ends[1]]]), ends=ends, origin=found["origin"], p=float(found.get("probability") or 0),
                   attached=float(found.get("hangs_a") or 0) + float(found.get("hangs_b") or 0), kept=kept.get(found["edge"], False))


class Graph:
    """Vessels as points half a voxel apart; each step knows its vessel."""

    def __init__(self, rows, voxel):
        places, node, self.steps, self.of, self.mm = [], {}, [], [], []
        for number, row in enumerate(rows):
            along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(row["points"], axis=0), axis=1))]
            count = max(1, int(np.ceil(along[-1] / (voxel / 2))))
            points = np.stack([np.interp(np.linspace(0, along[-1], count + 1), along, row["points"][:, k]) for k in range(3)], 1)
            key = lambda n: row["ends"][0] if n == 0 else row["ends"][1] if n == count else (number, n)
            ids = [node.setdefault(key(n), len(node)) for n in range(count + 1)]
            places += [(i, point) for i, point in zip(ids, points)]
            self.steps += zip(ids[:-1], ids[1:])
            self.of += [number] * count
            self.mm += [along[-1] / count + 1e-9] * count
        self.xyz = np.zeros((len(node), 3))
        for i, point in places:
            self.xyz[i] = point
        self.steps, self.of, self.mm = np.array(self.steps), np.array(self.of), np.array(self.mm)
        self.kd, self.next = cKDTree(self.xyz), collections.defaultdict(list)
        for (a, b), number in zip(self.steps.tolist(), self.of.tolist()):
            self.next[a].append((b, number))
            self.next[b].append((a, number))

    def matrix(self, used):
        return coo_matrix((self.mm[used], tuple(self.steps[used].T)), shape=(len(self.xyz),) * 2).tocsr()

    def connected(self, used, a, b):
        part = connected_components(self.matrix(used), directed=False)[1]
        return part[a] == part[b]


def way(graph, kept, fusion, voxel):
    """The steps (point, vessel) of a kept way between the two vessels inside the ball; `False` where there is none, `None` where a vessel is not shown."""
    inside = {x for x in graph.kd.query_ball_point(fusion["place"], fusion["reach"]) if any(kept[number] for _, number in graph.next[x])}
    sides = [{y for x in side for y in graph.kd.query_ball_point(x, 2 * voxel)} & inside for side in fusion["sides"]]
    if not all(sides) or sides[0] & sides[1]:
        return None
    before, todo = {x: None for x in sides[0]}, collections.deque(sorted(sides[0]))
    while todo:
        x = todo.popleft()
        if x in sides[1]:
            steps = [(x, None)]
            while before[x]:
                x, number = before[x]
                steps.append((x, number))
            return steps
        for y, number in graph.next[x]:
            if kept[number] and y in inside and y not in before:
                before[y] = (x, number)
                todo.append(y)
    return False


def cause_of_fusion(graph, rows, kept, fusion, voxel):
    steps = way(graph, kept, fusion, voxel)
    if not steps:
        return None if steps is None else "undone"
    contacts = [number for _, number in steps if number is not None and rows[number]["origin"] == "contact"]
    if contacts:
        near = {number for x in graph.kd.query_ball_point(fusion["place"], min(fusion["reach"], AROUND)) for _, number in graph.next[x]}
        gone = {number for number in near | set(contacts) if rows[number]["origin"] == "contact"}
        course = graph.steps[graph.of == min(contacts, key=lambda number: rows[number]["p"])]
        loop = graph.connected(~np.isin(graph.of, sorted(gone)), course[0, 0], course[-1, 1])
        return "left, contact given back, " + ("loop opened elsewhere" if loop else "only way")
    middle = [x for x, _ in steps[1:-1] if np.linalg.norm(graph.xyz[x] - fusion["place"]) < MIDDLE] or [steps[len(steps) // 2][0]]
    loop = graph.connected(~np.isin(graph.steps, middle).any(1), steps[0][0], steps[-1][0])
    return "left, judged one vessel, " + ("loop opened elsewhere" if loop else "only way")


def cause_of_gap(graph, observed, rows, kept, gap, voxel):
    near = lambda kd, x: kd.query_ball_point(x, 3 * voxel)
    a, b = [near(graph.kd, gap[k]) or [int(graph.kd.query(gap[k])[1])] for k in "ab"]
    if np.isfinite(dijkstra(graph.matrix(kept[graph.of]), directed=False, indices=a, limit=1.5 * gap["mm"] + 4)[:, b]).any():
        return "closed"
    sides = []
    for k in "ab":
        from_here = near(observed.kd, gap[k])
        if not from_here:
            return "open, an end of it is not in the skeleton"
        reached = np.isfinite(dijkstra(observed.matrix(slice(None)), directed=False, indices=from_here, limit=FOLLOWED)).any(0)
        sides.append(cKDTree(observed.xyz[reached]))
    between = [row for row in rows if row["origin"] == "candidate" and any(
        max(sides[0].query(row["points"][i])[0], sides[1].query(row["points"][-1 - i])[0]) < voxel for i in (0, -1))]
    if not between:
        return "open, no candidate"
    best = max(between, key=lambda row: row["p"])
    if best["kept"]:
        return "open, joined by a longer way"
    return "open, candidate of P " + ("%.1f or more, not kept" % USUAL if best["p"] >= USUAL else "below %.1f" % USUAL)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bench", "data", "work"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--masks", default="005,006,007,008,009")
    parser.add_argument("--seeds", default="1,2")
    given = parser.parse_args()
    sys.path.insert(0, str(given.bench))
    import implant

    fusions, gaps = collections.Counter(), collections.Counter()
    for mask in given.masks.split(","):
        image = nibabel.load(given.data / f"kdxf-masks/KDXF_{mask}.nii.gz")
        _, points, edges, _, _ = implant.skeleton(np.asarray(image.dataobj) > 0, image.affine)
        part = connected_components(coo_matrix((np.ones(len(edges)), tuple(edges.T)), shape=(len(points),) * 2), directed=False)[1]
        nearest = cKDTree(points)
        for seed in given.seeds.split(","):
            truth = json.loads((given.work / "cases" / f"{mask}-{seed}" / "truth.json").read_text())
            voxel = truth["h"]
            rows = [row for row in rows_of(given.work / "default" / f"{mask}-{seed}")]
            used = [row for row in rows if row["origin"] == "contact" or row["kept"]]
            graph, kept = Graph(used, voxel), np.array([row["kept"] for row in used])
            observed = Graph([row for row in rows if row["origin"] != "candidate"], voxel)
            for fusion in truth["fusions"]:
                cause = cause_of_fusion(graph, used, kept, fusion, voxel)
                same = len({int(part[nearest.query(side[0])[1]]) for side in fusion["sides"]}) == 1
                if cause:
                    fusions[cause, "one part" if same else "two parts"] += 1
            gaps.update(cause_of_gap(graph, observed, rows, kept, gap, voxel) for gap in truth["gaps"])
    print("| fusions | in one part before | in two |\n|---|---|---|")
    for cause in sorted({cause for cause, _ in fusions}, reverse=True):
        print("| %s | %d | %d |" % (cause, fusions[cause, "one part"], fusions[cause, "two parts"]))
    print("\n| gaps | |\n|---|---|")
    for cause, count in gaps.most_common():
        print("| %s | %d |" % (cause, count))


if __name__ == "__main__":
    main()
