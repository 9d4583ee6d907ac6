"""The same extraction told differently: scaled, turned, renumbered. An answer is put back on the points of the original."""
import hashlib
import json

import bench
import numpy as np
from scipy.spatial import cKDTree

KINDS = ("scaled", "rotated", "renumbered")


def read(folder):
    """Positions and radii, parents (from 0; -1 for roots), inlets, loop edges."""
    a = np.loadtxt(folder / "fragments.swc", comments="#", ndmin=2)
    inlets = np.loadtxt(folder / "inlets.csv", delimiter=",", skiprows=1, ndmin=2)
    loops = folder / "loops.csv"
    extra = np.loadtxt(loops, delimiter=",", skiprows=1, ndmin=2).astype(int) - 1 if loops.exists() else np.zeros((0, 2), int)
    return a[:, 2:6], np.where(a[:, 6] > 0, a[:, 6].astype(int) - 1, -1), inlets, extra


def write(folder, points, parents, inlets, loops):
    folder.mkdir(parents=True, exist_ok=True)
    number = lambda row: " ".join(repr(float(v)) for v in row)
    lines = [f"{i + 1} 0 {number(p)} {parent + 1 if parent >= 0 else -1}" for i, (p, parent) in enumerate(zip(points, parents))]
    (folder / "fragments.swc").write_text("# id type x_mm y_mm z_mm r_mm parent\n" + "\n".join(lines) + "\n")
    (folder / "inlets.csv").write_text("x_mm,y_mm,z_mm\n" + "".join(number(p).replace(" ", ",") + "\n" for p in inlets))
    bench.state_inlets(folder / "inlets.csv")
    if len(loops):
        (folder / "loops.csv").write_text("id_a,id_b\n" + "".join(f"{a + 1},{b + 1}\n" for a, b in loops))


def renumbered(parents, rng):
    """A new order of the points and their new parents: pieces in any order, each from another of its free ends."""
    n = len(parents)
    near = [[] for _ in range(n)]
    for child, parent in enumerate(parents):
        if parent >= 0:
            near[child].append(parent)
            near[parent].append(child)
    piece = np.cumsum(parents < 0) - 1
    order, above = [], []
    for c in rng.permutation(piece[-1] + 1):
        points = np.flatnonzero(piece == c)
        ends = [p for p in points if len(near[p]) <= 1]
        stack = [(int(rng.choice(ends)), -1)]
        while stack:
            point, parent = stack.pop()
            order.append(point)
            above.append(parent)
            number = len(order) - 1
            stack += [(int(q), number) for q in rng.permutation(near[point]) if parent < 0 or q != order[parent]]
    return np.array(order), np.array(above)


def make(kind, case, folder):
    """Writes the variant of a case; the function that puts its coordinates back."""
    points, parents, inlets, loops = read(case.folder)
    rng = np.random.default_rng(int(hashlib.md5(f"{case.data}/{case.level}/{case.name}".encode()).hexdigest()[:12], 16))
    back = np.asarray
    if kind == "scaled":
        points, inlets, back = points * 1000, inlets * 1000, lambda x: x / 1000
    elif kind == "rotated":
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        turn[0] *= np.linalg.det(turn)
        points, inlets, back = np.column_stack([points[:, :3] @ turn, points[:, 3]]), inlets @ turn, lambda x: x @ turn.T
    elif kind == "renumbered":
        order, parents = renumbered(parents, rng)
        place = np.argsort(order)
        points, loops = points[order], place[loops]
    write(folder, points, parents, inlets, loops)
    return back


def put_back(rows, back):
    """The rows of an answer in the coordinates of the original."""
    for row in rows:
        for side in "ab":
            at = back(np.array([float(row[side + axis + "_mm"]) for axis in "xyz"]))
            row.update({side + axis + "_mm": v for axis, v in zip("xyz", at)})
    return rows


def by_points(case, rows):
    """{pair of points of the original: (probability, kept)}; a pair that is there twice counts as its more probable bridge."""
    tree, out = cKDTree(np.array(json.loads((case.folder / "truth.json").read_text())["nodes"])[:, :3]), {}
    place = lambda row, side: tuple(np.round(tree.data[tree.query([float(row[side + axis + "_mm"]) for axis in "xyz"])[1]], 4))
    for row in rows:
        key = tuple(sorted((place(row, "a"), place(row, "b"))))
        now = float(row["probability"] or 0), int(float(row["kept"]))
        out[key] = max(now, out.get(key, (0.0, 0)))
    return out


def changes(case, before, after):
    """(kept bridges that differ, kept before, largest change of a probability)."""
    a, b = by_points(case, before), by_points(case, after)
    differ = sum(a.get(k, (0, 0))[1] != b.get(k, (0, 0))[1] for k in a.keys() | b.keys())
    return differ, sum(kept for _, kept in a.values()), max((abs(a.get(k, (0, 0))[0] - b.get(k, (0, 0))[0]) for k in a.keys() | b.keys()), default=0.0)
