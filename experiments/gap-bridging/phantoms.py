"""How far P of joins can be believed on drawn arteries: phantoms.py infers `willis phantom cerebral --break` of seeds that no calibration saw, and
writes the table of README.md. WILLIS names another willis to try, whose table is only printed; needs numpy and scipy."""
import csv
import json
import os
import sys
import tempfile
from pathlib import Path

sys.path[:0] = [str(Path(__file__).resolve().parent.parent)]
import bench
import common
import numpy as np

README = Path(__file__).resolve().parent / "README.md"
SEEDS = range(100, 160)
DOUBT = 0.05, 0.95


def ends(row):
    return [np.array([float(row[f"{end}{axis}_mm"]) for axis in "xyz"]) for end in "ab"]


def places(case):
    """Per gap of a phantom its two ends with how far from each a candidate may attach, mm: the rule of gapbench and of `willis train`."""
    points = {int(at[0]): at for at in (line.split() for line in (case / "fragments.swc").read_text().splitlines()) if at and at[0] != "#"}
    position = {id: np.array(at[2:5], float) for id, at in points.items()}
    links = [(id, int(at[6])) for id, at in points.items() if int(at[6]) > 0]
    degree = {id: sum(id in link for link in links) for id in points}
    step = np.median([np.linalg.norm(position[a] - position[b]) for a, b in links])
    for gap in json.loads((case / "truth.json").read_text())["breaks"]:
        length = np.linalg.norm(np.subtract(*(position[id] for id in gap["ids"])))
        yield [(position[id], 2 * step if degree[id] < 2 else max(3 * step, 2 * float(points[id][5]), .75 * length)) for id in gap["ids"]]


def candidates(job):
    """P of each candidate, and whether it closes a gap that is one."""
    folder, seed = job
    bench.phantom(job)
    common.willis("infer", folder / "fragments.swc", "-o", folder / "run", "-n", 1, "--dpi", 36)
    gaps = list(places(folder))
    reaches = lambda from_, to: all(np.linalg.norm(point - place) <= reach + 1e-6 for point, (place, reach) in zip(from_, to))
    right = lambda pair: any(reaches(pair, gap) or reaches(pair[::-1], gap) for gap in gaps)
    with open(folder / "run/edges.csv", newline="") as file:
        return [(float(row["probability"]), right(ends(row))) for row in csv.DictReader(file) if row["origin"] == "candidate"]


def main():
    with tempfile.TemporaryDirectory(prefix="phantoms-") as scratch:
        found = common.everywhere(candidates, [(Path(scratch) / str(seed), seed) for seed in SEEDS])
    p, right = np.array([row for rows in found for row in rows], float).T
    tenth = np.minimum((10 * p).astype(int), 9)
    error = lambda of: sum(abs((p - right)[of & (tenth == k)].sum()) for k in range(10)) / of.sum()
    lines = [[f".{k} to {k + 1 < 10 and '.' + str(k + 1) or 1}", of.sum(), f"{p[of].mean():.2f}", f"{right[of].mean():.2f}"] for k in range(10) if (of := tenth == k).any()]
    text = common.table(["P", "candidates", "mean P", "right"], lines)
    text += f"\n\nCalibration error {error(p >= 0):.3f}, of those with .05 < P < .95 {error((DOUBT[0] < p) & (p < DOUBT[1])):.3f}."
    print(text)
    if "WILLIS" not in os.environ:
        common.splice(README, "phantoms", text)
    common.made_with("gap-bridging", "phantoms")


if __name__ == "__main__":
    main()
