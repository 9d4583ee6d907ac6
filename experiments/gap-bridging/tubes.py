"""The weights for tubes: fitted to trees drawn vessel by vessel, tried on the tubes of experts. tubes.py [--work FOLDER] [--only weights|experts]."""
import argparse
import csv
import hashlib
import json
import shutil
import sys
import tempfile
import tomllib
from pathlib import Path

import numpy as np

import bench

EXPERTS = [bench.SHARED / f"tubetk-masks/tubes-{subject}.vtp" for subject in ("002", "003")]
lost = bench.missing() + [str(path) for path in EXPERTS if not path.exists()] + [name for name in ("vtk",) if bench.find_spec(name) is None]
if lost:
    print("skipped: there is no " + ", ".join(lost), file=sys.stderr)
    sys.exit()

import common
import make_cases

SHIPPED = bench.ROOT / "crates/models/src/candidates/model/tubes.toml"
SOURCES = {"brains": "brava/vtp", "circles": "insist-cow"}
# Trees are drawn vessel by vessel, each beginning inside or near the lumen of the one it leaves. A case has shares of its own: how often a
# vessel goes on through a junction, how densely it has points, how many of its vessels are broken or missing. Distances over radius are those
# between the tubes of the two experts: the nearer end of a tube lies at .45 radii of another (median), .19 and .8 (quartiles).
STEPS = (.05, .5)
NEAR = (.45, .9)
STANDING = 3.0


