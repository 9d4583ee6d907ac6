"""How many kept joins have a free end within a voxel of the border of a cropped image. at_border.py FOLDER, as run.sh leaves it."""
import collections
import csv
import json
import sys
from pathlib import Path

work = Path(sys.argv[1])
print("| cases | answer | kept joins | from a free end at the border |\n|---|---|---|---|")
for level in ("good-crop", "fair-crop"):
    for name in ("mask-cut", "fragments"):
        joins = at = 0
        for case in sorted((work / "cases" / level).iterdir()):
            box = json.loads((case / "box.json").read_text())
            low, high = box["box_mm"]
            rows = list(csv.DictReader(open(work / name / level / case.name / "edges.csv")))
            degree = collections.Counter(row[f"node_{end}"] for row in rows if row["origin"] == "observed" for end in "ab")
            for row in rows:
                if row["origin"] != "candidate" or row["kept"] != "1":
                    continue
                joins += 1
                ends = [[float(row[f"{end}{axis}_mm"]) for axis in "xyz"] for end in "ab" if degree[row[f"node_{end}"]] == 1]
                away = min((min(x - a, b - x) for end in ends for x, a, b in zip(end, low, high)), default=float("inf"))
                at += away <= box["voxel_mm"]
        print(f"| {level.replace('-crop', ', cropped')} | {'mask' if name == 'mask-cut' else 'lines, `--box`'} | {joins} | {at} |")
