"""The decisions of the guide to masks bring the answer to the truth that the drawn mask hides."""

import json
import math
import re
from pathlib import Path

import networkx as nx
import willis

TRUTH = json.loads(Path("data/scan.truth.json").read_text())


def lines(folder):
    """The points of the vessels of a topology as a graph, with lengths in mm."""
    graph = nx.Graph()
    whole = nx.MultiGraph(nx.read_graphml(folder / "topology.graphml"))
    place = {node: tuple(of[f"{axis}_mm"] for axis in "xyz") for node, of in whole.nodes(data=True)}
    for row, (a, b, of) in enumerate(whole.edges(data=True)):
        between = [tuple(map(float, point.split()[:3])) for point in of.get("points", "").split(";") if point.strip()]
        if between and math.dist(between[0], place[a]) > math.dist(between[-1], place[a]):
            between.reverse()
        keys = [a, *((row, at) for at in range(len(between))), b]
        way = [place[a], *between, place[b]]
        for key, at in zip(keys, way):
            graph.add_node(key, at=at)
        for (u, p), (v, q) in zip(zip(keys, way), zip(keys[1:], way[1:])):
            graph.add_edge(u, v, mm=math.dist(p, q))
    return graph


def nearest(graph, at):
    return min(graph, key=lambda node: math.dist(graph.nodes[node]["at"], at))


def closed(graph, gap):
    """Whether the ends of a break are joined by a way of about its length."""
    try:
        return nx.shortest_path_length(graph, *(nearest(graph, at) for at in gap["ends_mm"]), weight="mm") <= 1.5 * gap["gap_mm"] + 4
    except nx.NetworkXNoPath:
        return False


def parted(graph, touch):
    """Whether no way leads from the one vessel to the other within 8 mm of where they touch."""
    place = touch["position_mm"]
    ball = graph.subgraph([node for node in graph if math.dist(graph.nodes[node]["at"], place) < 8])
    part = {node: at for at, nodes in enumerate(nx.connected_components(ball)) for node in nodes}
    courses = [TRUTH["centerlines"][vessel]["points_mm"] for vessel in touch["vessels"]]
    sides = []
    for course, other in (courses, courses[::-1]):
        clear = [at for at in course if 3 < math.dist(at, place) < 7.5 and min(math.dist(at, q) for q in other) > 2.5]
        near = [nearest(ball, at) for at in clear]
        sides.append({part[node] for node, at in zip(near, clear) if math.dist(ball.nodes[node]["at"], at) < 1.5})
    assert all(sides), touch
    return not sides[0] & sides[1]


def test_the_decisions_of_the_guide_bring_the_truth(tmp_path):
    page = Path("docs/src/guide-mask.md").read_text()
    code = next(block for block in re.findall(r"```python\n(.*?)```", page, re.S) if "run.decide" in block)
    found = {}
    exec(code.replace('decided.save("repaired")', ""), found)  # noqa: S102
    found["run"].save(tmp_path / "first", dpi=36)
    found["decided"].save(tmp_path / "second", dpi=36)
    before, after = lines(tmp_path / "first"), lines(tmp_path / "second")
    count = lambda judge, graph, places: sum(judge(graph, place) for place in places)
    assert (count(closed, before, TRUTH["breaks"]), count(parted, before, TRUTH["contacts"])) == (8, 0)
    assert (count(closed, after, TRUTH["breaks"]), count(parted, after, TRUTH["contacts"])) == (8, 4)
