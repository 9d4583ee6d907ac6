"""Candidates and features of the reference model on made-up extractions: python reference.py SHARED OUT SUBJECT...

The benchmark's model.py and the formulas beside this file. A subject that ends in ~ is told no inlet.

Writes what both programs read (OUT/SUBJECT.swc, .loops.csv, .inlets.csv by id) and what the reference makes of it
(OUT/SUBJECT.bridges.csv: both ends, inside, features, feedback; OUT/SUBJECT.roots.csv; OUT/SUBJECT.names).

Points are moved off the voxel grid by a hair, so that no two distances are equal: ties are where the programs differ by design.
Lengths are written in a unit so small that the reference's absolute 1e-6 vanishes. PATCHES are the other differences by design:
what depends on the numbers of the points there depends on the anatomy here.
"""
import pathlib
import shutil
import subprocess
import sys
import types

import numpy as np

import formulas

SCALE = 1e7
PATCHES = [
    # A junction belongs to its widest branch, then to the longest, not to the one walked first. (Of the branches that
    # meet at a point, the tangent of an unfed junction is along that one, not along the first link.)
    ("        left = self.branch < 0\n", """        runs, mean, long = {}, {}, {}
        for s in np.flatnonzero(self.deg != 2):
            for x in self.adj[s]:
                run, prev = [s, x], s
                while self.deg[x] == 2:
                    prev, x = x, self.adj[x][0] if self.adj[x][0] != prev else self.adj[x][1]
                    run.append(x)
                runs.setdefault(tuple(sorted((run[0], run[-1]))) + tuple(sorted((run[1], run[-2]))), run)
        for key, run in runs.items():
            rank = (np.log(self.r[run]).mean(), np.linalg.norm(np.diff(self.xyz[run], axis=0), axis=1).sum())
            inner = self.branch[run[1]] if len(run) > 2 else None
            for end, second in ((run[0], run[1]), (run[-1], run[-2])):
                if self.deg[end] > 2 and (end not in mean or rank > mean[end]):
                    mean[end] = rank
                    long[end] = (run, second)
        label = {}
        for key, run in runs.items():
            ends = [x for x in (run[0], run[-1]) if self.deg[x] == 1]
            label[key] = self.branch[run[1]] if len(run) > 2 else (self.branch[ends[0]] if ends else nb)
            nb += len(run) == 2 and not ends
        for end, (run, second) in long.items():
            self.branch[end] = label[tuple(sorted((run[0], run[-1]))) + tuple(sorted((run[1], run[-2])))]
            self.adj[end].remove(second)
            self.adj[end].insert(0, second)
        left = self.branch < 0
"""),
    # Of two free ends near a meeting point the nearer one is met, not the first.
    ("        for f in at_end.get(int(g.branch[q]), ()):\n",
     "        for f in sorted(at_end.get(int(g.branch[q]), ()), key=lambda f: np.linalg.norm(g.xyz[f] - g.xyz[q])):\n"),
    # Free ends of other fragments are counted without those of the own one.
    ("min(len(g.ends), 4 * k + 8)", "len(g.ends)"),
]
# What is searched more than by model.py.
SEARCH = [
    ("K_BRANCH = 4 ", "K_BRANCH = 5 "),
    ("AHEAD = 2 ", "AHEAD = 3 "),
    ("!= mine][:k]", "!= mine][:4]"),
    ("                        picks.append((snap(idx[ring[np.argmax(cos[ring])]]), 2))\n", """                        one = ring[np.argmax(cos[ring])]
                        picks.append((snap(idx[one]), 2))
                        other = ring[np.linalg.norm(g.xyz[idx[ring]] - g.xyz[idx[one]], axis=1) > 4 * g.h]
                        if len(other):
                            picks.append((snap(idx[other[np.argmax(cos[other])]]), 3))
                    kink = np.einsum("ij,ij->i", g.kink[idx[same]], v[same]) / dist[same] * (off < 8 * g.h)
                    if kink.max() > .15:
                        picks.append((snap(idx[same[np.argmax(kink)]]), 1))
"""),
]


def patched(path):
    source = path.read_text()
    for old, new in PATCHES + SEARCH:
        assert source.count(old) == 1, old
        source = source.replace(old, new)
    module = types.ModuleType("model")
    exec(compile(source, str(path), "exec"), module.__dict__)
    return module


def off_the_grid(folder, out, subject):
    """The extraction moved by a hair, and without links that have no length."""
    a = np.loadtxt(folder / "fragments.swc", ndmin=2)
    rng = np.random.default_rng(0)
    a[:, 2:5] += rng.normal(scale=1e-3, size=(len(a), 3))
    a[:, 5] *= np.exp(rng.normal(scale=1e-3, size=len(a)))
    a[:, 2:6] *= SCALE
    lines = ["%d 0 %s %d" % (row[0], " ".join(repr(float(x)) for x in row[2:6]), row[6]) for row in a]
    (folder / "fragments.swc").write_text("\n".join(lines) + "\n")
    (out / (subject + ".swc")).write_text("\n".join(lines) + "\n")
    inlets = np.loadtxt(folder / "inlets.csv", delimiter=",", skiprows=1, ndmin=2) * SCALE
    np.savetxt(folder / "inlets.csv", inlets, delimiter=",", header="x_mm,y_mm,z_mm", comments="", fmt="%.17g")


def main():
    shared, out, subjects = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3:]
    model = patched(shared / "gapbench" / "model.py")
    for data, flags in (("brava/vtp", []), ("insist-cow", ["--phenotype", "--ring"])):
        subprocess.run([sys.executable, shared / "gapbench" / "make_cases.py", shared / "data" / data, out / "cases", "--levels",
                        "medium", "--seed", "5", "--subjects", ",".join(s.strip("~") for s in subjects), *flags], check=True, stdout=subprocess.DEVNULL)
    write = lambda name, rows: (out / name).write_text("".join(",".join(repr(float(x)) for x in row) + "\n" for row in rows))
    for subject in subjects:
        folder = out / "cases" / subject
        shutil.copytree(out / "cases" / "medium" / subject.strip("~"), folder)
        off_the_grid(folder, out, subject)
        if subject.endswith("~"):
            (folder / "inlets.csv").unlink()
        g = model.Pieces(folder)
        rows = model.candidates(g)
        ends = [(*g.xyz[g.ends[i]], *g.xyz[q], loop) for i, q, loop in rows]
        write(subject + ".inlets.csv", [[i + 1] for i in g.inlet_nodes])
        loops = folder / "loops.csv"
        (out / (subject + ".loops.csv")).write_text(loops.read_text().split("\n", 1)[1] if loops.exists() else "")
        x = formulas.bridge_features(g, rows, dict(zip(model.NAMES, model.features(g, rows).T)))
        z = formulas.root_features(g, dict(zip(model.ROOT, model.root_features(g).T)))
        between = np.array(rows)[:, 2] == 0
        # Any weights do.
        log_w = (x["kink"] - x["gap"] - x["bend_child_sq"])[between]
        y = formulas.feedback(g, rows, np.exp(log_w), np.exp(z["slim"] - 4))
        spread = np.zeros((len(rows), len(formulas.FEEDBACK)))
        spread[between] = np.column_stack([y[name] for name in formulas.FEEDBACK])
        write(subject + ".bridges.csv", np.column_stack([ends, *(x[name] for name in formulas.FEATURES), spread]))
        write(subject + ".roots.csv", np.column_stack([z[name] for name in formulas.ROOT]))
        (out / (subject + ".names")).write_text("\n".join(formulas.FEATURES + formulas.FEEDBACK + formulas.ROOT))


if __name__ == "__main__":
    main()
