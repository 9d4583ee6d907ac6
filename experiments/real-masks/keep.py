"""Would less probable candidates close more gaps? Other rules of what is kept, on the candidates of answers as they are; the table of rules in README.md.

    keep.py SKELBENCH WORK [--masks 001,002] [--seeds 1] [--simulated CASES ANSWERS]

WORK is the folder that run.sh kept: cases, and default with the answers. CASES holds scans of make_cases.py as level/subject, ANSWERS the folders that `willis infer` wrote for their
masks. The rule that ships must keep what willis kept, or the script ends. Rules differ in the least probability of a candidate that is kept for itself, each
free end once (`first`, 0.4), in a second least probability for candidates between two free ends that have no better one (`mutual`), and in the order of what joins parts, which comes after both.
"""
import argparse
import json
import sys
from pathlib import Path

import numpy as np
from scipy.sparse.csgraph import dijkstra

#: The rules: the least probabilities `first` and `mutual`, and what the score of a candidate that joins two parts is multiplied by, between two free ends and to the side of a vessel.
RULES = {
    "0.4 (ships)": (0.4, None, 1, 1), "0.3": (0.3, None, 1, 1), "0.4, mutual 0.3": (0.4, 0.3, 1, 1), "0.4, mutual 0.1": (0.4, 0.1, 1, 1),
    "0.4, end to end first": (0.4, None, 100, 1), "0.4, end to end twice": (0.4, None, 2, 1),
    "0.4, to a side last": (0.4, None, 1, 0.001), "0.4, to a side half": (0.4, None, 1, 0.5),
}
#: A candidate that joins two parts has at least this probability.
DOUBTFUL = 0.1


class Parts(dict):
    """Union-find over anything."""

    def find(self, x):
        root = x
        while self.setdefault(root, root) != root:
            root = self[root]
        while self[x] != root:
            self[x], x = root, self[x]
        return root

    def union(self, a, b):
        a, b = self.find(a), self.find(b)
        self[a] = b
        return a != b


def kept_by(rows, first, mutual, to_end, to_side):
    """Per row whether it is kept, as `--keep reconnect` does it with other least probabilities."""
    degree = {}
    for row in rows:
        for end in row["ends"] if row["origin"] == "observed" else []:
            degree[end] = degree.get(end, 0) + 1
    kept, used, best = [row["origin"] == "observed" for row in rows], set(), {}
    candidates = [n for n, row in enumerate(rows) if row["origin"] == "candidate"]
    free = {n: [end for end in rows[n]["ends"] if degree.get(end, 0) <= 1] for n in candidates}
    for n in candidates:
        for end in free[n]:
            best[end] = max(best.get(end, 0.0), rows[n]["p"])

    def keep(least, is_asked):
        for n in sorted((n for n in candidates if rows[n]["p"] > least and not kept[n] and is_asked(n)), key=lambda n: (-rows[n]["p"], n)):
            if not used & set(free[n]):
                used.update(free[n])
                kept[n] = True

    keep(first, lambda n: True)
    if mutual is not None:
        keep(mutual, lambda n: len(free[n]) == 2 and all(best[end] == rows[n]["p"] for end in free[n]))
    parts = Parts()
    for n, row in enumerate(rows):
        if kept[n]:
            parts.union(*row["ends"])
    least = {"contact": 0.0, "candidate": DOUBTFUL}
    score = lambda row: row["attached"] if row["origin"] == "contact" else row["p"]
    left = [n for n, row in enumerate(rows) if not kept[n] and row["p"] > 0 and score(row) >= least[row["origin"]]]
    times = lambda n: 1 if n not in free else to_end if len(free[n]) == 2 else to_side
    for n in sorted(left, key=lambda n: (-score(rows[n]) * times(n), n)):
        kept[n] = parts.union(*rows[n]["ends"])
    return kept


def answers_of(given):
    """Kind, name, folder of the answer, how lines are judged."""
    for mask in filter(None, given.masks.split(",")):
        for seed in given.seeds.split(","):

            def judge(lines, case=given.work / "cases" / f"{mask}-{seed}"):
                implant.S.read_graphml = lambda _: lines
                return implant.judge(case, "")

            yield "real", f"{mask}-{seed}", given.work / "default" / f"{mask}-{seed}", judge
    if given.simulated:
        cases, answers = given.simulated
        for truth in sorted(cases.glob("*/*/truth.json")):
            level, subject = truth.parts[-3:-1]
            yield level, subject, answers / level / subject, lambda lines, case=truth.parent: score.score(score.Case(case), lines)


def open_gaps(case, lines):
    """Of the gaps of a case that stay open, how many have both sides in one part of the answer, and how many not."""
    truth = json.loads((case / "truth.json").read_text())
    net = implant.Fixed(lines, truth["h"]).net
    near = lambda x: net.kd.query_ball_point(x, 3 * truth["h"]) or [int(net.kd.query(x)[1])]
    count = [0, 0]
    for gap in truth["gaps"]:
        a, b = near(gap["a"]), near(gap["b"])
        way = dijkstra(net.csr, directed=False, indices=a, limit=1.5 * gap["mm"] + 4)[:, b]
        if not np.isfinite(way).any():
            count[0 if {net.comp[x] for x in a} & {net.comp[x] for x in b} else 1] += 1
    return count


FIGURES = {"real": ("gaps_closed", "fusions_undone", "safe_lost", "cycles"), "": ("path", "nrun", "join_f1", "cut_recall", "cycles")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bench", "work"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--masks", default=",".join(f"{n:03}" for n in range(1, 11)))
    parser.add_argument("--seeds", default="1")
    parser.add_argument("--simulated", type=Path, nargs=2)
    given = parser.parse_args()
    global implant, score
    sys.path[:0] = [str(given.bench), str(Path(__file__).resolve().parent)]
    import causes
    import implant
    import score

    found, still = {}, [0, 0]
    for kind, name, folder, judge in answers_of(given):
        rows = list(causes.rows_of(folder))
        for rule, least in RULES.items():
            kept = kept_by(rows, *least)
            if rule == next(iter(RULES)) and kept != [row["kept"] for row in rows]:
                raise SystemExit(f"{folder}: willis kept other rows")
            lines = [(row["points"], *row["ends"], row["origin"]) for row, keeps in zip(rows, kept) if keeps]
            if kind == "real" and rule == next(iter(RULES)):
                still = np.add(still, open_gaps(given.work / "cases" / name, lines))
            figures = judge(lines)
            joins = sum(keeps and row["origin"] == "candidate" for row, keeps in zip(rows, kept))
            found.setdefault((kind, rule), []).append(figures | {"candidates kept": joins})
        print(kind, name, file=sys.stderr, flush=True)
    for kind in dict.fromkeys(kind for kind, _ in found):
        figures = (*FIGURES.get(kind, FIGURES[""]), "candidates kept")
        print(f"\n| {kind} | " + " | ".join(name.replace("_", " ") for name in figures) + " |\n" + "|---" * (len(figures) + 1) + "|")
        for (of, rule), rows in found.items():
            if of == kind:
                print(f"| {rule} | " + " | ".join("%.3f" % np.nanmean([row[name] for row in rows]) for name in figures) + " |")
    if sum(still):
        print("\nopen gaps with both sides in one part of the answer that ships: %d of %d" % (still[0], sum(still)))


if __name__ == "__main__":
    main()
