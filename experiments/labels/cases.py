"""Labelled circles of patients, whole and damaged, turned and shifted at random: cases.py OUT [--seed N] [--variants N] [--upright] [--frame LPS|RAS] [--deleted SHARE] [--levels ...]."""
import argparse
import hashlib
import json
import os
import sys
import zlib
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from networks import ROOT, SHARED

GAPBENCH = Path(os.environ.get("WILLIS_GAPBENCH", ROOT / "../shared/gapbench")).resolve()
DATA = SHARED / "insist-cow"
LEVELS = ("easy", "medium", "hard")
RING = ("L-A1", "R-A1", "AComm", "L-PComm", "R-PComm", "L-P1", "R-P1")
# An artery of the tracings -> its name here. M2 is all of the middle cerebral artery behind its first bifurcation; what is not listed is `other`.
NAMES = {f"{artery} {side}": f"{side}-{artery}" for artery in ("ICA", "M1", "M2", "A1", "A2", "P1", "P2", "PComm") for side in "LR"}
NAMES |= {f"M3 {side}": f"{side}-M2" for side in "LR"} | {"BA": "BA", "AComm": "AComm"}
OTHER = "other"
# Whose a point is where arteries meet: the first of these.
OWNERS = ("ICA", "BA", "M1", "A1", "P1", "P2", "PComm", "A2", "M2", "AComm", OTHER)
# Landmark -> the two groups of arteries that meet there.
MARKS = {"BA/L-P1/R-P1": (("BA",), ("L-P1", "R-P1"))}
for _s in "LR":
    MARKS |= {
        f"{_s}-ICA/{_s}-M1/{_s}-A1": ((f"{_s}-ICA",), (f"{_s}-M1", f"{_s}-A1")),
        f"{_s}-A1/{_s}-A2": ((f"{_s}-A1",), (f"{_s}-A2",)),
        f"{_s}-M1/{_s}-M2": ((f"{_s}-M1",), (f"{_s}-M2",)),
        f"{_s}-ICA/{_s}-PComm": ((f"{_s}-ICA",), (f"{_s}-PComm",)),
        f"{_s}-P1/{_s}-P2/{_s}-PComm": ((f"{_s}-PComm",), (f"{_s}-P1", f"{_s}-P2")),
        f"{_s}-P1/{_s}-P2": ((f"{_s}-P1",), (f"{_s}-P2",)),
    }
# Landmark -> the segment of the ring without which it does not exist.
NEEDS = {f"{s}-{a}": f"{s}-{b}" for s in "LR" for a, b in ((f"A1/{s}-A2", "A1"), (f"ICA/{s}-PComm", "PComm"), (f"P1/{s}-P2/{s}-PComm", "PComm"), (f"P1/{s}-P2", "P1"))}
TILT = 30.0
# Points of two arteries further apart than this (mm) do not meet in a whole tracing.
MEET = 3.0


def missing():
    """What of the shared data is not there."""
    return [str(path) for path in (DATA, GAPBENCH / "make_cases.py") if not path.exists()]


def bare(name):
    return name.rpartition("-")[2]


def seed_of(*key):
    return zlib.crc32("/".join(map(str, key)).encode())


def rotation(v):
    """The matrix of a rotation vector (radians)."""
    angle = np.linalg.norm(v)
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = v / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


class Turn:
    """A rotation about the middle by U(0, `most`) degrees about a random axis and a shift, of points in LPS; the answer in LPS or RAS."""

    def __init__(self, points, key, most=TILT, frame="LPS"):
        rng = np.random.default_rng(seed_of(*key))
        axis = rng.normal(size=3)
        degrees = rng.uniform(0, most) if most else 0.0
        self.flip = np.array([-1.0, -1.0, 1.0])
        self.matrix = rotation(axis / np.linalg.norm(axis) * np.radians(degrees))
        self.shift = rng.normal(scale=100, size=3) if most else (points * self.flip).mean(0)
        self.middle, self.out = (points * self.flip).mean(0), self.flip if frame == "LPS" else np.ones(3)

    def __call__(self, points):
        return ((np.asarray(points) * self.flip - self.middle) @ self.matrix.T + self.shift) * self.out


