"""Can the mask tell a rung from a true vessel? Cross-validated, in real masks with fusions put into them and in simulated scans; the table of rungs in README.md.

    rungs.py SKELBENCH DATA REAL SIMULATED

REAL holds cases of implant.py, a folder MASK-SEED each; SIMULATED holds cases of make_cases.py made with --save-mask, as level/subject. A rung is a short
branch between two junctions by each of which a vessel passes. It is false in a real mask where it joins the two vessels of a fusion that was put in, and true
where every point of it is on a branch that alone joins a tree to the rest; elsewhere nothing is known of it. In a simulated scan the benchmark knows. Skeletons
are those of scikit-image. Nothing that depends on loops is looked at: by loops known rungs of a real mask are told apart by how they were chosen.
"""

import argparse
import json
import sys
from pathlib import Path

import networkx as nx
import nibabel as nib
import numpy as np
from scipy import ndimage as ndi
from scipy.spatial import cKDTree


def unit(v):
    n = np.linalg.norm(v)
    return v / n if n > 0 else v * 0


class Field:
    """The depth of a place below the wall of a mask, mm."""

    def __init__(self, mask, affine):
        self.aff = np.linalg.inv(affine)
        zoom = np.linalg.norm(affine[:3, :3], axis=0)
        self.h = zoom.min()
        self.hm = zoom.mean()
        self.zmax = zoom.max()
        box = ndi.find_objects(mask.astype(np.uint8))[0]
        box = tuple(slice(max(0, s.start - 3), s.stop + 3) for s in box)
        self.lo = np.array([s.start for s in box])
        m = mask[box]
        self.mask = m
        inside = ndi.distance_transform_edt(m, sampling=zoom) - 0.5 * self.h
        outside = ndi.distance_transform_edt(~m, sampling=zoom) - 0.5 * self.h
        self.d = np.where(m, inside, -outside).astype(np.float32)

    def __call__(self, p):
        q = (np.atleast_2d(p) @ self.aff[:3, :3].T + self.aff[:3, 3] - self.lo).T
        return ndi.map_coordinates(self.d, q, order=1, mode="nearest")


class Graph:
    """The runs of a skeleton between points where not exactly two edges meet."""

    def __init__(self, xyz, edges, field):
        self.x, self.f = xyz, field
        self.runs = S.runs_of(len(xyz), edges)
        deg = np.bincount(np.asarray(edges).ravel(), minlength=len(xyz))
        self.deg = deg
        self.depth = field(xyz)
        self.at = {}
        self.len = []
        for k, r in enumerate(self.runs):
            self.len.append(float(np.linalg.norm(np.diff(xyz[r], axis=0), axis=1).sum()))
            self.at.setdefault(r[0], []).append((k, False))
            self.at.setdefault(r[-1], []).append((k, True))

    def core(self, node, rung):
        """Junctions within a voxel or so of this one, not over the rung, and the runs between them."""
        seen, todo, inner = {node}, [node], set()
        r = max(self.depth[node], 0.5 * self.f.hm)
        while todo:
            for k, last in self.at.get(todo.pop(), []):
                run = self.runs[k]
                o = run[0] if last else run[-1]
                if k != rung and self.deg[o] > 2 and self.len[k] <= max(1.5 * self.f.hm, 0.6 * r):
                    if o not in seen:
                        seen.add(o)
                        todo.append(o)
                    inner.add(k)
        return seen, inner

    def arms(self, node, rung):
        """The other ends of runs at an end of a rung."""
        nodes, inner = self.core(node, rung)
        out = [(k, last) for n in nodes for k, last in self.at[n] if k != rung and k not in inner]
        return nodes, out

    def walk(self, k, last, reach):
        """The smooth line along a run and those that go on the straightest, and the length to each point."""
        pts, seen = [], {k}
        L = 0
        while True:
            run = self.runs[k]
            p = list(run[::-1] if last else run)
            q = self.x[p]
            pts += [q] if not pts else [q[1:]]
            L += self.len[k]
            if L >= reach or len(seen) > 4:
                break
            end = p[-1]
            tail = self.x[p[max(0, len(p) - 6) :]]
            d = unit(tail[-1] - tail[0])
            best = None
            for kk, ll in self.at.get(end, []):
                if kk in seen:
                    continue
                r2 = self.runs[kk][::-1] if ll else self.runs[kk]
                e = self.x[r2[:6]]
                s = float(d @ unit(e[-1] - e[0]))
                if best is None or s > best[0]:
                    best = (s, kk, ll)
            if best is None:
                break
            _, k, last = best
            seen.add(k)
        p = np.vstack(pts)
        # smooth
        for _ in range(4):
            q = p.copy()
            if len(p) > 2:
                q[1:-1] = 0.25 * p[:-2] + 0.5 * p[1:-1] + 0.25 * p[2:]
            p = q
        s = np.r_[0, np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))]
        return p, s

    def at_arc(self, p, s, a):
        """Places on a line."""
        a = np.minimum(a, s[-1])
        return np.stack([np.interp(a, s, p[:, i]) for i in range(3)], -1)