def resampled(points, radii, step):
    arc = np.r_[0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    at = np.linspace(0, arc[-1], max(2, round(arc[-1] / step) + 1))
    return np.array([np.interp(at, arc, x) for x in points.T]).T, np.interp(at, arc, radii)


def smooth(points):
    for _ in range(2):
        points = np.r_[points[:1], .25 * points[:-2] + .5 * points[1:-1] + .25 * points[2:], points[-1:]]
    return points


def chains(tree, rng, through):
    """Vessels as lists of branches in the direction of flow, each with the node where it leaves another."""
    leaving = {}
    for row, branch in enumerate(tree.branches):
        leaving.setdefault(branch["u"], []).append(row)
    arriving = {branch["v"] for branch in tree.branches}
    out, begun = [], set()
    open_ends = [row for row, branch in enumerate(tree.branches) if branch["u"] not in arriving]
    while True:
        if not open_ends:
            rest = [row for row in range(len(tree.branches)) if row not in begun]
            if not rest:
                return out
            open_ends = rest[:1]
        row = open_ends.pop()
        if row in begun:
            continue
        vessel = []
        while row is not None and row not in begun:
            begun.add(row)
            vessel.append(row)
            last = tree.branches[row]
            next_ones = [r for r in leaving.get(last["v"], []) if r not in begun]
            row = None
            if next_ones and (len(next_ones) == 1 or rng.random() < through):
                row = max(next_ones, key=lambda r: np.median(tree.branches[r]["r"]))
            open_ends += [r for r in next_ones if r != row]
        out.append(vessel)


def case(tree, rng):
    """Tubes (points, radii), per junction or break its members (tube, arc on it, whether it begins there), and the distance of points."""
    through, broken, missing, wide = rng.beta(4, 1.5), rng.uniform(0, .2), rng.uniform(0, .1), rng.uniform(1, 1.4)
    step, even = np.exp(rng.uniform(*np.log(STEPS))), rng.random() < .5
    tubes, members = [], {}
    for vessel in chains(tree, rng, through):
        rows = [tree.branches[row] for row in vessel]
        points = np.concatenate([b["p"][bool(k):] for k, b in enumerate(rows)])
        radii = np.concatenate([b["r"][bool(k):] for k, b in enumerate(rows)])
        arc = np.r_[0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
        r = np.median(radii)
        places = [(rows[0]["u"], 0.)]
        for b in rows:
            places.append((b["v"], places[-1][1] + b["len"]))
        cuts = [0., arc[-1]]
        if rng.random() < broken:
            cuts.insert(1, rng.uniform(.2, .8) * arc[-1])
            places.append((("break", *vessel), cuts[1]))
        for begin, end in zip(cuts[:-1], cuts[1:]):
            # What is missing at either end; a tube may also begin beyond the axis of the one it leaves, which the vessel itself does not show.
            short = [r * (np.exp(np.log(NEAR[0]) + NEAR[1] * rng.normal()) if at in (0, arc[-1]) else rng.exponential(1.)) for at in (begin, end)]
            first, last = begin + short[0], end - short[1]
            if last - first < 1.5 * r or rng.random() < missing:
                continue
            at = np.linspace(first, last, max(2, round((last - first) / tree.vox) + 1))
            line = smooth(smooth(np.array([np.interp(at, arc, x) for x in points.T]).T))
            line[[0, -1]] += rng.normal(0, .2 * r, (2, 3))
            own = wide * np.interp(at, arc, radii) * np.exp(rng.normal(0, .08))
            own *= (np.median(own) / own) ** (.7 * even)
            for place, s in places:
                if begin - 1e-9 <= s <= end + 1e-9:
                    members.setdefault(place, []).append((len(tubes), s - first, s <= begin + 1e-9))
            tubes.append(resampled(smooth(line), own, step))
    return tubes, members, step


def write(folder, subject, tubes, members, step, rng):
    order = rng.permutation(len(tubes))
    first, rows, nodes = {}, [], []
    for tube in order:
        points, radii = tubes[tube]
        turned = rng.random() < .5
        first[tube] = (len(rows) + 1, turned)
        for k in range(len(points)):
            at = len(points) - 1 - k if turned else k
            rows.append((len(rows) + 1, *points[at], radii[at], -1 if k == 0 else len(rows)))
            nodes.append([round(float(x), 4) for x in (*points[at], radii[at])])
    links = []
    for place in members.values():
        if len(place) < 2:
            continue
        link, parents = [], [member for member in place if not member[2]]
        for member in place:
            tube, s, begins = member
            points, radii = tubes[tube]
            arc = np.r_[0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
            s = np.clip(s, 0, arc[-1])
            r = float(np.interp(s, arc, radii))
            loose = min(s, arc[-1] - s) < 2 * r
            near = np.flatnonzero(np.abs(arc - s) <= (max(1.0 * r, 2 * step) if loose and begins else max(STANDING * r, 3 * step)))
            begin, turned = first[tube]
            ids = [begin + (len(points) - 1 - k if turned else k) for k in near.tolist()]
            parent = member == parents[0] if parents else member == place[0]
            link.append({"role": "parent" if parent else "child", "allowed": ids})
        links.append(link)
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / "fragments.swc", "w") as file:
        file.write("# id type x_mm y_mm z_mm r_mm parent\n")
        for row in rows:
            file.write("%d 0 %.4f %.4f %.4f %.4f %d\n" % row)
    truth = {"subject": subject, "voxel_mm": make_cases.BRAVA_VOXEL, "nodes": nodes, "links": links}
    (folder / "truth.json").write_text(json.dumps(truth))


def draw(work):
    """A folder of cases for each source, of all training seeds."""
    tree = work / "tubes"
    if (tree / "made").exists():
        return tree
    for source, folder in SOURCES.items():
        for name, whole in make_cases.load_all(bench.SHARED / folder).items():
            for seed in bench.TRAINING_SEEDS:
                rng = np.random.default_rng(int(hashlib.sha256(f"tubes/{name}/{seed}".encode()).hexdigest()[:12], 16))
                write(tree / source / f"{name}-{seed}", name, *case(whole, rng), rng)
    (tree / "made").touch()
    return tree


def fit(work):
    """Fits the weights that ship, and says how they do on subjects that they were not fitted to."""
    weights = work / "weights" / "tubes.toml"
    if not weights.exists():
        tree = draw(work)
        weights.parent.mkdir(exist_ok=True)
        common.willis("train", *SOURCES, "-o", weights, "--folds", bench.FOLDS, threads=bench.os.cpu_count(), folder=tree)
    shutil.copyfile(weights, SHIPPED)
    figures = tomllib.loads(SHIPPED.read_text())["figures"]
    lines = [[f["of"], f["cases"], *(f"{f[k]:.3f}" for k in ("average_precision", "calibration_error", "log_likelihood"))] for f in figures]
    print(common.table(["held out", "cases", "AP", "calibration error", "log-likelihood"], lines))


def read_tubes(path):
    """Points, radii, and the rows of each tube."""
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy

    reader = vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    points, radii = (vtk_to_numpy(x).astype(float) for x in (data.GetPoints().GetData(), data.GetPointData().GetArray("Radius")))
    starts, rows = (vtk_to_numpy(x) for x in (data.GetLines().GetOffsetsArray(), data.GetLines().GetConnectivityArray()))
    return points, radii, np.split(rows, starts[1:-1])


def judge(path, prior, work):
    """The tubes, the pieces they make with what is kept, and the share of near ends (within 2 r of another tube) that are attached."""
    points, radii, tubes = read_tubes(path)
    of = np.empty(len(points), int)
    for tube, rows in enumerate(tubes):
        of[rows] = tube
    out = work / "out"
    common.willis("infer", path, "-o", out, "--dpi", 72, "-n", 1, *(["--prior", prior] if prior else []))
    with open(out / "edges.csv", newline="") as file:
        kept = [row for row in csv.DictReader(file) if row["origin"] == "candidate" and row["kept"] == "1"]
    ends = np.array([[float(row[f"{end}{axis}_mm"]) for axis in "xyz"] for row in kept for end in "ab"]).reshape(-1, 3)
    every, made = make_cases.cKDTree(points), make_cases.cKDTree(ends)

    def away(row):
        near = np.array([other for other in every.query_ball_point(points[row], 2 * radii.max()) if of[other] != of[row]])
        return (np.linalg.norm(points[near] - points[row], axis=1) / radii[near]).min() if len(near) else np.inf

    nearer = [min((away(row), row) for row in (rows[0], rows[-1])) for rows in tubes]
    near = [row for distance, row in nearer if distance < 2]
    attached = sum(made.query(points[row])[0] < .06 for row in near)
    joined = of[every.query(ends)[1]].reshape(-1, 2)
    links = make_cases.coo_matrix((np.ones(len(joined)), joined.T), shape=(len(tubes), len(tubes)))
    pieces, _ = make_cases.connected_components(links, directed=False)
    return [len(tubes), pieces, f"{attached / len(near):.3f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--work", type=Path, help="a folder to keep draws and weights in, and to go on from [a temporary one]")
    parser.add_argument("--only", choices=["weights", "experts"])
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="tubes-") as scratch:
        work = (options.work or Path(scratch)).resolve()
        work.mkdir(parents=True, exist_ok=True)
        if options.only != "experts":
            fit(work)
        if options.only != "weights":
            rows = [[path.stem, name, *judge(path, prior, work)] for path in EXPERTS for name, prior in (("tracing", "weights:tracing"), ("tubes", None))]
            print(common.table(["expert", "weights", "tubes", "pieces", "near ends attached"], rows))


if __name__ == "__main__":
    main()
