"""Centerlines of the masks of skelbench cases by willis, with the truth of the case.

    python own.py SKELBENCH CASES OUT       CASES/<level>/<subject> of make_cases.py, made with --save-mask

The truth names nodes of scikit-image's skeleton. Willis' lines are smoother, so a point means the nearest node within two voxels. A
connection that no point of the resampled lines reaches is left out.
"""
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys

import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, sys.argv[1])
import score


def resampled(lines):
    """Points at about the step of the model along the lines."""
    x, r, edges = lines["coords"].astype(float), np.maximum(lines["radii"].astype(float), 1e-3), lines["edges"]
    length = np.linalg.norm(x[edges[:, 0]] - x[edges[:, 1]], axis=1)
    radius = (r[edges[:, 0]] + r[edges[:, 1]]) / 2
    order = np.argsort(radius, kind="stable")
    step = 1.4142 * radius[order][np.searchsorted(np.cumsum(length[order]), .25 * length.sum())]
    points = []
    for run in score.runs_of(len(x), edges):
        arc = np.r_[0, np.cumsum(np.linalg.norm(np.diff(x[run], axis=0), axis=1))]
        at = np.linspace(0, arc[-1], max(1, int(round(arc[-1] / step))) + 1)
        points.append(np.column_stack([np.interp(at, arc, x[run, k]) for k in range(3)]))
    return np.vstack(points)


def convert(case, out):
    out.mkdir(parents=True, exist_ok=True)
    willis = os.environ.get("WILLIS", "target/release/willis")
    subprocess.run([willis, "skeleton", case / "mask.nii.gz", "-o", out / "fragments.npz", "--force", "--quiet"], check=True)
    truth = json.loads((case / "truth.json").read_text())
    reach = 2 * truth["voxel_mm"]
    tree = cKDTree([n[:3] for n in truth["nodes"]])
    points, meant = resampled(np.load(out / "fragments.npz")), set()
    for p, d in zip(points, tree.query(points)[0]):
        if d <= .98 * reach:
            meant.update(k + 1 for k in tree.query_ball_point(p, d + .28 * reach))
    links = [[m for m in link if any(n in meant for n in m["allowed"])] for link in truth["links"]]
    (out / "mask.nii.gz").unlink(missing_ok=True)
    (out / "mask.nii.gz").symlink_to(os.path.relpath(case / "mask.nii.gz", out))
    (out / "truth.json").write_text(json.dumps({
        "reach_mm": reach, "links": [link for link in links if len(link) > 1],
        "fusions": [{k: f[k] for k in ("place", "reach_mm", "judged")} for f in truth["fusions"]],
        **{k: truth[k] for k in ("voxel_mm", "nodes", "stations", "station_nodes", "adjacent", "subject")}}))


if __name__ == "__main__":
    masks = sorted(pathlib.Path(sys.argv[2]).glob("*/*/mask.nii.gz"))
    folders = [pathlib.Path(sys.argv[3]) / mask.parent.parent.name / mask.parent.name for mask in masks]
    with concurrent.futures.ProcessPoolExecutor() as pool:
        list(pool.map(convert, [mask.parent for mask in masks], folders))