#: The features of a rung.
NAMES = [
    "len_sum",
    "gap_h",
    "neck_min",
    "neck_rel",
    "rung_r",
    "rung_r_h",
    "straight0",
    "straight1",
    "far0",
    "far1",
    "perp0",
    "perp1",
    "perpf0",
    "perpf1",
    "cal0",
    "cal1",
    "ends0",
    "ends1",
    "parallel",
    "r_ratio",
    "rmin_h",
    "alen0",
    "alen1",
    "axes",
    "axes_h",
    "off0",
    "off1",
    "tort",
    "dipmid",
    "second0",
    "second1",
    "chord_dir",
    "rungr_mid_rel",
    "wall",
]


def side(g, node, rung, toward, r_hint):
    """The vessel that passes by an end of a rung: the two straightest of the other runs there."""
    nodes, arms = g.arms(node, rung)
    if len(arms) < 2:
        return None
    c = g.x[list(nodes)].mean(0)
    W = []
    for k, last in arms:
        p, s = g.walk(k, last, 12.0)
        a = np.linspace(min(1.0 * r_hint, 0.3 * s[-1]), min(1.0 * r_hint + 4.0, s[-1]), 9)
        q = g.at_arc(p, s, a)
        rad = float(np.median(np.maximum(g.f(q), 0.3 * g.f.h)))
        near = unit(g.at_arc(p, s, min(0.6 * r_hint + 2.0, s[-1])) - g.at_arc(p, s, min(0.6 * r_hint, 0.2 * s[-1])))
        far = unit(g.at_arc(p, s, min(1.5 * r_hint + 5.0, s[-1])) - g.at_arc(p, s, min(1.2 * r_hint, 0.3 * s[-1])))
        W.append(dict(near=near, far=far, rad=rad, len=s[-1], pts=q))
    best = []
    for i in range(len(W)):
        for j in range(i):
            st = -float(W[i]["near"] @ W[j]["near"])
            best.append((st + 0.5 * -float(W[i]["far"] @ W[j]["far"]), i, j))
    best.sort(reverse=True)
    _, i, j = best[0]
    a, b = W[i], W[j]
    axis, faxis = unit(a["near"] - b["near"]), unit(a["far"] - b["far"])
    partner = max(-float(toward @ w["near"]) for w in W)
    P = np.vstack([a["pts"][::-1], b["pts"]])
    return dict(
        st=-float(a["near"] @ b["near"]),
        far=-float(a["far"] @ b["far"]),
        perp=abs(float(axis @ toward)),
        perpf=abs(float(faxis @ toward)),
        cal=abs(np.log(a["rad"] / b["rad"])),
        ends=len(W),
        r=0.5 * (a["rad"] + b["rad"]),
        rmin=min(a["rad"], b["rad"]),
        alen=min(a["len"], b["len"]),
        axis=axis,
        faxis=faxis,
        pts=P,
        c=c,
        partner=partner,
        mid=0.5 * (a["pts"][0] + b["pts"][0]),
    )


