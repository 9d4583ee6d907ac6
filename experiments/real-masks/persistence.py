"""Does the level at which two branches part tell a false rung from a true vessel? With and without it, cross-validated; the table of persistence in README.md.

    persistence.py SKELBENCH DATA REAL SIMULATED

REAL and SIMULATED hold cases as for rungs.py, whose rungs, features and trees these are. More features, in three fields (the distance to the wall, the mask smoothed by .25 and by .5
mm): the highest level at which the branches at one end of a rung and those at the other are connected in the lumen around it; that over the level of either
vessel, the lesser and the greater; and the lesser of these levels. A vessel's level is the median along the second of the branches at that end.
"""
import argparse
import heapq
import itertools
import sys
from pathlib import Path

import numpy as np
from scipy import ndimage

#: The mask is smoothed by so many mm.
SIGMAS = (0.25, 0.5)
#: Branches are followed so far from an end of a rung: so many depths there, and so many voxels.
FOLLOWED = (2.5, 2.0)
#: Around them so many voxels are looked at.
MARGIN = 3


def fields_of(field):
    """The distance to the wall, and the smoothed mask, in the box of a `rungs.Field`; nothing outside the lumen."""
    zoom = np.linalg.norm(np.linalg.inv(field.aff)[:3, :3], axis=0)
    smooth = lambda sigma: np.where(field.mask, ndimage.gaussian_filter(field.mask.astype(np.float32), sigma / zoom), 0)
    return [ndimage.distance_transform_edt(field.mask, sampling=zoom), *map(smooth, SIGMAS)]


def passed(level, start, stop):
    """The highest level at which some voxels are connected with others (Dijkstra's algorithm for the widest way); 0 if they are not."""
    best, goal = {}, set(map(tuple, stop))
    open_ = [(-level[tuple(v)], tuple(v)) for v in start if level[tuple(v)] > 0]
    heapq.heapify(open_)
    while open_:
        width, here = heapq.heappop(open_)
        if here in best:
            continue
        best[here] = -width
        if here in goal:
            return float(-width)
        for there in itertools.product(*[range(max(0, x - 1), min(n, x + 2)) for x, n in zip(here, level.shape)]):
            if there not in best and level[there] > 0:
                heapq.heappush(open_, (max(width, -level[there]), there))
    return 0.0


def persistence(graph, fields, k):
    """The features of the rung that is run k of a `rungs.Graph`."""
    field, run = graph.f, graph.runs[k]
    depth = max(graph.depth[run[0]], graph.depth[run[-1]], 0.5 * field.hm)
    reach = FOLLOWED[0] * depth + FOLLOWED[1] * field.hm
    voxels = lambda p: np.rint(np.atleast_2d(p) @ field.aff[:3, :3].T + field.aff[:3, 3] - field.lo).astype(int)
    sides = []
    for node in (run[0], run[-1]):
        walks = [graph.walk(arm, last, reach) for arm, last in graph.arms(node, k)[1]]
        lines = [line[along <= reach] for line, along in walks]
        # The nearer half is in the junction.
        sides.append([voxels(line[len(line) // 2 :]) for line in lines])
    everything = np.vstack([voxels(graph.x[run]), *sides[0], *sides[1]])
    low = np.maximum(everything.min(0) - MARGIN, 0)
    high = np.minimum(everything.max(0) + MARGIN + 1, field.mask.shape)
    local = lambda v: np.clip(v - low, 0, high - low - 1)
    out = []
    for values in fields:
        level = values[tuple(slice(a, b) for a, b in zip(low, high))]
        own = [sorted(float(np.median(level[tuple(local(v).T)])) for v in side)[-2:][0] for side in sides]
        through = passed(level, local(np.vstack(sides[0])), local(np.vstack(sides[1])))
        out += [through, through / max(min(own), 1e-6), through / max(max(own), 1e-6), min(own)]
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bench", "data", "real", "simulated"):
        parser.add_argument(name, type=Path)
    given = parser.parse_args()
    sys.path[:0] = [str(given.bench), str(Path(__file__).resolve().parent)]
    import cases
    import implant
    import rungs
    import score
    from sklearn.metrics import roc_auc_score

    rungs.S, rungs.implant, rungs.C = score, implant, cases
    found = {}
    for truth in [*sorted(given.real.glob("*/truth.json")), *sorted(given.simulated.glob("*/*/truth.json"))]:
        case = truth.parent
        is_real = given.real in case.parents
        rows, graph = rungs.real_case(given.data, case) if is_real else rungs.sim_case(case)
        fields = fields_of(graph.f)
        known = [(row + persistence(graph, fields, k), true) for row, true, k in rows if true >= 0]
        key = ("real", case.name[:3], case.name) if is_real else ("simulated", case.name, case.parent.name)
        found[key] = np.array([row for row, _ in known]), np.array([true for _, true in known])
        print(*key, len(known), file=sys.stderr, flush=True)
    count = len(rungs.NAMES)
    kinds = {kind: [key for key in found if key[0] == kind] for kind in ("real", "simulated")}
    kinds["both"] = list(found)
    of = {"of rungs": slice(0, count), "persistence": slice(count, None), "both": slice(0, None)}
    print("| judged on | fitted to | features | AUC | false ones found at 2 %, 5 %, 10 % of the true ones lost | false, true |\n|---|---|---|---|---|---|")
    for judged in ("real", "simulated"):
        for fitted_to in (judged, "both"):
            for features, columns in of.items():
                part = {key: (rows[:, columns], true) for key, (rows, true) in found.items()}
                scores, true = rungs.cross_validated(part, kinds[fitted_to], kinds[judged])
                shares = ["%.2f" % (scores[true == 0] < np.quantile(scores[true == 1], lost)).mean() for lost in (0.02, 0.05, 0.1)]
                numbers = f"{(true == 0).sum()}, {(true == 1).sum()}"
                print(f"| {judged} | {fitted_to} | {features} | {roc_auc_score(true, scores):.3f} | {', '.join(shares)} | {numbers} |", flush=True)


if __name__ == "__main__":
    main()
