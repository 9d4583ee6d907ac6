"""Is P of a contact true, would another scale make it truer, and what would `reconnect` keep by another scale? Writes scales.csv, carried.csv, weighed.csv and their tables in
README.md.

    scales.py SKELBENCH CASES WORK OTHERS        CASES and WORK as those of measure.py, whose first answers are taken

The scale is s(a + b l), l the log-odds of P: a = 0 and b = 1 change nothing. It is fitted to all cases of a level but one, and judged by that one, or to all of one level, and
judged by another. OTHERS has scans of other brains, cases/LEVEL/SUBJECT, to which a scale is fitted too. ECE has ten bins of .1, all contacts of a level together; "by chance" is
what P without any error would show on so many. A contact is given back where the answer keeps it, else cut.
Then contacts are weighed by other scales against candidates: all that is kept without them, the rest in that order while it joins two parts, as `reconnect` does.
"""
import collections
import sys
import tempfile
from pathlib import Path

import networkx as nx
import numpy as np
from scipy.optimize import minimize

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common
import measure

LEVELS = ("good", "fair", "real", measure.IMPLANTS)
BEST_FIRST, DOUBTFUL = 0.4, 0.1
#: So much is taken off the log-odds of P of a contact before it is compared with a candidate's.
OFF = (0, 1, 2)
BY_PARTITIONS = "by the partitions (ships)"


def logit(p):
    p = np.clip(p, 1e-9, 1 - 1e-9)
    return np.log(p / (1 - p))


def sigmoid(x):
    return 1 / (1 + np.exp(-x))


def fitted(p, one):
    """a and b that make the answers the most probable."""
    x, sign = logit(p), np.where(one, 1.0, -1.0)
    loss = lambda ab: np.logaddexp(0, -sign * (ab[0] + ab[1] * x)).mean() + 1e-5 * ab[1] ** 2
    return minimize(loss, [0.0, 1.0]).x


def ece(p, one):
    bins = np.minimum((p * 10).astype(int), 9)
    return sum(abs((p - one)[bins == k].sum()) for k in range(10)) / len(p)


class Answer:
    """The default answer to a case, whose contacts may be weighed anew."""

    def __init__(self, score, proofread, folder, work):
        self.score, self.folder, self.out = score, folder, work / "0"
        if not (self.out / "run.json").exists():
            proofread.infer(measure.WILLIS, folder, "mask.nii.gz", self.out)
        self.is_implants = folder.parent.name == measure.IMPLANTS
        if self.is_implants:
            person = measure.WhoPutIn(score, proofread, folder, work)
            self.case, right, self.figures_of = person.case, person.right, person.figures
        else:
            self.case = score.Case(folder)
            right = proofread.contact_truth(self.case, self.out)
        self.rows = common.rows(self.out / "edges.csv")
        self.graph = nx.read_graphml(self.out / "candidates.graphml", force_multigraph=True)
        self.edge = {data["edge"]: (a, b, key) for a, b, key, data in self.graph.edges(keys=True, data=True)}
        self.origin = [row["origin"].strip() for row in self.rows]
        self.p = np.array([float(row["probability"] or 0) for row in self.rows])
        self.kept = np.array([float(row["kept"] or 0) > 0 for row in self.rows])
        self.of_partitions = {data["edge"]: data["hangs_a"] + data["hangs_b"] for *_, data in self.graph.edges(data=True) if data["origin"] == "contact"}
        known = [row for row, yes in right.items() if yes is not None and self.origin[row] == "contact"]
        self.known, self.one = np.array(known, int), np.array([right[row] for row in known], bool)

    def kept_by(self, weight):
        """What is kept where a contact, a row, weighs so much."""
        degree = collections.Counter(row[end] for row, origin in zip(self.rows, self.origin) if origin == "observed" for end in ("node_a", "node_b"))
        ends = [(row["node_a"], row["node_b"]) for row in self.rows]
        kept, used = [origin == "observed" for origin in self.origin], set()
        candidates = [row for row, origin in enumerate(self.origin) if origin == "candidate"]
        for row in sorted((row for row in candidates if self.p[row] > BEST_FIRST), key=lambda row: (-self.p[row], row)):
            free = {end for end in ends[row] if degree[end] <= 1}
            if not free & used:
                used |= free
                kept[row] = True
        parts = nx.utils.UnionFind(end for pair in ends for end in pair)
        for row in np.flatnonzero(kept):
            parts.union(*ends[row])
        weighed = [(-weight(row), row) for row, origin in enumerate(self.origin) if origin == "contact"]
        weighed += [(-self.p[row], row) for row in candidates if not kept[row] and self.p[row] >= DOUBTFUL]
        for _, row in sorted(weighed):
            a, b = ends[row]
            if parts[a] != parts[b]:
                parts.union(a, b)
                kept[row] = True
        return np.array(kept)

    def figures(self, kept):
        graph = self.graph.copy()
        graph.remove_edges_from(edge for row, edge in self.edge.items() if not kept[row])
        with tempfile.TemporaryDirectory() as folder:
            nx.write_graphml(graph, f"{folder}/topology.graphml")
            if self.is_implants:
                return self.figures_of(Path(folder))
            found = self.score.score(self.case, *self.score.read_answer(Path(folder), self.case))
        return {name: found[name] for name in measure.FIGURES}


