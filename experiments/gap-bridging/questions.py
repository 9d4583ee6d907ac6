"""The other questions: what the flow adds, what may change without changing the answer, how well weights travel, loops, and other draws."""
import shutil

import bench
import command
import contest
import judge
import numpy as np
import variants

RANKINGS = ("random", "plain L", "L with A", "shortest gap", "frequency with A", "P alone")
# Orders that the figure of a random one is the mean of.
ORDERS = 50


def rankings(job):
    """Average precision of one case by each ranking; `job`: the case, its run with weights, its run without a prior."""
    case, with_prior, uniform = job
    rows = command.candidates(command.infer(with_prior))
    plain = command.candidates(command.infer(uniform))
    by = lambda column: judge.ranked(case, rows, column)
    for row in rows:
        row["shortness"] = -float(row["length_mm"])
    chance = []
    for order in np.random.default_rng(0).random((ORDERS, len(rows))):
        for row, at in zip(rows, order):
            row["place"] = at
        chance.append(by("place"))
    return [np.mean(chance), judge.ranked(case, plain, "likelihood"), by("likelihood"), by("shortness"), by("frequency"), by("probability")]


def flow(work, cases):
    """Average precision in random order, by plain L, by L with A, the shortest first, by how often a bridge is in the forest, and by P."""
    weights = command.by_fold(work)
    got = bench.each(rankings, [(c, (c, c.folder, weights[c.fold], work / "willis", True), (c, c.folder, "uniform", work / "uniform", True)) for c in cases])
    rows = []
    for data, level, at in contest.groups(cases):
        some = [cases[k] for k in at]
        for column, ranking in enumerate(RANKINGS):
            rows.append(("flow", data, level, ranking, "AP", judge.mean(some, [got[k][column] for k in at])))
        rows.append(("flow", data, level, "frequency - P", "AP", judge.mean(some, [got[k][-2] - got[k][-1] for k in at])))
    return rows


def varied(job):
    """What a variant of one case changes."""
    kind, case, weights, work = job
    folder = case.within(work / "variants" / kind)
    back = variants.make(kind, case, folder)
    before = command.candidates(command.infer((case, case.folder, weights, work / "willis", True)))
    after = variants.put_back(command.candidates(command.infer((case, folder, weights, work / kind, True))), back)
    shutil.rmtree(folder)
    return variants.changes(case, before, after), judge.ranked(case, before, "probability"), judge.ranked(case, after, "probability")


def invariance(work, cases):
    """Decisions of the same extraction scaled, turned and renumbered: at most 40 cases a data set, medium damage."""
    weights, rows = command.by_fold(work), []
    for data in ("brains", "circles"):
        some = [c for c in cases if (c.data, c.level) == (data, "medium") and (data == "brains" or c.name.endswith("_0"))]
        for kind in variants.KINDS if some else ():
            got = bench.each(varied, [(kind, c, weights[c.fold], work) for c in some])
            differ, kept, most = np.array([change for change, _, _ in got], float).T
            exact = lambda v: (v, v, v, len(some))
            rows += [
                ("robust", data, "medium", kind, "AP", judge.mean(some, [after for _, _, after in got])),
                ("robust", data, "medium", kind, "AP difference", judge.mean(some, [after - before for _, before, after in got])),
                ("robust", data, "medium", kind, "kept", exact(kept.sum())),
                ("robust", data, "medium", kind, "kept that differ", exact(differ.sum())),
                ("robust", data, "medium", kind, "same decisions", exact((differ == 0).sum())),
                ("robust", data, "medium", kind, "largest change of P", exact(most.max())),
            ]
    return rows


def elsewhere(work, cases, kind, data, level, weights, inlets=True):
    """Willis under another condition beside willis as it is, on the same cases."""
    some = [c for c in cases if (c.data, c.level) == (data, level)]
    if not some:
        return []
    here = contest.willis(work, some, kind.replace(" ", "-"), weights, inlets)
    usual = contest.willis(work, some)
    rows = []
    for figure, key in (("AP", "ap"), ("F1", "f1"), ("path", "path_after"), ("exact", "phenotype_exact")):
        if key in here[0]:
            rows.append(("robust", data, level, kind, figure, judge.mean(some, [r[key] for r in here])))
            rows.append(("robust", data, level, kind, figure + " difference", judge.mean(some, [a[key] - b[key] for a, b in zip(here, usual)])))
    return rows


def robust(work, cases):
    """Without inlets, told differently, and with weights from other damage or other tracings."""
    usual = command.by_fold(work)
    easy = command.by_fold(work, "easy", lambda case: case.level == "easy")
    rows = invariance(work, cases)
    for data in ("brains", "circles"):
        rows += elsewhere(work, cases, "no inlets", data, "medium", usual, inlets=False)
        rows += elsewhere(work, cases, "trained on easy", data, "hard", easy)
        source = "insist" if data == "brains" else "brains"
        sets = bench.SOURCES[source]
        other = command.train(work, f"{source}-only", lambda case: case.data in sets, folds=0)
        rows += elsewhere(work, cases, f"trained on {source}", data, "medium", [other] * bench.FOLDS)
    return rows


def loops(work, cases):
    """Bridges within one piece, of willis and of forest2; on many draws of the rings, for true ones are rare."""
    contest.baselines(work, contest.ALL)
    cases = [case for case in cases if case.data != "rings"] + bench.many_rings(work, cases)
    results = {"willis": contest.willis(work, cases), "forest2": bench.each(contest.forest2, cases)}
    wanted, rows = list(contest.groups(cases)), []
    for data in dict.fromkeys(data for data, _, _ in wanted):
        wanted.append((data, "all", [k for d, _, at in wanted if d == data for k in at]))
    for data, level, at in wanted:
        some = [cases[k] for k in at]
        for method, got in results.items():
            inside = [got[k]["inside"] for k in at]
            for column, figure in enumerate(("true", "found", "false")):
                total = sum(row[column] for row in inside)
                rows.append(("loops", data, level, method, figure, (total, total, total, len(at))))
            share = judge.estimate(some, [row[:2] for row in inside], lambda s: s[..., 1] / s[..., 0]) if sum(row[0] for row in inside) else None
            rows.append(("loops", data, level, method, "found of true", share))
            rows.append(("loops", data, level, method, "false a case", judge.mean(some, [row[2] for row in inside])))
    return rows


def draws(work, cases):
    """The circles of other draws of the damage, those that weights are trained on: each subject by the weights that never saw it."""
    circles, rows = [c for c in cases if c.data == "circles"], []
    seeds = {int((work / "cases" / "seed").read_text()): (circles, contest.willis(work, circles))}
    for seed, found in bench.training(work).items():
        some = [c for c in found if c.data == "circles" and c.subject in {c.subject for c in circles}]
        seeds[seed] = some, contest.willis(work, some, f"willis-{seed}")
    for level in bench.LEVELS:
        at = lambda pair: [(c, r) for c, r in zip(*pair) if c.level == level]
        several = {f"seed {seed}": at(pair) for seed, pair in seeds.items()}
        several["all"] = [both for found in several.values() for both in found]
        for name, found in several.items():
            some, results = zip(*found)
            rows += [("draws", "circles", level, name, figure, e) for figure, e in contest.estimates(some, results).items()]
    return rows
