"""What the errors left in the last answer of each brain cost, in means over the brains of a level: skelbench's `budget.py`, which takes answers of one name.

    left.py SKELBENCH CASES ANSWERS LEVEL
"""
import collections
import sys
from pathlib import Path

import numpy as np

bench, cases, answers = map(Path, sys.argv[1:4])
sys.path.insert(0, str(bench))
import budget
import score

figures, why = collections.defaultdict(list), collections.Counter()
for folder in sorted((answers / sys.argv[4]).iterdir()):
    made = [path for path in folder.glob("*-*") if (path / "run.json").exists() and path.name.split("-")[0] in ("review", "right")]
    last = max(made, key=lambda path: (path.name.startswith("right"), int(path.name.split("-")[1])))
    found, counts, left = budget.budget(score.Case(cases / sys.argv[4] / folder.name), last)
    why.update(left)
    for name, row in [*found.items(), *((name, [count]) for name, count in counts.items())]:
        figures[name].append(row)
print("fusions left:", "; ".join(f"{count} {name}" for name, count in why.most_common()))
for name, rows in figures.items():
    print(f"{name:28}", " ".join(f"{x:6.3f}" for x in np.mean(rows, axis=0)))
