"""Draws docs/src/answer.png, the picture of the README: runs the main job and draws its input and its answer. Needs matplotlib."""
import json
import math
import os
import subprocess
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.collections import LineCollection

ROOT = Path(__file__).resolve().parent.parent
SCAN = ROOT / "data/broken-circle-of-willis.swc"
TRUTH = ROOT / "data/broken-circle-of-willis.truth.json"
TILT = math.radians(-45)  # seen from the front and from below, which opens the circle
WIDTH, HEIGHT = (-34, 34), (97, 182)  # mm on the picture, around the circle
GRAPHML = "{http://graphml.graphdrawing.org/xmlns}"


def topology():
    """The vessels of topology.graphml as the main job writes it, each a dictionary of its attributes."""
    willis = [os.environ["WILLIS"]] if "WILLIS" in os.environ else ["cargo", "run", "--release", "--"]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([*willis, "infer", SCAN, "-o", f"{folder}/out", "--quiet"], check=True, cwd=ROOT)
        root = ET.parse(f"{folder}/out/topology.graphml").getroot()
    names = {key.get("id"): key.get("attr.name") for key in root.iter(f"{GRAPHML}key")}
    return [{names[data.get("key")]: data.text for data in edge} for edge in root.iter(f"{GRAPHML}edge")]


def gaps():
    """The two points between which each gap of the test case lies."""
    rows = [line.split() for line in SCAN.read_text().splitlines() if not line.startswith("#")]
    place = {int(row[0]): tuple(map(float, row[2:5])) for row in rows}
    return [[place[point] for point in gap["ids"]] for gap in json.loads(TRUTH.read_text())["breaks"]]


def seen(x, y, z):
    """Where a point in mm lies on the picture. Axes are RAS; the patient's right is on the left, as radiologists see it."""
    return -x, z * math.cos(TILT) - y * math.sin(TILT)


def draw(panel, vessel, color, order):
    """The course of a vessel, half as wide as it is."""
    points = [tuple(map(float, point.split())) for point in vessel["points"].split(";")]
    pieces = [[seen(*a[:3]), seen(*b[:3])] for a, b in zip(points, points[1:])]
    dots = panel.get_window_extent().width / (WIDTH[1] - WIDTH[0]) * 72 / panel.figure.dpi  # a mm
    widths = [(a[3] + b[3]) / 2 * dots for a, b in zip(points, points[1:])]
    panel.add_collection(LineCollection(pieces, linewidths=widths, colors=[color], capstyle="round", zorder=order))


def main():
    vessels = topology()
    added = [v for v in vessels if v["origin"] == "candidate"]
    colors = plt.cm.ScalarMappable(plt.Normalize(0, 1), "plasma_r")
    figure = plt.figure(figsize=(8, 4.6), dpi=110)
    before, after = figure.add_axes([0.01, 0.0, 0.43, 0.93]), figure.add_axes([0.45, 0.0, 0.43, 0.93])
    for panel, title in ((before, f"extracted, with {len(gaps())} gaps"), (after, f"{len(added)} connections restored by willis")):
        panel.set(xlim=WIDTH, ylim=HEIGHT, aspect="equal")
        panel.set_title(title, fontsize=11)
        panel.axis("off")
    figure.canvas.draw()
    for panel in (before, after):
        for vessel in vessels:
            if vessel["origin"] == "observed":
                draw(panel, vessel, "0.55", 1)
        for a, b in gaps():
            middle = [(p + q) / 2 for p, q in zip(a, b)]
            panel.add_patch(plt.Circle(seen(*middle), 4.5, fill=False, color="0.2", lw=0.8, ls=":", zorder=3))
    for vessel in added:
        draw(after, vessel, colors.to_rgba(float(vessel["probability"])), 2)
    figure.colorbar(colors, cax=figure.add_axes([0.9, 0.2, 0.02, 0.5])).set_label("probability")
    figure.savefig(ROOT / "docs/src/answer.png", pil_kwargs={"optimize": True})


if __name__ == "__main__":
    main()
