"""Whole brains of another data set (BraVa), turned at random, by the atlas of all patients: are named arteries those of the right territory?"""
import sys
from pathlib import Path

import answer
import cases
import common
import numpy as np
import score
from networks import SHARED
from scipy.spatial import cKDTree

DATA = SHARED / "brava/vtp"
# BraVa's numbers of territories: ACA, MCA, PCA (from P2 on); 0 is the circle with its inflow. ACA is called "A2" there, but in every brain and
# on both sides its number begins at the junction where that of the MCA begins, so A1 has it too.
CODES = {"R-A1": 2, "R-A2": 2, "R-M1": 3, "R-M2": 3, "L-M1": 4, "L-M2": 4, "L-A1": 5, "L-A2": 5, "R-P2": 6, "L-P2": 7}
ARTERIES = {"ACA": (2, 5), "MCA": (3, 4), "PCA": (6, 7)}
LEFT = (4, 5, 7)


def brain(path):
    """Points (mm, RAS), radii, edges and the code of the territory of each point."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    sys.path.insert(0, str(cases.GAPBENCH))
    import make_cases

    points, radii, edges, _ = make_cases.read_vtp(path)
    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    ids, code = vtk_to_numpy(data.GetCellData().GetArray("Major Vessel Ids")).astype(int), np.zeros(len(points), int)
    lines = data.GetLines()
    row, line = data.GetNumberOfVerts(), vtk.vtkIdList()
    lines.InitTraversal()
    while lines.GetNextCell(line):
        code[[line.GetId(k) for k in range(line.GetNumberOfIds())]] = ids[row]
        row += 1
    return points, radii, edges, code


def case(job):
    """(name, named mm, all mm, right mm, {artery: (right side mm, mm)}, right mm where A1 counts as the circle) of one brain."""
    path, work, model = job
    name = path.name.split("_")[0]
    points, radii, edges, code = brain(path)
    flip = np.array([-1.0, -1.0, 1.0])
    turn = cases.Turn(points * flip, (path.name,), frame="RAS")
    at = turn(points * flip)
    folder = work / name
    if not (folder / "answer.names.csv").exists():
        order, parent, loops = cases.spanning(len(points), edges)
        cases.write(folder, at, radii, code, order, parent, loops, {})
        answer.label(folder / "fragments.swc", folder / "answer.graphml", model)
    rows = common.rows(folder / "answer.names.csv")
    where = np.array([[float(r[f"{axis}_mm"]) for axis in "xyz"] for r in rows])
    true = code[cKDTree(at).query(where)[1]]
    mm = np.array([float(r["length_mm"]) for r in rows])
    seen = np.array([r["label"] not in ("", cases.OTHER) for r in rows])
    said = np.array([CODES.get(r["label"], 0) for r in rows])
    circle = np.array([0 if r["label"].endswith("-A1") else code for r, code in zip(rows, said)])
    sides = {}
    for artery, both in ARTERIES.items():
        use = seen & np.isin(true, both) & (said > 0)
        sides[artery] = mm[use] @ (np.isin(said, LEFT) == np.isin(true, LEFT))[use], mm[use].sum()
    return name, mm[seen].sum(), mm.sum(), mm[seen] @ (said == true)[seen], sides, mm[seen] @ (circle == true)[seen]


def run(work, options):
    if not DATA.exists():
        print(f"skipped: there is no {DATA}")
        return None
    model = options.model or (options.models / "arteries.toml" if options.models else None)
    jobs = [(path, work, model) for path in sorted(DATA.glob("*.vtp"))]
    rows = [{"subject": r[0], "sums": r} for r in common.everywhere(case, jobs)]
    share = lambda part: score.shown(score.estimate(rows, part, score.share))
    each = np.array([r["sums"][3] / max(r["sums"][1], 1e-9) for r in rows])
    line = [len(rows), share(lambda r: (r["sums"][1], r["sums"][2])), share(lambda r: (r["sums"][3] / max(r["sums"][1], 1e-9), 1)), f"{np.median(each):.3f}, {each.min():.3f} ({rows[int(each.argmin())]['subject']})"]
    line += [share(lambda r: (r["sums"][5] / max(r["sums"][1], 1e-9), 1))] + [share(lambda r: r["sums"][4][artery]) for artery in ARTERIES]
    return common.table(["brains", "share of length named", "territory right", "median, worst", "with A1 counted as circle", *(f"side of {artery} right" for artery in ARTERIES)], [line])
