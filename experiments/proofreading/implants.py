"""Real masks with gaps and fusions put into them, as one sees them who knows what was put in and which branches are certain, and nothing else.

    implants.py SKELBENCH DATA OUT --masks 005,006 [--seed 1]

OUT/MASK has mask.nii.gz, truth.json as skelbench's other cases have it, and put-in/truth.json, which `implant.py` judges by. The tracing is the skeleton that the
mask had before anything was put in. Known of it are branches that alone join a tree of 15 mm or more to the rest, and around a fusion what hangs together
on either side of it: that is apart from the other side, but pairs of stations there are "side", not certain to be one. Stations elsewhere are shown by nothing, and pairs with
such a one are "unknown". Only fusions and links that were put in are told.
"""
import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

import networkx as nx
import nibabel
import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "real-masks"))
from cases import safe_edges

#: What hangs together so near to a fusion, mm, is one of its two vessels.
NEAR_FUSION = 8.0


def known_points(runs_of, points, edges, fusions):
    """Which points of a skeleton are of a vessel for certain, and which of one side of a fusion."""
    graph = nx.Graph()
    graph.add_nodes_from(range(len(points)))
    graph.add_weighted_edges_from([(a, b, float(np.linalg.norm(points[a] - points[b]))) for a, b in edges.tolist()], weight="mm")
    safe = safe_edges(graph)
    # A branch that is one in part is one to both of its ends.
    certain = {point for run in runs_of(len(points), edges) if any(frozenset(edge) in safe for edge in zip(run, run[1:])) for point in run}
    nearest, beside = cKDTree(points), set()
    for fusion in fusions:
        around = set(nearest.query_ball_point(fusion["place"], NEAR_FUSION))
        for side in fusion["sides"]:
            own = nearest.query(side)[1].tolist()
            beside |= nx.node_connected_component(graph.subgraph(around | set(own)), own[0])
    return [np.isin(np.arange(len(points)), list(those)) for those in (certain, beside)]


def truth(make_cases, implant, raw, case):
    """The truth of a mask with gaps and fusions, by the skeleton that it had before."""
    put_in = json.loads((case / "truth.json").read_text())
    image = nibabel.load(raw)
    _, points, edges, radius, zoom = implant.skeleton(np.asarray(image.dataobj) > 0, image.affine)
    certain, beside = known_points(make_cases.runs_of, points, edges, put_in["fusions"])
    h = float(zoom.max())
    tracing = make_cases.Truth(points, radius, edges, h / 2)
    mask = ndimage.binary_fill_holes(np.asarray(nibabel.load(case / "mask.nii.gz").dataobj) > 0)
    in_mm = lambda voxels: voxels @ image.affine[:3, :3].T + image.affine[:3, 3]
    answer = make_cases.annotate(tracing, mask, None, h, *make_cases.skeleton_graph(mask, zoom, image.affine), np.random.default_rng(0), in_mm)
    at = cKDTree(points).query(np.array(answer["stations"])[:, :3])[1]
    certain, known = certain[at], (certain | beside)[at]
    answer["station_nodes"] = [shown if is_known else [] for shown, is_known in zip(answer["station_nodes"], known)]
    states = lambda a, b, state: state if certain[a] and certain[b] else "side" if known[a] and known[b] else "unknown"
    answer["adjacent"] = [[a, b, mm, states(a, b, state), *rest] for a, b, mm, state, *rest in answer["adjacent"]]
    near = lambda place, those: any(np.linalg.norm(np.subtract(place, one)) <= reach for one, reach in those)
    fusions = [(fusion["place"], fusion["reach"]) for fusion in put_in["fusions"]]
    answer["fusions"] = [fusion for fusion in answer["fusions"] if near(fusion["place"], fusions)]
    gaps = [(np.add(gap["a"], gap["b"]) / 2, gap["mm"]) for gap in put_in["gaps"]]
    middle = lambda link: np.mean([answer["nodes"][site["node"] - 1][:3] for site in link], axis=0)
    answer["links"] = [link for link in answer["links"] if near(middle(link), gaps)]
    return answer


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bench", "data", "out"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--masks", required=True)
    parser.add_argument("--seed", default="1")
    given = parser.parse_args()
    sys.path.insert(0, str(given.bench))
    import implant
    import make_cases

    for mask in given.masks.split(","):
        raw, case = given.data / f"kdxf-masks/KDXF_{mask}.nii.gz", given.out / mask
        if (case / "truth.json").exists():
            continue
        if not (case / "put-in/truth.json").exists():
            words = [sys.executable, given.bench / "implant.py", "make", raw, case / "put-in", "--seed", given.seed]
            subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL)
        shutil.copy(case / "put-in/mask.nii.gz", case)
        (case / "truth.json").write_text(json.dumps(truth(make_cases, implant, raw, case / "put-in")))


if __name__ == "__main__":
    main()
