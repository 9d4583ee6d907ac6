"""Methods without weights: distance, hand geometry, and the rules of peers; what has a limit gets it from the other subjects."""
import json

import bench
import baselines
import numpy as np
import peers
import score

# d (1.2 - cos) in mm beyond which a bridge is not kept.
STRAINS = (0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0, 11.0, 16.0)


def undirected(g, rows):
    """Number of the bridge of each directed row, and the bridges as pairs of points."""
    key = {}
    number = np.array([key.setdefault((min(g.ends[i], q), max(g.ends[i], q)), len(key)) for i, q in rows], int)
    return number, list(key)


def pick(g, pairs, s, limit):
    """Best first, never a loop, down to a limit."""
    a, b = np.array(pairs, int).reshape(-1, 2).T
    return baselines.forest_pick(g.piece[a], g.piece[b], s, limit)


def geometry(folder):
    """Fragments, bridges, and minus the hand rule d (1.2 - cos) of each, as gapbench states it."""
    g = baselines.Pieces(folder)
    rows = baselines.candidates(g)
    if not rows:
        return g, [], np.zeros(0)
    f = dict(zip(baselines.NAMES, baselines.features(g, rows).T))
    number, pairs = undirected(g, rows)
    far = np.where(f["is_end"] > 0, np.cos(f["bend_parent"]), np.cos(f["bend_child"]))
    s = np.full(len(pairs), -1e9)
    np.maximum.at(s, number, -f["d"] * (1.2 - 0.5 * (np.cos(f["bend_child"]) + far)))
    return g, pairs, s


def f1(case, xyz, kept):
    """F1 of kept bridges."""
    groups, found, wrong = {}, 0, 0
    for a, b in kept:
        match = case.match(xyz[a], xyz[b])
        if match:
            found += groups.setdefault(match[0], score.Union(16)).join(*match[1:])
        else:
            wrong += 1
    return 2 * found / max(found + wrong + case.n_links, 1)


def tried(case):
    """F1 of a case at every limit of the hand rule and of ITKTubeTK's."""
    answer = score.Case(json.loads((case.folder / "truth.json").read_text()))
    g, pairs, s = geometry(case.folder)
    hand = [f1(answer, g.xyz, [p for p, k in zip(pairs, pick(g, pairs, s, -limit)) if k]) for limit in STRAINS]
    found = peers.near(g)
    tube = [f1(answer, g.xyz, [(a, b) for a, b, _, kept in peers.tubetk(g, found, *limits) if kept]) for limits in peers.LIMITS]
    return hand, tube


def limits(cases):
    """Per fold and data set, the limits with the best mean F1 over the other subjects of the set: [(data, fold)] -> (strain, (ratio, angle))."""
    got, best = bench.each(tried, cases), {}
    for data in dict.fromkeys(c.data for c in cases):
        for fold in range(bench.FOLDS):
            means = [np.mean([row[k] for c, row in zip(cases, got) if c.data == data and c.fold != fold], axis=0) for k in (0, 1)]
            best[data, fold] = STRAINS[int(np.argmax(means[0]))], peers.LIMITS[int(np.argmax(means[1]))]
    return best


def table(g, rows, probable=False):
    """Rows as score.py reads them, of (a, b, score, kept)."""
    return [
        dict(zip("ax_mm ay_mm az_mm bx_mm by_mm bz_mm".split(), (*g.xyz[a], *g.xyz[b])), origin="candidate", likelihood=float(s), kept=int(k), probability=float(s) if probable else "")
        for a, b, s, k in rows
    ]


def answers(case, best):
    """{method: rows} of one case."""
    strain, tube = best[case.data, case.fold]
    g, pairs, s = geometry(case.folder)
    hand = [(a, b, x, k) for (a, b), x, k in zip(pairs, s, pick(g, pairs, s, -strain))] if pairs else []
    d = np.array([-np.linalg.norm(g.xyz[a] - g.xyz[b]) for a, b in pairs])
    tree = pick(g, pairs, d, -np.inf) if pairs else []
    mst = [(a, b, x + 100 * k, k) for (a, b), x, k in zip(pairs, d, tree)]
    return {"geometry": table(g, hand), "MST": table(g, mst), "heal": table(g, peers.heal(g)), "tubetk": table(g, peers.tubetk(g, peers.near(g), *tube))}