def rung_rows(g):
    """The rungs: run, features, middle, places along it."""
    out = []
    hm = g.f.hm
    for k, run in enumerate(g.runs):
        a, b = run[0], run[-1]
        if a == b or g.deg[a] < 3 or g.deg[b] < 3:
            continue
        r0 = max(g.depth[a], 0.5 * hm)
        r1 = max(g.depth[b], 0.5 * hm)
        L = g.len[k]
        if L > 3.0 * (r0 + r1) + 3 * hm or L > 9:
            continue
        p = g.x[run]
        na, ia = g.core(a, k)
        if b in na:
            continue
        d = unit(g.x[b] - g.x[a])
        A, B = side(g, a, k, d, r0), side(g, b, k, -d, r1)
        if A is None or B is None:
            continue
        s = np.r_[0, np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))]
        q = np.stack([np.interp(np.linspace(0, L, 17), s, p[:, i]) for i in range(3)], 1)
        dep = g.f(q)
        dep = np.convolve(np.r_[dep[0], dep, dep[-1]], [0.25, 0.5, 0.25], "valid")
        rs = A["r"] + B["r"]
        rmin, rmax = min(A["r"], B["r"]), max(A["r"], B["r"])
        neck = float(dep.min())
        mid = dep[5:12]
        wall = L - rs
        lo = lambda n: sorted([A[n], B[n]])
        D = B["mid"] - A["mid"]
        n_ = np.cross(A["axis"], B["axis"])
        axes = abs(float(D @ unit(n_))) if np.linalg.norm(n_) > 0.3 else float(np.linalg.norm(D - (D @ A["axis"]) * A["axis"]))
        chord = float(np.linalg.norm(g.x[b] - g.x[a]))
        off = sorted([float(np.linalg.norm(np.cross(t["axis"], g.x[n] - t["mid"]))) / t["r"] for t, n in ((A, a), (B, b))])
        f = [
            L / rs,
            wall / hm,
            neck / rmin,
            neck / g.f.h,
            float(np.median(dep)) / rmin,
            float(np.median(mid)) / g.f.h,
            *lo("st"),
            *lo("far"),
            *lo("perp"),
            *lo("perpf"),
            *lo("cal"),
            *lo("ends"),
            abs(float(A["axis"] @ B["axis"])),
            np.log(rmax / rmin),
            rmin / hm,
            *[min(x, 12) for x in lo("alen")],
            axes / rs,
            (axes - rs) / hm,
            *off,
            L / max(chord, 1e-6),
            float(mid.min()) / min(dep[0], dep[-1]) if min(dep[0], dep[-1]) > 0 else 1.0,
            *lo("partner"),
            float(unit(D) @ d),
            float(np.median(mid)) / max(rmax, 1e-6),
            wall,
        ]
        out.append((k, f, q[8], q))
    return out


def real_case(data, case):
    """The rungs of a mask with fusions put in: features, 1 for true and 0 for false (-1 where that is not known), run; and the graph."""
    raw = nib.load(data / f"kdxf-masks/KDXF_{case.name[:3]}.nii.gz")
    t = json.loads((case / "truth.json").read_text())
    m0 = np.asarray(raw.dataobj) > 0
    _, pts0, e0, rad0, zoom = implant.skeleton(m0, raw.affine)
    g0 = nx.Graph()
    g0.add_nodes_from(range(len(pts0)))
    g0.add_weighted_edges_from(zip(*e0.T.tolist(), np.linalg.norm(pts0[e0[:, 0]] - pts0[e0[:, 1]], axis=1).tolist()), weight="mm")
    safe = sorted({v for e in C.safe_edges(g0) for v in e})
    ks = cKDTree(pts0[safe])
    img = nib.load(case / "mask.nii.gz")
    m = ndi.binary_fill_holes(np.asarray(img.dataobj) > 0)
    _, x, e, rad, _ = implant.skeleton(m, img.affine)
    g = Graph(x, e, Field(m, img.affine))
    out = []
    places = np.array([f["place"] for f in t["fusions"]])
    kf, k0 = cKDTree(places), cKDTree(pts0)
    parts = []
    for f in t["fusions"]:
        near = set(k0.query_ball_point(f["place"], 7.0))
        ps = []
        for side_ in f["sides"]:
            i = [int(v) for v in k0.query(np.array(side_))[1]]
            sub = g0.subgraph(near | set(i))
            c = set()
            for v in i:
                c |= nx.node_connected_component(sub, v)
            ps.append(cKDTree(pts0[sorted(c)]))
        parts.append(ps)
    for k, f, mid, q in rung_rows(g):
        d, n = kf.query(mid)
        lab = -1
        if d < 2.5:
            a, b = q[0], q[-1]
            P0, P1 = parts[n]
            da, db = P0.query(a)[0] - P1.query(a)[0], P0.query(b)[0] - P1.query(b)[0]
            if da * db < 0:
                lab = 0
        elif d > 5 and (ks.query(q)[0] < 1.01 * zoom.max()).all():
            lab = 1
        out.append((f, lab, k))
    return out, g