def trees():
    """{patient: tree of make_cases, whose branches know the artery of every point}, and the module make_cases."""
    sys.path.insert(0, str(GAPBENCH))
    import make_cases

    class Labelled(make_cases.Tree):
        """make_cases gives a branch the artery of its first edge; here every point has its own, in `arteries`."""

        def __init__(self, pts, rad, edges, vox, labels):
            self.of_edge = {pair: label for (a, b), label in zip(edges, labels) for pair in ((a, b), (b, a))}
            super().__init__(pts, rad, edges, vox, labels)

        def _resample(self, chain, pts, rad, label):
            out = super()._resample(chain, pts, rad, label)
            arc = np.r_[0, np.cumsum(np.linalg.norm(np.diff(pts[chain], axis=0), axis=1) + 1e-9)]
            edge = np.clip(np.searchsorted(arc, np.linspace(0, arc[-1], len(out["p"])), side="right") - 1, 0, len(chain) - 2)
            out["arteries"] = [NAMES.get(self.of_edge[chain[k], chain[k + 1]], OTHER) for k in edge]
            return out

        def _orient(self, pts):
            before = [branch["u"] for branch in self.branches]
            super()._orient(pts)
            for branch, u in zip(self.branches, before):
                if branch["u"] != u:
                    branch["arteries"].reverse()

    return {f.parent.name: Labelled(*make_cases.read_insist(f.parent)) for f in sorted(DATA.glob("*/tracing_ves*.swc"))}, make_cases


def owner(a, b):
    return min(a, b, key=lambda name: OWNERS.index(bare(name)))


def whole(tree):
    """(points, radii, names, links) of the undamaged tracing."""
    points, radii, names, links, at = [], [], [], [], {}
    for branch in tree.branches:
        last = None
        for k, (p, r, name) in enumerate(zip(branch["p"], branch["r"], branch["arteries"])):
            node = branch["u"] if k == 0 else branch["v"] if k == len(branch["p"]) - 1 else None
            if node in at:
                row = at[node]
                names[row] = owner(name, names[row])
            else:
                row = len(points)
                points.append(p), radii.append(r), names.append(name)
                if node is not None:
                    at[node] = row
            if last is not None and last != row:
                links.append((last, row))
            last = row
    return np.array(points), np.array(radii), names, links


def damaged(make_cases, trees, name, level, variant, seed):
    """(points, radii, names, parents, loops, presence, removed) of the case that make_cases.py --phenotype writes."""
    tree = trees[name]
    key = f"{name}/{level}/{seed}/{variant}"
    rng = np.random.default_rng(int(hashlib.sha256(key.encode()).hexdigest()[:12], 16))
    donors = [t for n, t in trees.items() if n != name]
    anchors = make_cases.ring_anchors(tree)
    have = [s for s, v in anchors.items() if v[3]]
    n = int(rng.choice([0, 1, 1, 2]))
    removed = set(rng.choice(have, size=min(n, len(have)), replace=False)) if have else set()
    rows, truth, junctions, at, new = make_cases.build_case(name, tree, donors, make_cases.LEVELS[level], rng, removed)
    presence = make_cases.phenotype_truth(tree, removed, junctions, truth, anchors)
    names = [None] * len(rows)
    for (i, k), idx in at.items():
        row, own = new[idx] - 1, tree.branches[i]["arteries"][k]
        names[row] = own if names[row] is None else owner(own, names[row])
    names = [n or OTHER for n in names]
    points, radii = np.array([r[2] for r in rows]), np.array([r[3] for r in rows])
    loops = [(a - 1, b - 1) for a, b in truth["loop_edges"]]
    present = {NAMES[s["segment"]]: bool(s["present"]) for s in presence}
    return points, radii, names, [r[1] - 1 if r[1] > 0 else -1 for r in rows], loops, present, sorted(NAMES[s] for s in removed)


def spanning(n, links):
    """Parents (-1: a root) of a spanning forest, parents first, as (order, parents, links left out)."""
    adjacent = [[] for _ in range(n)]
    for a, b in links:
        adjacent[a].append(b)
        adjacent[b].append(a)
    order, parent, seen, used = [], [-1] * n, [False] * n, set()
    for start in sorted(range(n), key=lambda i: len(adjacent[i])):
        todo = [(start, -1)]
        while todo:
            i, p = todo.pop()
            if seen[i]:
                continue
            seen[i], parent[i] = True, p
            order.append(i)
            if p >= 0:
                used.add((min(i, p), max(i, p)))
            todo += [(j, i) for j in adjacent[i] if not seen[j]]
    return order, parent, [(a, b) for a, b in links if (min(a, b), max(a, b)) not in used]


