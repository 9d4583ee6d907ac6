"""Figures of one answer, and their means with bootstrap intervals over subjects."""
import json
from functools import lru_cache

import bench
import numpy as np
import score

REPLICAS = 2000


@lru_cache(2)
def truth(folder):
    return json.loads((folder / "truth.json").read_text())


def probabilities(rows):
    """What the rows are ranked by, as score.py ranks: the probability where every row has one, else the likelihood."""
    filled = bool(rows) and all(r.get("probability") not in (None, "") for r in rows)
    return np.array([float(r["probability" if filled else "likelihood"]) for r in rows]), filled


def ends(row):
    return [[float(row[side + axis + "_mm"]) for axis in "xyz"] for side in "ab"]


def judge(case, rows):
    """All figures of score.py, and what pooled figures, curves and closures are made of."""
    answer = truth(case.folder)
    out = score.score(answer, rows)
    known = score.Case(answer)
    match = [known.match(*ends(row)) for row in rows]
    rank, filled = probabilities(rows)
    hit = np.array([m is not None for m in match], bool)
    if filled:
        out["bins"] = bins(rank, hit)
    out["curve"] = curve(rank, match), out["n_links"]
    out["inside"] = inside(known, rows, match)
    return out


def bins(p, hit):
    """Per tenth of probability: bridges, sum of P, right ones; the same of .05 < P < .95."""
    tenth, middle = np.minimum((p * 10).astype(int), 9), (p > 0.05) & (p < 0.95)
    count = lambda which: [np.bincount(tenth[which], weight[which], 10) for weight in (np.ones(len(p)), p, hit.astype(float))]
    return np.array([count(np.ones(len(p), bool)), count(middle)])


def floor(rows):
    """What ece_uncertain of score.py comes to on average where P is perfect: each bridge right with its own P."""
    p, _ = probabilities(rows)
    p = p[(p > 0.05) & (p < 0.95)]
    right = np.random.default_rng(0).random((100, len(p))) < p
    tenth = np.minimum((p * 10).astype(int), 9)[:, None] == np.arange(10)
    return float(np.abs((right - p) @ tenth).sum(1).mean() / max(len(p), 1))


def curve(rank, match):
    """(score, new true link, false) of each bridge, best first; a second bridge for a link is neither."""
    groups, rows = {}, []
    for i in np.argsort(-rank, kind="stable"):
        m = match[i]
        new = bool(m) and groups.setdefault(m[0], score.Union(16)).join(*m[1:])
        rows.append((rank[i], new, m is None))
    return np.array(rows, float).reshape(-1, 3)


def ranked(case, rows, column):
    """Average precision when ranked by a column."""
    answer = score.Case(truth(case.folder))
    if not answer.n_links:
        return np.nan
    return score.average_precision(np.array([float(r[column] or 0) for r in rows]), [answer.match(*ends(r)) for r in rows], answer.n_links)


def inside(known, rows, match):
    """Bridges within one piece: how many the truth has (links whose members are in one piece), how many of them are kept, false ones kept."""
    found, wrong = set(), 0
    for row, m in zip(rows, match):
        a, b = (known.snap(point) for point in ends(row))
        if int(float(row["kept"])) and a and b and known.piece[a[0]] == known.piece[b[0]]:
            if m is None:
                wrong += 1
            else:
                found.add((m[0], *sorted(m[1:])))
    places = sum(group[0]["piece"] == member["piece"] for group in known.t["links"] for member in group[1:])
    return places, len(found), wrong


def replicas(subjects):
    """How often each subject is drawn, a row a replica; the first row is the sample itself."""
    draws = np.random.default_rng(0).multinomial(len(subjects), np.full(len(subjects), 1 / len(subjects)), REPLICAS)
    return np.vstack([np.ones(len(subjects), int), draws])


def estimate(cases, parts, statistic):
    """(figure, low, high, cases) of a statistic of sums over cases, 95 % by drawing subjects; `parts`: an array a case, or None."""
    used = [(case.subject, np.asarray(part, float)) for case, part in zip(cases, parts) if part is not None]
    if not used:
        return None
    subjects = sorted({subject for subject, _ in used})
    sums = np.array([sum(part for subject, part in used if subject == s) for s in subjects])
    with np.errstate(invalid="ignore", divide="ignore"):
        values = statistic(np.tensordot(replicas(subjects), sums, 1))
    low, high = np.nanquantile(values[1:], [0.025, 0.975])
    return float(values[0]), float(low), float(high), len(used)


def mean(cases, values):
    """The mean over cases; what is not defined is left out."""
    parts = [None if v is None or np.isnan(v) else (v, 1) for v in values]
    return estimate(cases, parts, lambda s: s[..., 0] / s[..., 1])


def expected_error(sums):
    """Expected calibration error of bins summed: (..., 3, 10)."""
    return np.abs(sums[..., 1, :] - sums[..., 2, :]).sum(-1) / sums[..., 0, :].sum(-1)


def pooled(cases, results, less=None):
    """Pooled expected calibration error of .05 < P < .95; less that of other results of the same cases, when they are given."""
    part = lambda r: r["bins"][1] if "bins" in r else None
    if less is None:
        return estimate(cases, [part(r) for r in results], expected_error)
    both = [None if part(a) is None or part(b) is None else np.array([part(a), part(b)]) for a, b in zip(results, less)]
    return estimate(cases, both, lambda s: expected_error(s[..., 0, :, :]) - expected_error(s[..., 1, :, :]))