def sim_case(case):
    """The same of a simulated scan."""
    t = json.loads((case / "truth.json").read_text())
    z = np.load(case / "fragments.npz")
    x, e = z["coords"], z["edges"]
    img = nib.load(case / "mask.nii.gz")
    m = np.asarray(img.dataobj) > 0
    g = Graph(x, e, Field(m, img.affine))
    false = {frozenset((a - 1, b - 1)) for f in t["fusions"] for a, b in f["edges"]}
    shown = np.full(len(x), -1)
    for s, ids in enumerate(t["station_nodes"]):
        for i in ids:
            shown[i - 1] = s
    out = []
    for k, f, _, _ in rung_rows(g):
        run = g.runs[k]
        if any(frozenset(p) in false for p in zip(run[:-1], run[1:])):
            lab = 0
        elif (shown[run] >= 0).mean() > 0.7:
            lab = 1
        else:
            lab = -1
        out.append((f, lab, k))
    return out, g


def cross_validated(cases, fitted_to, judged):
    """Scores of the rungs of `judged`, by trees fitted to those of `fitted_to` less the mask or brain that is judged; and what is true of them."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    scores, truths = [], []
    for whom in sorted({key[1] for key in judged}):
        keys = [key for key in fitted_to if key[1] != whom]
        rows, true = np.vstack([cases[key][0] for key in keys]), np.concatenate([cases[key][1] for key in keys])
        kind = np.concatenate([np.full(len(cases[key][1]), key[0] == "real") for key in keys])
        # Real and simulated weigh the same, and so do true and false.
        weight = np.ones(len(true))
        for of in (kind, ~kind):
            for answer in (0, 1):
                weight[of & (true == answer)] /= max(1, (of & (true == answer)).sum())
        trees = HistGradientBoostingClassifier(max_iter=120, max_depth=4, learning_rate=0.06, min_samples_leaf=8, l2_regularization=1.0, random_state=0)
        trees.fit(rows, true, sample_weight=weight / weight.mean())
        for key in judged:
            if key[1] == whom:
                scores.append(trees.predict_proba(cases[key][0])[:, 1])
                truths.append(cases[key][1])
    return np.concatenate(scores), np.concatenate(truths)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bench", "data", "real", "simulated"):
        parser.add_argument(name, type=Path)
    given = parser.parse_args()
    global S, implant, C
    sys.path[:0] = [str(given.bench), str(Path(__file__).resolve().parent)]
    import cases as C
    import implant
    import score as S
    from sklearn.metrics import roc_auc_score

    cases = {}
    for truth in [*sorted(given.real.glob("*/truth.json")), *sorted(given.simulated.glob("*/*/truth.json"))]:
        case = truth.parent
        is_real = given.real in case.parents
        found, _ = real_case(given.data, case) if is_real else sim_case(case)
        known = [(row, true) for row, true, *_ in found if true >= 0]
        key = ("real", case.name[:3], case.name) if is_real else ("simulated", case.name, case.parent.name)
        cases[key] = np.array([row for row, _ in known]), np.array([true for _, true in known])
    kinds = {kind: [key for key in cases if key[0] == kind] for kind in ("real", "simulated")}
    kinds["both"] = list(cases)
    print("| judged on | fitted to | AUC | false ones found at 2 %, 5 %, 10 % of the true ones lost | false, true |\n|---|---|---|---|---|")
    for judged in ("real", "simulated"):
        for fitted_to in ("both", "real", "simulated"):
            score, true = cross_validated(cases, kinds[fitted_to], kinds[judged])
            found = ["%.2f" % (score[true == 0] < np.quantile(score[true == 1], lost)).mean() for lost in (0.02, 0.05, 0.1)]
            print(f"| {judged} | {fitted_to} | {roc_auc_score(true, score):.3f} | {', '.join(found)} | {(true == 0).sum()}, {(true == 1).sum()} |")


if __name__ == "__main__":
    main()
