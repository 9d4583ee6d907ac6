"""Fitted methods, each on the other subjects alone: gapbench's forest2, and gradient boosting on its features."""
import bench
import baselines
import fit
import model
import numpy as np
import rules
import score


def heads(cases, forests):
    """Platt map and loop closures from predictions by weights that did not see the subject; `forests`: of each case."""
    rows, weights = [fit.head_rows(d, th) for d, th in zip(cases, forests)], fit.case_weights(cases)
    got = []
    for x, y, start in ((0, 1, [0.0, 1.0, 0.0]), (2, 3, None)):
        xs, ys = np.vstack([r[x] for r in rows]), np.concatenate([r[y] for r in rows]).astype(float)
        w = np.concatenate([np.full(len(r[y]), o) for r, o in zip(rows, weights)])
        got.append(fit.logistic(xs, ys, w, np.zeros(xs.shape[1]) if start is None else np.array(start)))
    return got


def forest2(loaded):
    """Per fold the weights of forest2 as its fit.py makes them, its inner folds being the other folds.

    `loaded`: (fold, arrays of fit.load) of every case."""
    folds = range(bench.FOLDS)
    held = {k: [d for fold, d in loaded if fold == k] for k in folds}
    parts = [held[k] for k in folds] + [[d for j in folds if j != k for d in held[j]] for k in folds]
    fitted = bench.each(fit.fit_forest, parts)
    single, joint, n = fitted[: bench.FOLDS], fitted[bench.FOLDS :], len(fit.COLS)
    weights = []
    for k in folds:
        a, b = [j for j in folds if j != k]
        platt, closure = heads(held[a] + held[b], [single[b]] * len(held[a]) + [single[a]] * len(held[b]))
        weights.append(dict(features=model.FOREST, weights=joint[k][:n], root=joint[k][n:], platt=platt, closure=closure, root_factor=0.5, loop_cut=0.5))
    return weights


def boost(cases):
    """Gradient boosting of "is this bridge right" on forest2's features, a row a direction, data sets weighted as forest2 weighs them."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    x = np.vstack([d["x"][d["f"]] for d in cases])
    y = np.concatenate([d["hit"][d["und"]][d["f"]] for d in cases])
    w = np.concatenate([np.full(d["f"].sum(), o) for d, o in zip(cases, fit.case_weights(cases))])
    return HistGradientBoostingClassifier(max_iter=200, early_stopping=False, random_state=0).fit(x, y, sample_weight=w / w.mean())


def boosting(loaded):
    """Per fold the boosted trees."""
    return bench.each(boost, [[d for fold, d in loaded if fold != k] for k in range(bench.FOLDS)])


def load(case):
    return fit.load(case.folder)


def train(cases):
    """{method: what each fold learnt}."""
    loaded = [(case.fold, d) for case, d in zip(cases, bench.each(load, cases)) if d]
    return {"forest2": forest2(loaded), "boosting": boosting(loaded)}


def boosted(folder, trees):
    """Rows of one case: the mean probability of both directions, kept best first above one half, never a loop."""
    g = model.Pieces(folder)
    rows = [row for row in model.candidates(g) if not row[2]]
    if not rows:
        return []
    number, pairs = rules.undirected(g, [row[:2] for row in rows])
    p = np.bincount(number, trees.predict_proba(model.features(g, rows))[:, 1]) / np.bincount(number)
    return rules.table(g, [(a, b, x, k) for (a, b), x, k in zip(pairs, p, rules.pick(g, pairs, p, 0.5))], probable=True)


def reference(case, learnt):
    """Rows of forest2."""
    g, pairs, p, kept = model.predict(case.folder, learnt["forest2"][case.fold])
    return rules.table(g, [(a, b, x, k) for (a, b), x, k in zip(pairs, p, kept)], probable=True)


def answers(case, learnt):
    """{method: rows} of one case."""
    return {"forest2": reference(case, learnt), "boosting": boosted(case.folder, learnt["boosting"][case.fold])}
