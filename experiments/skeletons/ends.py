"""Kept joins of masks by where their ends lie. ends.py BENCH FOLDER, as run.sh leaves it.

The benchmark knows a join by the voxels of scikit-image's skeleton that its ends are on, or within one voxel of. A vessel that
willis follows further into the same lumen ends beyond that, and a join from there counts as wrong, whatever it joins.
"""
import csv
import sys
from pathlib import Path

bench, work = sys.argv[1], Path(sys.argv[2])
sys.path.insert(0, bench)
import score  # noqa: E402

WITHIN = 4  # voxels
print(f"| cases | kept joins | right by the benchmark | ends off its skeleton, within {WITHIN} voxels of both ends of a true one | other |\n|---|---|---|---|---|")
for level in ("good", "fair"):
    joins = right = beyond = 0
    for folder in sorted((work / "cases" / level).iterdir()):
        case = score.Case(folder)
        sites = score.cKDTree(case.xyz[list(case.site)])
        links = list(case.site.values())
        for row in csv.DictReader(open(work / "mask-cut" / level / folder.name / "edges.csv")):
            if row["origin"] != "candidate" or row["kept"] != "1":
                continue
            ends = [[float(row[f"{end}{axis}_mm"]) for axis in "xyz"] for end in "ab"]
            joins += 1
            if isinstance(case.match(*ends), tuple):
                right += 1
                continue
            near = [[link for k in sites.query_ball_point(end, WITHIN * case.h) for link in links[k]] for end in ends]
            is_true = any(g == h and m != n for g, m in near[0] for h, n in near[1])
            beyond += is_true and max(case.kd.query(ends)[0]) > case.h
    print(f"| {level} | {joins} | {right} | {beyond} | {joins - right - beyond} |")
