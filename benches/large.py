"""Large graphs, willis beside the best Python pipeline: large.py FOLDER > large.csv.

Both sample the same graphs: candidates open with probability 0.25, observed vessels certain. The pipeline draws its masks with
NumPy, assembles with NumPy, solves with the faster of SuperLU (scipy) and CHOLMOD (cvxopt, where it is installed), and takes the
forest of csgraph; nothing is timed but the samples. The two sides alternate, one thread each; the least of each counts.

BENCH names the benchmark program; WILLIS_LARGE a list of sizes (1000,10000,100000,1000000), WILLIS_LARGE_SECONDS how long each side
is timed a round (10). Of a million edges there is one round.
"""
import csv
import multiprocessing
import os
import subprocess
import sys
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

FIGURES = ["vessels", "uncertain", "solver", "forest", "compile_s", "ms", "worker", "shared", "residual", "peak_mb"]
FAMILIES = ["arterial", "capillary"]
ROUNDS = 3
# Seconds that a sample of the pipeline may take.
LIMIT = 60


def columns(path, names):
    import numpy as np
    with open(path) as lines:
        header = next(csv.reader(lines))
        at = [header.index(name) if name in header else None for name in names]
        return [np.array(c) for c in zip(*(["" if i is None else row[i] for i in at] for row in csv.reader(lines)))]


class Peer:
    """The pipeline on one graph."""

    def __init__(self, folder):
        import numpy as np
        a, b, length, radius, origin = columns(folder / "edges.csv", ["node_a", "node_b", "length_mm", "radius_mm", "origin"])
        role, pressure, resistance = columns(folder / "nodes.csv", ["role", "pressure_mmHg", "resistance_mmHg_s_per_mL"])
        self.n = len(role)
        self.a, self.b = a.astype(int), b.astype(int)
        self.length, self.radius = length.astype(float) * 1e-3, radius.astype(float) * 1e-3
        self.candidate = origin == "candidate"
        self.c = np.pi * self.radius**4 / (8 * 3.5e-3 * self.length)
        number = lambda texts: np.array([float(t) if t else np.nan for t in texts])
        pressure, resistance = number(pressure) * 133.322, number(resistance) * 133.322e6
        ground = (role == "outlet") & np.isnan(pressure) & np.isnan(resistance)
        self.fixed = np.where(ground, 0.0, pressure)
        self.shunt = np.where(np.isnan(resistance), 0.0, 1 / resistance)
        self.random = np.random.default_rng(0)
        self.solve = None

    def sample(self, solve):
        import numpy as np
        from scipy.sparse import coo_matrix, csr_matrix
        from scipy.sparse.csgraph import connected_components, minimum_spanning_tree
        open_ = ~self.candidate | (self.random.random(len(self.c)) < 0.25)
        a, b, c = self.a[open_], self.b[open_], self.c[open_]
        parts, label = connected_components(coo_matrix((np.ones(len(a)), (a, b)), shape=(self.n, self.n)), directed=False)
        known = ~np.isnan(self.fixed)
        grounded = np.zeros(parts, bool)
        grounded[label[known | (self.shunt > 0)]] = True
        free = ~known & grounded[label]
        row = np.full(self.n, -1)
        row[free] = np.arange(free.sum())
        ra, rb = row[a], row[b]
        diagonal = self.shunt[free].copy()
        right = np.zeros(len(diagonal))
        for here, there, other in ((ra, rb, b), (rb, ra, a)):
            inside = here >= 0
            diagonal += np.bincount(here[inside], c[inside], len(diagonal))
            to = inside & (there < 0)
            right += np.bincount(here[to], c[to] * self.fixed[other[to]], len(diagonal))
        both = (ra >= 0) & (rb >= 0)
        p = np.where(known, self.fixed, 0.0)
        p[free] = solve(diagonal, ra[both], rb[both], c[both], right)
        drop = p[a] - p[b]
        rho = c * drop**2 / (np.pi * self.radius[open_] ** 2 * self.length[open_])
        flows = np.abs(drop) > 1e-12 * np.maximum(np.abs(p[a]), np.abs(p[b]))
        graph = csr_matrix((1 / rho[flows], (a[flows], b[flows])), shape=(self.n, self.n))
        return minimum_spanning_tree(graph)

    def choose(self):
        """The faster solver of those that are installed and take no longer than LIMIT, in a process of its own that can be stopped."""
        best = None
        for solve in filter(None, (superlu, cholmod())):
            start = time.perf_counter()
            trial = multiprocessing.get_context("fork").Process(target=self.sample, args=(solve,))
            trial.start()
            trial.join(LIMIT)
            took = time.perf_counter() - start
            trial.kill()
            trial.join()
            if trial.exitcode == 0 and (best is None or took < best[0]):
                best = (took, solve)
        if best is None:
            sys.exit(f"no solver of the pipeline ends within {LIMIT} s")
        self.solve = best[1]

    def ms(self, seconds):
        least, begin, samples = float("inf"), time.perf_counter(), 0
        # The first one imports what it needs.
        while samples < 2 or time.perf_counter() - begin < seconds:
            start = time.perf_counter()
            self.sample(self.solve)
            least = min(least, 1e3 * (time.perf_counter() - start))
            samples += 1
        return least


def superlu(diagonal, i, j, c, right):
    import numpy as np
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import splu
    n = len(diagonal)
    k = np.arange(n)
    matrix = coo_matrix((np.concatenate([diagonal, -c, -c]), (np.concatenate([k, i, j]), np.concatenate([k, j, i]))), shape=(n, n))
    return splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}).solve(right)


def cholmod():
    try:
        from cvxopt import cholmod as library, matrix, spmatrix
    except ImportError:
        return None
    import numpy as np

    def solve(diagonal, i, j, c, right):
        n = len(diagonal)
        k = np.arange(n)
        low, high = np.minimum(i, j), np.maximum(i, j)
        values, rows, cols = np.concatenate([diagonal, -c]), np.concatenate([k, high]), np.concatenate([k, low])
        system = spmatrix(matrix(values), matrix(rows.astype(np.int64)), matrix(cols.astype(np.int64)), (n, n))
        answer = matrix(right)
        library.linsolve(system, answer)
        return np.array(answer).ravel()

    return solve


def measure(folder):
    bench = os.environ["BENCH"]
    sizes = [int(float(n)) for n in os.environ.get("WILLIS_LARGE", "1000,10000,100000,1000000").split(",")]
    seconds = float(os.environ.get("WILLIS_LARGE_SECONDS", "10"))
    out = csv.writer(sys.stdout)
    out.writerow(["family", "edges", "round", *FIGURES, "peer_ms", "peer", "cpu"])
    for family in FAMILIES:
        for size in sizes:
            here = folder / f"{family}-{size}"
            if not (here / "edges.csv").exists():
                here.mkdir(parents=True, exist_ok=True)
                subprocess.run(["target/release/willis", "phantom", family, "--edges", str(size), "--break", "-o", here / "edges.csv", "--quiet"], check=True)
            peer = Peer(here)
            peer.choose()
            for round_ in range(1, (ROUNDS if size < 1_000_000 else 1) + 1):
                ours = subprocess.run([bench, "large", here / "edges.csv", "auto", str(seconds)], check=True, capture_output=True, text=True)
                theirs = peer.ms(seconds)
                out.writerow([family, size, round_, *ours.stdout.strip().split(","), f"{theirs:.3f}", peer.solve.__qualname__.split(".")[0], processor()])
                sys.stdout.flush()


def processor():
    with open("/proc/cpuinfo") as lines:
        return next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), "")


if __name__ == "__main__":
    measure(Path(sys.argv[1]))
