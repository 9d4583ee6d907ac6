"""Cases for `willis train --model contacts` from real masks with gaps and fusions put into them: what is true is known there, and nowhere else.

    cases.py SKELBENCH DATA OUT --masks 001,002 [--seeds 1,2,3] [--fusions 60]

OUT/MASK-SEED holds fragments.npz (the skeleton by willis), mask.nii.gz and truth.json. Stations are points of the skeleton that the mask had before anything
was put in: of branches that are true vessels for certain, because each alone joins a tree of 15 mm or more to the rest, and of the two
vessels at a fusion within 6 mm. All other points are nobody's, and pairs of ends there teach nothing. WILLIS names the program.
"""
import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import networkx as nx
import nibabel
import numpy as np
from scipy.spatial import cKDTree

NEAR_FUSION, TREE = 6.0, 15.0
#: Known points with nothing but others between them, no longer than this (mm), are neighbours: the loop there joins them, whatever is true of it.
THROUGH = 10.0


def safe_edges(graph):
    """Edges that alone join a tree of TREE mm or more to the rest."""
    bridges = {frozenset(edge) for edge in nx.bridges(graph)}
    blocks = graph.copy()
    blocks.remove_edges_from([tuple(edge) for edge in bridges])
    block = {v: i for i, part in enumerate(nx.connected_components(blocks)) for v in part}
    tree = nx.Graph()
    tree.add_nodes_from(set(block.values()), mm=0.0)
    for p, q, mm in graph.edges(data="mm"):
        if frozenset((p, q)) in bridges:
            tree.add_edge(block[p], block[q], mm=mm, edge=frozenset((p, q)))
        else:
            tree.nodes[block[p]]["mm"] += mm
    safe = set()
    for part in nx.connected_components(tree):
        order = list(nx.dfs_edges(tree, next(iter(part))))
        below = {v: tree.nodes[v]["mm"] for v in part}
        for u, v in reversed(order):
            below[u] += below[v] + tree.edges[u, v]["mm"]
        total = below[order[0][0]] if order else 0.0
        safe |= {tree.edges[edge]["edge"] for edge in order if min(below[edge[1]], total - below[edge[1]]) >= TREE}
    return safe


def truth(implant, raw, put_in, subject):
    """The truth of a mask with gaps and fusions, by the skeleton it had before."""
    image = nibabel.load(raw)
    mask = np.asarray(image.dataobj) > 0
    _, points, edges, radius, zoom = implant.skeleton(mask, image.affine)
    length = np.linalg.norm(points[edges[:, 0]] - points[edges[:, 1]], axis=1)
    graph = nx.Graph()
    graph.add_nodes_from(range(len(points)))
    graph.add_weighted_edges_from(zip(*edges.T.tolist(), length.tolist()), weight="mm")
    known = {v for edge in safe_edges(graph) for v in edge}
    nearest = cKDTree(points)
    for fusion in put_in["fusions"]:
        for side in fusion["sides"]:
            around = nearest.query(side)[1].tolist()
            place = nearest.query_ball_point(fusion["place"], NEAR_FUSION)
            part = nx.node_connected_component(graph.subgraph(set(place) | set(around)), around[0])
            known |= part
    # A station is a point that is known; the others are there so that what shows them shows nothing.
    known = sorted(known)
    number = {v: k for k, v in enumerate(known)}
    neighbours = [(p, q, mm) for p, q, mm in graph.edges(data="mm") if p in number and q in number]
    others = graph.subgraph(set(graph) - set(number))
    for part in nx.connected_components(others):
        around = {q for v in part for q in graph[v] if q in number}
        through = graph.edge_subgraph(edge for v in part for edge in graph.edges(v))
        for p in around:
            ways = nx.single_source_dijkstra_path_length(through, p, cutoff=THROUGH, weight="mm")
            neighbours += [(p, q, mm) for q, mm in ways.items() if q in around and p < q]
    adjacent = [(number[p], number[q], mm, "there", [0, 0, 0], 0.0) for p, q, mm in neighbours]
    return dict(subject=subject, voxel_mm=float(zoom.mean()), nodes=points.tolist(), stations=np.c_[points[known], radius[known]].tolist(),
                station_nodes=[[v + 1] for v in known], adjacent=adjacent)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bench", "data", "out"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--masks", required=True)
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--fusions", type=int, default=60)
    given = parser.parse_args()
    sys.path.insert(0, str(given.bench))
    import implant

    willis = os.environ.get("WILLIS", "target/release/willis")
    for mask in given.masks.split(","):
        raw = given.data / f"kdxf-masks/KDXF_{mask}.nii.gz"
        for seed in map(int, given.seeds.split(",")):
            case = given.out / f"{mask}-{seed}"
            implant.make(argparse.Namespace(mask=raw, case=case, seed=seed, gaps=20, fusions=given.fusions))
            put_in = json.loads((case / "truth.json").read_text())
            (case / "truth.json").write_text(json.dumps(truth(implant, raw, put_in, f"KDXF_{mask}")))
            words = [willis, "skeleton", case / "mask.nii.gz", "-o", case / "fragments.npz", "--force", "--quiet"]
            subprocess.run([str(word) for word in words], check=True)


if __name__ == "__main__":
    main()
