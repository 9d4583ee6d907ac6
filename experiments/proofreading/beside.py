"""How often is a connection true beside one that a person accepts or rejects? Writes beside.csv and its table in README.md.

    beside.py SKELBENCH CASES WORK        CASES and WORK as those of measure.py, whose first answers are taken

Of candidates at a free end, and of contacts at the end of a single vessel: those beside a true one, and those beside a wrong one with P of .2 or more.
A candidate beside a true one counts if it leads on to yet another vessel, as two for one gap are no two connections.
"""
import collections
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common

BINS = (0, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1)
#: A wrong one that is less probable is hardly asked about.
ASKED = 0.2


def beside(case, rows, right):
    """(kind, whether the one was accepted, P of the other, whether that is true, its P if those at an end share that of the wrong one)"""
    places = lambda row: [[float(row[end + axis]) for axis in ("x_mm", "y_mm", "z_mm")] for end in "ab"]
    degree = collections.Counter(row[end] for row in rows if row["origin"].strip() == "observed" for end in ("node_a", "node_b"))
    at = collections.defaultdict(list)
    for row, yes in right.items():
        if yes is not None:
            for end in ("node_a", "node_b"):
                if degree[rows[row][end]] <= 1:
                    at[rows[row]["origin"].strip(), rows[row][end]].append(row)
    chance = lambda row: float(rows[row]["probability"])
    for (kind, _), those in at.items():
        for one in those:
            for other in those:
                if one != other and (right[one] or chance(one) >= ASKED):
                    another = kind == "contact" or not right[one] or case.match(*places(rows[one])) != case.match(*places(rows[other]))
                    yield kind, right[one], chance(other), right[other] and another, min(1.0, chance(other) / (1 - chance(one))) if chance(one) < 1 else 1.0


def main():
    bench, cases, work = map(Path, sys.argv[1:])
    sys.path.insert(0, str(bench))
    import proofread
    import score

    found = collections.defaultdict(list)
    for level in ("good", "fair"):
        for folder in sorted(path.parent for path in cases.glob(f"{level}/*/truth.json")):
            case = score.Case(folder)
            for kind, accepted, p, yes, shared in beside(case, *proofread.truth(case, work / level / folder.name / "0")):
                bin = next(at for at in range(len(BINS) - 1) if p < BINS[at + 1] or at == len(BINS) - 2)
                found[kind, bool(accepted), bin].append((p, bool(yes), shared))
    mean = lambda of, at: f"{sum(one[at] for one in of) / len(of):.3f}"
    rows = [
        {"of": kind, "beside": "accepted" if accepted else "rejected", "from": BINS[bin], "to": BINS[bin + 1], "count": len(of), "p": mean(of, 0), "true": mean(of, 1), "shared": "" if accepted else mean(of, 2)}
        for (kind, accepted, bin), of in sorted(found.items(), key=lambda item: (item[0][0], not item[0][1], item[0][2]))
    ]
    common.write_results(HERE, rows, "beside.csv")
    lines = [[row["of"], row["beside"], f"{row['from']} to {row['to']}", row["count"], row["p"], row["true"], row["shared"]] for row in rows]
    common.splice(HERE / "README.md", "beside", common.table(["of", "beside one", "P", "count", "P, mean", "true", "P / (1 - P of the rejected)"], lines))


if __name__ == "__main__":
    main()
