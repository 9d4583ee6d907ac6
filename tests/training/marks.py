"""What the benchmark's own scorer takes for right: python marks.py SHARED OUT [SUBJECT...]

With subjects: makes their cases in OUT/brava and OUT/ring. Without: reads pairs of positions (mm) from OUT/pairs.csv (case folder,
ax, ay, az, bx, by, bz) and writes link, piece, piece, -1 where it makes none, to OUT/marks.csv.
"""
import csv
import json
import pathlib
import subprocess
import sys

shared, out, subjects = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2]), sys.argv[3:]
if subjects:
    for data, name, flags in (("brava/vtp", "brava", []), ("insist-cow", "ring", ["--phenotype", "--ring"])):
        subprocess.run([sys.executable, shared / "gapbench" / "make_cases.py", shared / "data" / data, out / name, "--levels", "hard",
                        "--seed", "5", "--subjects", ",".join(subjects), *flags], check=True, stdout=subprocess.DEVNULL)
else:
    sys.path.insert(0, str(shared / "gapbench"))
    import score
    cases = {}
    with open(out / "marks.csv", "w") as marks:
        for row in csv.reader(open(out / "pairs.csv")):
            if row[0] not in cases:
                cases[row[0]] = score.Case(json.loads((out / row[0] / "truth.json").read_text()))
            x = [float(v) for v in row[1:]]
            match = cases[row[0]].match(x[:3], x[3:]) or (-1, -1, -1)
            marks.write("%d,%d,%d\n" % match)
    print(*[cases[k].n_links for k in sorted(cases)])
