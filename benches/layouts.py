#!/usr/bin/env python3
"""Runs willis on layouts that are hard for searches, eliminations and tables, and prints CPU seconds and MB of each as a table.

    layouts.py WILLIS [LAYOUT...]
    layouts.py WILLIS --growth [LAYOUT...]

With `--growth` layouts of doubling sizes are inferred, and the table has the exponents by which time and memory grow.
"""

import math
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path


def swc(path, runs):
    """Writes runs of points (x, y, z, r), each a tree of its own unless it begins with the number of its parent."""
    number = 0
    with path.open("w") as out:
        for parent, points in runs:
            for point in points:
                number += 1
                out.write(f"{number} 0 {' '.join(f'{x:.6g}' for x in point)} {parent}\n")
                parent = number


def line(start, step, count, radius=0.5):
    return [(*(a + i * s for a, s in zip(start, step)), radius) for i in range(count)]


def long_vessel():
    """One vessel of 200,000 points on a helix."""
    return [(-1, [(20 * math.cos(i / 50), 20 * math.sin(i / 50), i / 200, 0.5) for i in range(200_000)])]


def dust(count=100_000, apart=200.0):
    """Fragments of three points, out of each other's reach."""
    side = round(count ** (1 / 3)) + 1
    at = lambda i: (apart * (i % side), apart * (i // side % side), apart * (i // side**2))
    return [(-1, line(at(i), (0.5, 0, 0), 3)) for i in range(count)]


def hub():
    """500 vessels that end at one place, with a gap of 2 mm."""
    runs = []
    for i in range(500):
        z = 1 - 2 * (i + 0.5) / 500
        phi, rho = 2.4 * i, math.sqrt(1 - z * z)
        way = (rho * math.cos(phi), rho * math.sin(phi), z)
        runs.append((-1, line([4 * x for x in way], [0.5 * x for x in way], 10)))
    return runs


def ball():
    """2,000 fragments of five points anywhere in a ball of 40 mm."""
    draw, runs = random.Random(1), []
    for _ in range(2000):
        way = [draw.gauss(0, 1) for _ in range(3)]
        size = math.hypot(*way)
        at = [40 * draw.random() ** (1 / 3) * x / size for x in way]
        runs.append((-1, line(at, [0.4 * draw.gauss(0, 1) for _ in range(3)], 5, 0.3)))
    return runs


def comb():
    """A straight vessel with 2,000 teeth, each 1 mm away from it."""
    return [(-1, line((0, 0, 0), (0.5, 0, 0), 8000))] + [(-1, line((2 * i, 2, 0), (0, 0.5, 0), 8)) for i in range(2000)]


def grid():
    """2,500 short vessels on the voxels of a grid, so that all distances are equal."""
    return [(-1, line((6 * (i % 50), 6 * (i // 50), 0), (1, 0, 0), 4)) for i in range(2500)]


def parallel():
    """1,000 vessels side by side, of 40 points each."""
    return [(-1, line((0, 1.5 * (i % 32), 1.5 * (i // 32)), (0.5, 0, 0), 40)) for i in range(1000)]


def near():
    """20,000 fragments of three points, 5 mm apart."""
    return dust(20_000, 5.0)


def fewer_near():
    """10,500 fragments of three points, 5 mm apart."""
    return dust(10_500, 5.0)


def near_with_max_gap():
    """20,000 fragments of three points, 5 mm apart, with `--max-gap 4.999`."""
    return near()


def near_without_evidence():
    """20,000 fragments of three points, 5 mm apart, with `--prior none`."""
    return near()


def fragment(draw, start, radius=0.5):
    """Four points in a random direction."""
    way = [draw.gauss(0, 1) for _ in range(3)]
    size = math.hypot(*way)
    return (-1, line(start, [0.5 * x / size for x in way], 4, radius))


def along_a_line(count=8000):
    """Fragments of four points along one line, with gaps of 2 mm."""
    return [(-1, line((5 * i, 0, 0), (1, 0, 0), 4)) for i in range(count)]


def wide(count=4000):
    """The same with radii of 5 mm."""
    return [(-1, line((5 * i, 0, 0), (1, 0, 0), 4, 5.0)) for i in range(count)]


def box(count=5000):
    """Fragments of four points anywhere in a box, as many in each cubic millimetre at any size."""
    draw, side = random.Random(1), 8 * count ** (1 / 3)
    return [fragment(draw, [side * draw.random() for _ in range(3)]) for _ in range(count)]


def crowd(count=10_000):
    """10,000 fragments of four points in a box of 5 mm."""
    draw = random.Random(1)
    return [fragment(draw, [5 * draw.random() for _ in range(3)]) for _ in range(count)]


def small_crowd():
    """3,000 fragments of four points in a box of 5 mm."""
    return crowd(3000)


# What else the command says of a layout.
OPTIONS = {near_with_max_gap: ["--max-gap", "4.999"], near_without_evidence: ["--prior", "none"]}


def star(path, leaves=100_000):
    """A graph of one node with 100,000 leaves, below which there is a page."""
    rows = "".join(f"0,{i},10,{0.5 + 0.0001 * (i % 100):.4f}\n" for i in range(1, leaves + 1))
    path.write_text("node_a,node_b,length_mm,radius_mm\n" + rows)
    return ["-n", "64", "--inlet", "1=100mmHg"]


def wheel(path):
    """A graph of a ring of 20,000 nodes, each joined to the middle."""
    rows = "".join(f"0,{i},10,0.5\n{i},{i % 20_000 + 1},5,0.4\n" for i in range(1, 20_001))
    path.write_text("node_a,node_b,length_mm,radius_mm\n" + rows)
    return ["-n", "64", "--inlet", "1=100mmHg", "--outlet", "10000=0mmHg"]


def large_star(path, leaves=1_000_000):
    """A graph of one node with a million leaves."""
    return star(path, leaves)


def arterial(path, edges=1_000_000):
    """An arterial tree of a million vessels with gaps, as `willis phantom` draws it."""
    subprocess.run([WILLIS, "phantom", "arterial", "--edges", str(edges), "--break", "-o", str(path), "--force", "-q"], check=True)
    return ["-n", "64"]


GRAPHS = {star: "csv", wheel: "csv", large_star: "csv", arterial: "graphml"}
FRAGMENTS = (long_vessel, dust, hub, ball, comb, grid, parallel, near, fewer_near, near_with_max_gap, near_without_evidence, crowd, small_crowd)
# Layouts that grow, with the smallest size and how often it is doubled.
GROWTH = {along_a_line: (4000, 3), wide: (2000, 3), box: (2500, 2), large_star: (125_000, 3), arterial: (125_000, 3)}


def run(layout, folder, size=None):
    """CPU seconds, MB, and what the command said if it failed."""
    sizes = [] if size is None else [size]
    if layout in GRAPHS:
        source = folder / f"a.{GRAPHS[layout]}"
        words = ["infer", str(source), *layout(source, *sizes), "-o", str(folder / "out"), "--force", "-q"]
    else:
        source = folder / "a.swc"
        swc(source, layout(*sizes))
        words = ["candidates", str(source), *OPTIONS.get(layout, []), "-o", str(folder / "a.graphml"), "--force", "-q"]
        if size is not None:
            words = ["infer", str(source), "-n", "64", "-o", str(folder / "out"), "--force", "-q"]
    child = subprocess.Popen([WILLIS, *words], stderr=subprocess.PIPE, text=True)
    said = child.stderr.read().strip().splitlines()
    _, status, used = os.wait4(child.pid, 0)
    end = "done" if status == 0 else said[-1] if said else f"status {status}"
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024, end


def growth(named, folder):
    print("| layout | what | sizes | CPU s | exponent | MB | kB for each one more |\n|---|---|---|---|---|---|---|", flush=True)
    for layout, (least, doublings) in GROWTH.items():
        if named and layout.__name__ not in named:
            continue
        sizes = [least * 2**i for i in range(doublings + 1)]
        seconds, peaks, ends = zip(*(run(layout, folder, size) for size in sizes))
        assert set(ends) == {"done"}, ends
        # Of the last doubling, where what every run takes counts least.
        exponent = math.log2(seconds[-1] / seconds[-2])
        each = 1024 * (peaks[-1] - peaks[-2]) / (sizes[-1] - sizes[-2])
        listed = lambda values, form: " / ".join(format(value, form) for value in values)
        what = layout.__doc__.strip().rstrip(".")
        figures = f"{listed(sizes, ',')} | {listed(seconds, '.1f')} | {exponent:.2f} | {listed(peaks, '.0f')} | {each:.2f}"
        print(f"| {layout.__name__.replace('_', ' ')} | {what} | {figures} |", flush=True)


def main():
    global WILLIS
    WILLIS = str(Path(sys.argv[1]).resolve())
    named = [word for word in sys.argv[2:] if word != "--growth"]
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        if "--growth" in sys.argv:
            return growth(named, folder)
        print("| layout | what | CPU s | MB | end |\n|---|---|---|---|---|", flush=True)
        for layout in (*FRAGMENTS, *GRAPHS):
            if named and layout.__name__ not in named:
                continue
            seconds, peak, end = run(layout, folder)
            what = layout.__doc__.strip().rstrip(".")
            print(f"| {layout.__name__.replace('_', ' ')} | {what} | {seconds:.1f} | {peak:.0f} | {end} |", flush=True)


if __name__ == "__main__":
    main()