def known(answers):
    """P of the contacts of which the truth is known, whether they are one vessel, the case of each, and its probability by the partitions."""
    p, one = [np.concatenate(those) for those in zip(*((answer.p[answer.known], answer.one) for answer in answers))]
    by_partitions = np.array([answer.of_partitions[row] for answer in answers for row in answer.known])
    return p, one, np.repeat(np.arange(len(answers)), [len(answer.known) for answer in answers]), by_partitions


def scaled(p, one, case):
    """P by the scale of the other cases."""
    out = p.copy()
    for held in set(case):
        a, b = fitted(p[case != held], one[case != held])
        out[case == held] = sigmoid(a + b * logit(p[case == held]))
    return out


def reliability(level, answers):
    """Rows of scales.csv: of all contacts of a level, of those given back and those cut, and of each bin of P."""
    p, one, case, _ = known(answers)
    kept, by_others = np.concatenate([answer.kept[answer.known] for answer in answers]), scaled(p, one, case)
    rng = np.random.default_rng(0)
    bins = np.minimum((p * 10).astype(int), 9)
    sets = {"all": np.ones(len(p), bool), "given back": kept, "cut": ~kept} | {f"P .{k} to {(k + 1) / 10:g}": bins == k for k in range(10)}
    for name, those in sets.items():
        if those.any():
            q, yes, s = p[those], one[those], by_others[those]
            a, b = fitted(q, yes) if name[0] != "P" else (np.nan, np.nan)
            chance = np.mean([ece(q, rng.random(len(q)) < q) for _ in range(200)])
            numbers = {"p": q.mean(), "one": yes.mean(), "ece": ece(q, yes), "by_chance": chance, "a": a, "b": b, "p_scaled": s.mean(), "ece_scaled": ece(s, yes)}
            yield {"level": level, "of": name, "contacts": len(q)} | {key: "" if np.isnan(x) else f"{x:.3f}" for key, x in numbers.items()}


def carried(levels, others):
    """Rows of carried.csv: ECE of each level by the scale of each, and of other scans."""
    for of, (p, one, _, by_partitions) in (levels | {"other brains": others}).items():
        a, b = fitted(p, one)
        calibration = " ".join(f"{x:.3f}" for x in fitted(by_partitions, one))
        for judged, (q, yes, case, _) in levels.items():
            by = scaled(q, yes, case) if of == judged else sigmoid(a + b * logit(q))
            yield {"fitted to": of, "a": f"{a:.3f}", "b": f"{b:.3f}", "calibration": calibration, "judged on": judged, "ece": f"{ece(by, yes):.3f}"}


