"""The first question: willis and all other methods on subjects that they have not seen."""
import pickle

import bench
import command
import judge
import learned
import rules

METHODS = ("willis", "forest2", "boosting", "geometry", "tubetk", "heal", "MST")
FIGURES = {
    "AP": "ap", "ceiling": "ceiling", "bridges a case": "n_candidates", "F1": "f1", "precision": "precision", "recall": "recall", "path": "path_after",
    "false length fed": "fed_spurious", "ECE": "ece_uncertain", "floor": "floor", "pooled ECE": None, "exact": "phenotype_exact", "present": "present_found", "absent": "absent_kept_absent",
}
# Every judged case of the run: what the other methods are fitted on even where a part looks at some only.
ALL = []
# Results of willis by (folder of answers, case).
KNOWN = {}
# What the other processes read.
LEARNT, LIMITS = {}, {}


def others(case):
    """{method: what judge says} of one case, willis apart."""
    answers = rules.answers(case, LIMITS) | learned.answers(case, LEARNT)
    return {method: judge.judge(case, rows) for method, rows in answers.items()}


def baselines(work, cases):
    """{method: results in the order of the cases}, limits, what was learnt; kept in the work folder."""
    kept = work / "baselines.pickle"
    if not kept.exists():
        LEARNT.update(learned.train(cases))
        LIMITS.update(rules.limits(cases))
        results = bench.each(others, cases)
        with open(kept, "wb") as file:
            pickle.dump(({method: [r[method] for r in results] for method in METHODS[1:]}, dict(LIMITS), dict(LEARNT)), file)
    with open(kept, "rb") as file:
        results, limits, learnt = pickle.load(file)
    LEARNT.update(learnt)
    return results, limits


def own(job):
    """What judge says of willis on one case."""
    path = command.infer(job)
    rows = command.candidates(path)
    if not all(row["probability"] for row in rows):
        raise SystemExit(f"{path}: a candidate without a probability, so that score.py would rank by likelihood")
    return judge.judge(job[0], rows) | {"floor": judge.floor(rows)}


def willis(work, cases, out="willis", weights=None, inlets=True):
    """Results of willis in the order of the cases, with the weights of each case's fold."""
    weights, fresh = weights or command.by_fold(work), [case for case in cases if (out, case) not in KNOWN]
    results = bench.each(own, [(case, case.folder, weights[case.fold], work / out, inlets) for case in fresh])
    KNOWN.update({(out, case): result for case, result in zip(fresh, results)})
    return [KNOWN[out, case] for case in cases]


def estimates(cases, results, less=None):
    """{figure: (value, low, high, cases)} of results, or of their difference from others."""
    out = {}
    for name, key in FIGURES.items():
        if key is None:
            out[name] = judge.pooled(cases, results, less)
        elif less is None:
            out[name] = judge.mean(cases, [r.get(key) for r in results])
        else:
            out[name] = judge.mean(cases, [None if a.get(key) is None or b.get(key) is None else a[key] - b[key] for a, b in zip(results, less)])
    return out


def forest2(case):
    """What judge says of forest2 on one case."""
    return judge.judge(case, learned.reference(case, LEARNT))


def groups(cases):
    """(data, level, places of its cases)."""
    for data in dict.fromkeys(case.data for case in cases):
        for level in bench.LEVELS:
            at = [k for k, case in enumerate(cases) if (case.data, case.level) == (data, level)]
            if at:
                yield data, level, at


def run(work, cases):
    """Rows of results, and what the figures are drawn from."""
    results = {"willis": willis(work, cases)}
    rest, limits = baselines(work, cases)
    results |= rest
    rows = []
    for data, level, at in groups(cases):
        some = [cases[k] for k in at]
        pick = lambda method: [results[method][k] for k in at]
        for method in METHODS:
            rows += [("main", data, level, method, figure, e) for figure, e in estimates(some, pick(method)).items() if e]
        rows += [("main", data, level, "willis - forest2", figure, e) for figure, e in estimates(some, pick("willis"), pick("forest2")).items() if e]
    for sets in [(data,) for data in bench.SETS] + [bench.SOURCES["insist"]]:
        at = [k for k, case in enumerate(cases) if case.data in sets]
        for method in METHODS:
            error = judge.pooled([cases[k] for k in at], [results[method][k] for k in at])
            rows += [("main", " and ".join(sets), "all", method, "pooled ECE", error)] if error else []
    for (data, fold), (strain, (ratio, angle)) in sorted(limits.items()):
        rows += [("main", data, "all", f"fold {fold}", figure, (v, v, v, len(cases))) for figure, v in (("geometry: mm", strain), ("tubetk: radii", ratio), ("tubetk: degrees", angle))]
    return rows, results