def marks(points, names):
    """{landmark: point} of a whole tracing: the middle of the closest pair of points of the two groups of arteries."""
    names, out = np.array(names), {}
    for label, groups in MARKS.items():
        a, b = (points[np.isin(names, group)] for group in groups)
        if len(a) and len(b):
            d, j = cKDTree(b).query(a)
            i = int(d.argmin())
            if d[i] <= MEET:
                out[label] = (a[i] + b[j[i]]) / 2
    return out


def write(folder, points, radii, names, order, parent, loops, truth):
    """fragments.swc, loops.csv where there are loops, labels.csv, truth.json."""
    folder.mkdir(parents=True, exist_ok=True)
    number = {row: k + 1 for k, row in enumerate(order)}
    number[-1] = -1
    lines = [f"{number[i]} 0 {' '.join(f'{x:.4f}' for x in points[i])} {radii[i]:.4f} {number[parent[i]]}\n" for i in order]
    (folder / "fragments.swc").write_text("# id type x_mm y_mm z_mm r_mm parent\n" + "".join(lines))
    if loops:
        (folder / "loops.csv").write_text("id_a,id_b\n" + "".join(f"{number[a]},{number[b]}\n" for a, b in loops))
    (folder / "labels.csv").write_text("id,label\n" + "".join(f"{number[i]},{names[i]}\n" for i in order))
    (folder / "truth.json").write_text(json.dumps(truth) + "\n")


def without(points, radii, names, parent, loops, gone):
    """A case without every point of some arteries."""
    keep = [i for i, name in enumerate(names) if name not in gone]
    new = {old: k for k, old in enumerate(keep)}
    links = [(new[i], new[p]) for i, p in enumerate(parent) if p >= 0 and i in new and p in new] + [(new[a], new[b]) for a, b in loops if a in new and b in new]
    order, parent, loops = spanning(len(keep), links)
    return points[keep], radii[keep], [names[i] for i in keep], order, parent, loops


def make(out, seed=1, variants=3, upright=False, frame="LPS", levels=("whole", *LEVELS), deleted=0.0):
    """Writes OUT/PATIENT-LEVEL-VARIANT; `deleted`: the share of present segments taken out of sight entirely, though present."""
    patients, make_cases = trees()
    most = 0.0 if upright else TILT
    for name, tree in patients.items():
        P, R, Y, links = whole(tree)
        places = marks(P, Y)
        for level in levels:
            for variant in range(1 if level == "whole" else variants):
                hidden = []
                if level == "whole":
                    points, radii, names, removed = P, R, Y, []
                    order, parent, loops = spanning(len(P), links)
                    present = {s: s in set(Y) for s in RING}
                else:
                    points, radii, names, parent, loops, present, removed = damaged(make_cases, patients, name, level, variant, seed)
                    order = range(len(points))
                if deleted:
                    rng = np.random.default_rng(seed_of("hide", deleted, name, level, variant))
                    hidden = [s for s, there in present.items() if there and rng.random() < deleted]
                    if hidden:
                        points, radii, names, order, parent, loops = without(points, radii, names, parent, loops, hidden)
                key = (name, level, variant) if seed == 1 else (name, level, variant, seed)
                turn = Turn(points, key, most, frame)
                gone = set(removed) | set(hidden)
                truth = {
                    "subject": name, "level": level, "variant": variant, "seed": seed, "whole": level == "whole", "frame": frame, "voxel_mm": tree.vox,
                    "phenotype": [{"segment": s, "present": there} for s, there in present.items()], "removed": removed, "hidden": hidden,
                    "landmarks": {label: [round(float(x), 4) for x in turn(p)] for label, p in places.items() if NEEDS.get(label) not in gone},
                }
                write(Path(out) / f"{name}-{level}-{variant}", turn(points), radii, names, order, parent, loops, truth)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", type=int, default=1, help="of the damage and of the turns [1]")
    parser.add_argument("--variants", type=int, default=3, help="draws of a patient and level [3]")
    parser.add_argument("--upright", action="store_true", help="neither turned nor shifted: as the scanner lay, to train on")
    parser.add_argument("--frame", choices=("LPS", "RAS"), default="LPS", help="of the files [LPS, as the tracings]")
    parser.add_argument("--levels", default="whole,easy,medium,hard")
    parser.add_argument("--deleted", type=float, default=0.0, help="share of the present segments that are not seen at all [0]")
    options = parser.parse_args()
    if missing():
        raise SystemExit("skipped: there is no " + ", ".join(missing()))
    make(options.out, options.seed, options.variants, options.upright, options.frame, options.levels.split(","), options.deleted)


if __name__ == "__main__":
    main()