def weighed(level, answers):
    """Rows of weighed.csv: the figures of a level where contacts are weighed so, and how true the contacts are that are given back and that are cut."""
    ways = {BY_PARTITIONS: lambda answer: answer.of_partitions.get}
    ways |= {f"P, {off:g} off its log-odds" if off else "P": lambda answer, off=off: lambda row: sigmoid(logit(answer.p[row]) - off) for off in OFF}
    for name, way in ways.items():
        figures, given, cut, changed = [], [], [], 0
        for answer in answers:
            kept = answer.kept_by(way(answer))
            changed += int((kept != answer.kept).sum())
            figures.append(answer.figures(kept))
            given += answer.one[kept[answer.known]].tolist()
            cut += answer.one[~kept[answer.known]].tolist()
        if name == BY_PARTITIONS and changed:
            raise SystemExit(f"{level}: {changed} rows are not kept as the program keeps them")
        mean = {key: f"{np.nanmean([found[key] for found in figures]):.4f}" for key in figures[0]}
        yield from ({"level": level, "weighed": name, "figure": key, "value": value} for key, value in mean.items())
        counts = {"rows changed": changed, "given back": len(given), "of these one": sum(given), "cut": len(cut), "of these one vessel": sum(cut)}
        yield from ({"level": level, "weighed": name, "figure": key, "value": value} for key, value in counts.items())


def main():
    bench, cases, work, others = map(Path, sys.argv[1:])
    sys.path.insert(0, str(bench))
    import proofread
    import score

    def answers_to(cases, work):
        folders = sorted(path.parent for path in cases.glob("*/truth.json"))
        return [Answer(score, proofread, folder, work / folder.name) for folder in folders]

    scales, found, levels = [], [], {}
    for level in LEVELS:
        answers = answers_to(cases / level, work / level)
        levels[level] = known(answers)
        scales += reliability(level, answers)
        found += weighed(level, answers)
        print(level, file=sys.stderr)
    of_others = known([answer for folder in sorted((others / "cases").iterdir()) for answer in answers_to(folder, others / "answers" / folder.name)])
    common.write_results(HERE, scales, "scales.csv")
    common.write_results(HERE, list(carried(levels, of_others)), "carried.csv")
    common.write_results(HERE, found, "weighed.csv")


def table():
    rows = common.rows(HERE / "scales.csv")
    lines = [list(row.values()) for row in rows if row["a"]]
    names = ["level", "contacts", "count", "P, mean", "one vessel", "ECE", "ECE by chance", "a", "b", "P scaled, mean", "ECE scaled"]
    common.splice(HERE / "README.md", "scales", common.table(names, lines))
    of_bin = {(row["of"], row["level"]): f"{row['one']} of {row['contacts']}" for row in rows if not row["a"]}
    lines = [[bin.removeprefix("P "), *(of_bin.get((bin, level), "") for level in LEVELS)] for bin in dict.fromkeys(bin for bin, _ in sorted(of_bin))]
    common.splice(HERE / "README.md", "bins", common.table(["P", *LEVELS], lines))
    of_scale = collections.defaultdict(list)
    for row in common.rows(HERE / "carried.csv"):
        of_scale[row["fitted to"], row["a"], row["b"], row["calibration"]].append(row["ece"])
    common.splice(HERE / "README.md", "carried", common.table(["scale fitted to", "a", "b", "the same as a calibration", *(f"ECE on {level}" for level in LEVELS)], [[*key, *of] for key, of in of_scale.items()]))
    found = collections.defaultdict(dict)
    for row in common.rows(HERE / "weighed.csv"):
        found[row["level"], row["weighed"]][row["figure"]] = row["value"]
    lost = ("lost_connections", "safe_lost")
    of = {"weighed": [name for name in measure.FIGURES if name != "join_f1"], "weighed-implants": list(measure.OF_IMPLANTS)}
    counts = ["rows changed", "given back", "of these one", "cut", "of these one vessel"]
    for mark, columns in of.items():
        form = lambda figures, name: figures[name] if name in counts else f"{float(figures[name]):{'.1f' if name == 'cycles' else '.4f' if name in lost else '.3f'}}"
        lines = [[*key, *(form(figures, name) for name in [*columns, *counts])] for key, figures in found.items() if columns[0] in figures]
        told = [{"nrun": "run length", "cut_recall": "fusions undone", "of these one vessel": "of these one"}.get(name, name.replace("_", " ")) for name in [*columns, *counts]]
        common.splice(HERE / "README.md", mark, common.table(["level", "contacts weighed by", *told], lines))


if __name__ == "__main__":
    main()
    table()
