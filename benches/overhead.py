"""What Python adds: willis.infer on arrays against the library on the bytes of them, in turn. overhead.py FILE [SAMPLES [ROUNDS]].

Run in the root of the project with `willis` and NumPy installed; prints the least time of twenty, s, of each, and their ratio, for each round.
"""
import subprocess
import sys
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import willis

warnings.simplefilter("ignore")
samples = int(sys.argv[2]) if len(sys.argv) > 2 else 1000
rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 3
arrays = willis.read(sys.argv[1]).to_arrays()
points, edges, radii = (arrays[name] for name in ("coords", "edges", "radii"))


def python():
    start = time.perf_counter()
    willis.infer(willis.centerlines(points, edges, radii), samples=samples, progress=False)
    return time.perf_counter() - start


with tempfile.TemporaryDirectory() as folder:
    packed = Path(folder, "arrays.npz")
    np.savez(packed, coords=points, edges=edges, radii=radii)
    bench = ["cargo", "bench", "--quiet", "--locked", "--bench", "sampling", "--", "whole", packed, str(samples)]
    print("| library, s | Python, s | ratio |\n|---:|---:|---:|")
    for _ in range(rounds):
        library = float(subprocess.run(bench, check=True, capture_output=True, text=True).stdout)
        module = min(python() for _ in range(20))
        print(f"| {library:.4f} | {module:.4f} | {module / library:.3f} |")
