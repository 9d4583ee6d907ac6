"""Draws docs/src/answer.png and writes what README.md says of it: runs the main job and draws its input and its answer.

`docs/answer.py` draws, `docs/answer.py --check` fails where the picture or the words are not those of this version. Needs matplotlib.
WILLIS names a built willis; without it, cargo builds one.
"""
import hashlib
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
SCAN = ROOT / "data/broken-circle-of-willis.swc"
TRUTH = ROOT / "data/broken-circle-of-willis.truth.json"
PICTURE = ROOT / "docs/src/answer.png"
README = ROOT / "README.md"
TILT = math.radians(-45)  # seen from the front and from below, which opens the circle
WIDTH, HEIGHT = (-34, 34), (97, 182)  # mm on the picture, around the circle
NEAR = 5  # mm; a connection closes a gap when its ends are as near to those of the gap
CALM = 8  # so often each inner point moves half way to the middle of its neighbours; for display only
REACH = 6  # radii are averaged over as many radii to either side, as in summary.png
GRAPHML = "{http://graphml.graphdrawing.org/xmlns}"
WORDS = ["none", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"]


def topology():
    """The vessels of topology.graphml as the main job writes it, each a dictionary of its attributes, and how many connections are undecided."""
    willis = [os.environ["WILLIS"]] if "WILLIS" in os.environ else ["cargo", "run", "--release", "--"]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([*willis, "infer", SCAN, "-o", f"{folder}/out", "--quiet"], check=True, cwd=ROOT)
        root = ET.parse(f"{folder}/out/topology.graphml").getroot()
        undecided = json.loads(Path(f"{folder}/out/run.json").read_text())["convergence"]["undecided"]
    names = {key.get("id"): key.get("attr.name") for key in root.iter(f"{GRAPHML}key")}
    return [{names[data.get("key")]: data.text for data in edge} for edge in root.iter(f"{GRAPHML}edge")], undecided


def course(vessel):
    """x, y, z and radius along a vessel, mm."""
    return np.array([list(map(float, point.split())) for point in vessel["points"].split(";")])


def gaps():
    """The two points between which each gap of the test case lies."""
    rows = [line.split() for line in SCAN.read_text().splitlines() if not line.startswith("#")]
    place = {int(row[0]): tuple(map(float, row[2:5])) for row in rows}
    return [[place[point] for point in gap["ids"]] for gap in json.loads(TRUTH.read_text())["breaks"]]


def closes(vessel, gap):
    """Whether a connection leads from one side of a gap to the other."""
    points = course(vessel)[:, :3]
    ends = points[0], points[-1]
    return any(max(math.dist(a, p), math.dist(b, q)) < NEAR for a, b in (ends, ends[::-1]) for p, q in [gap])


def words(added, undecided):
    """What the README says of the picture."""
    right = [v for v in added if any(closes(v, gap) for gap in gaps())]
    wrong = sorted((float(v["probability"]) for v in added if v not in right), reverse=True)
    closed = sum(any(closes(v, gap) for v in added) for gap in gaps())
    left = f", and leaves {WORDS[undecided]} possible connection{'s' * (undecided != 1)} to a person" if undecided else ""
    said = f"willis closes {WORDS[closed]} of the {WORDS[len(gaps())]}{left}."
    if not wrong:
        return said
    which = "One connection that it makes is wrong; its probability is" if len(wrong) == 1 else f"{WORDS[len(wrong)].capitalize()} connections that it makes are wrong; their probabilities are"
    return f"{said} {which} {', '.join(f'{p:.2f}' for p in wrong)}."


def seen(points):
    """Where points in mm lie on the picture, and how near. Axes are RAS; the patient's right is on the left, as radiologists see it."""
    x, y, z = points[:, :3].T
    return np.stack([-x, z * math.cos(TILT) - y * math.sin(TILT)], 1), y * math.cos(TILT) + z * math.sin(TILT)


def smooth(points):
    """The radius along a vessel, averaged over REACH radii to either side."""
    steps = np.linalg.norm(np.diff(points[:, :3], axis=0), axis=1)
    along = np.concatenate([[0], np.cumsum(steps)])
    total = np.concatenate([[0], np.cumsum(steps * (points[1:, 3] + points[:-1, 3]) / 2)])
    half = REACH * points[:, 3].mean()
    low, high = np.maximum(along - half, 0), np.minimum(along + half, along[-1])
    return (np.interp(high, along, total) - np.interp(low, along, total)) / np.maximum(high - low, 1e-9)


def draw(panel, vessel, color, order):
    """The course of a vessel, as wide as it is; `color` of how near each piece is, in mm."""
    points = course(vessel)
    radius = smooth(points)
    for _ in range(CALM):
        points[1:-1, :3] += (points[:-2, :3] - 2 * points[1:-1, :3] + points[2:, :3]) / 4
    places, near = seen(points)
    pieces = np.stack([places[:-1], places[1:]], 1)
    dots = panel.get_window_extent().width / (WIDTH[1] - WIDTH[0]) * 72 / panel.figure.dpi  # a mm
    colors = [color(n) for n in (near[1:] + near[:-1]) / 2]
    panel.add_collection(LineCollection(pieces, linewidths=(radius[1:] + radius[:-1]) * 0.8 * dots, colors=colors, capstyle="round", zorder=order))


def picture(vessels, added):
    """The figure: before and after."""
    probability = plt.cm.ScalarMappable(plt.Normalize(0, 1), ListedColormap(plt.cm.viridis_r(np.linspace(1 / 9, 1, 256))))
    figure = plt.figure(figsize=(8, 4.6), dpi=110)
    before, after = figure.add_axes([0.01, 0.0, 0.43, 0.93]), figure.add_axes([0.45, 0.0, 0.43, 0.93])
    made = "1 connection" if len(added) == 1 else f"{len(added)} connections"
    for panel, title in ((before, f"extracted, with {len(gaps())} gaps"), (after, f"{made} restored by willis")):
        panel.set(xlim=WIDTH, ylim=HEIGHT, aspect="equal")
        panel.set_title(title, fontsize=11)
        panel.axis("off")
    figure.canvas.draw()
    for panel in (before, after):
        for vessel in vessels:
            if vessel["origin"] == "observed":
                draw(panel, vessel, lambda near: str(0.86 - 0.26 * min(max((near + 160) / 70, 0), 1)), 1)
        for gap in gaps():
            panel.add_patch(plt.Circle(seen(np.array(gap))[0].mean(axis=0), 4.5, fill=False, color="0.2", lw=0.8, ls=":", zorder=3))
    for vessel in added:
        draw(after, vessel, lambda _, color=probability.to_rgba(float(vessel["probability"])): color, 2)
    figure.colorbar(probability, cax=figure.add_axes([0.9, 0.2, 0.02, 0.5])).set_label("probability")
    return figure


def main():
    vessels, undecided = topology()
    added = [v for v in vessels if v["origin"] == "candidate"]
    # What is drawn, in so few digits that no processor differs.
    drawn = sorted([[round(float(x), 3) for x in course(v).ravel()], round(float(v["probability"]), 3) if v in added else None] for v in vessels)
    digest = hashlib.sha256(json.dumps(drawn).encode()).hexdigest()
    figure, said = picture(vessels, added), words(added, undecided)
    text = README.read_text()
    caption = re.compile(r"(Circles mark the gaps\.)\s.*?\s(`docs/answer\.py`)", re.DOTALL)
    told = re.sub(r"\s+", " ", caption.search(text).group(0))
    if "--check" in sys.argv[1:]:
        if Image.open(PICTURE).text.get("Description") != digest or said not in told:
            sys.exit(f"{PICTURE.relative_to(ROOT)} or its words in README.md are not those of this version ({said}); run docs/answer.py")
        return
    figure.savefig(PICTURE, pil_kwargs={"optimize": True}, metadata={"Description": digest})
    README.write_text(caption.sub(lambda m: f"{m.group(1)}\n{said}\n{m.group(2)}", text))
    print(f"{PICTURE.stat().st_size / 1000:.0f} kB; {said}")


if __name__ == "__main__":
    main()
