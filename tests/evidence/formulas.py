"""The evidence model's formulas that the benchmark's model.py does not have, in numpy: written from their definitions, point by
point, without regard to speed.

``g`` is a model.Pieces, ``rows`` its candidates, ``old`` the columns of model.features or model.root_features by name."""
import numpy as np
from scipy.sparse.csgraph import dijkstra

FEATURES = """is_end gap bend_child_sq bend_child gap_end bend_parent_sq wall_branch gap_branch kink ratio_branch bend_far
ratio_end_sq wall resolution_branch ratio_branch_sq turn bend_gap margin blocked bend_parent ratio_end rank share_parent
orientation fed_parent near_tip touch_branch mutual wall_over_3 wall_over_1_5 kink_wide kink_excess near_junction""".split()
ROOT = "one inlet slim share width resolution clutter radius_variation free_ends junctions inlet_clutter slim_clutter share_clutter width_clutter".split()
FEEDBACK = "with_flow step_with_flow entered_there claims_on_end fed_otherwise claims_nearby".split()


def unit(v):
    return v / (np.linalg.norm(v) or 1)


def steps(g, x, radii, least, most):
    """So many radii at a point, in points."""
    return int(np.clip(round(radii * g.r_s[x] / g.h), least, most))


def directions(g, x, radii, least, most):
    """Unit vectors from a point along each of its links."""
    n = steps(g, x, radii, least, most)
    return np.array([unit(g.xyz_s[g._far(x, y, n)] - g.xyz_s[x]) for y in g.adj[x]])


def orientations(g):
    """Per free end the mean over the twelve nearest junctions of J(this way in) - best J(another way in)."""
    preference = {}
    for j in np.flatnonzero(g.deg > 2):
        cos = -(t := directions(g, j, 3, 4, 12)) @ t.T
        np.fill_diagonal(cos, np.inf)
        worst = cos.min(1)
        preference[j] = {y: worst[k] - np.delete(worst, k).max() for k, y in enumerate(g.adj[j])}
    away, up = dijkstra(g.net, directed=False, indices=g.ends, return_predecessors=True)
    out = np.zeros(len(g.ends))
    for k, e in enumerate(g.ends):
        near = sorted((away[k, j], j) for j in preference if g.piece[j] == g.piece[e])[:12]
        if near:
            out[k] = np.clip(np.mean([preference[j][up[k, j]] for _, j in near]), -1.5, 1.5)
    return out


def bridge_features(g, rows, old):
    """Columns by name, with the old ones."""
    i, q, _ = np.array(rows).T
    v = g.xyz[q] - g.xyz[g.ends[i]]
    d = np.linalg.norm(v, axis=1)
    u, end = v / d[:, None], old["is_end"]
    way = 1 - end
    width = 2 * g.r_end[i] + g.h
    ratio = np.log(g.r_end[i] / np.where(end > 0, g.r_end[np.maximum(g.i_end[q], 0)], g.r_s[q]))
    wall = np.minimum(np.maximum(d - way * g.r_s[q], 0) / width, 10)
    branch = way * np.clip(ratio, -2, 1)
    kink2, around = np.zeros(len(rows)), np.zeros(len(rows))
    for k in np.flatnonzero(way):
        if g.deg[q[k]] == 2:
            kink2[k] = -directions(g, q[k], 4, 5, 14).sum(0) @ u[k]
        around[k] = np.mean([g.kink[g._far(q[k], y, 4)] @ u[k] for y in g.adj[q[k]]] or [0])
    return old | {
        "ratio_end": old["abs_log_r"], "bend_child_sq": old["bend_child"] ** 2, "bend_parent_sq": old["bend_parent"] ** 2, "gap_end": end * old["gap"], "gap_branch": way * old["gap"],
        "wall_branch": way * wall, "wall_over_3": np.maximum(wall - 3, 0), "wall_over_1_5": np.maximum(wall - 1.5, 0), "touch_branch": way * (wall < .6),
        "ratio_branch": branch, "ratio_branch_sq": branch ** 2, "ratio_end_sq": end * np.minimum(abs(ratio), 1.5) ** 2,
        "resolution_branch": way * np.log(width / g.h), "turn": np.maximum(old["bend_child"], old["bend_parent"]),
        "bend_gap": old["bend_child"] * np.minimum(old["gap"], 3), "orientation": orientations(g)[i], "kink_wide": kink2,
        "kink_excess": way * (old["kink"] - around)}


def root_features(g, old):
    """Columns by name, with the old ones."""
    each = lambda f: np.array([f(np.flatnonzero(g.piece == p)) for p in range(g.n_pieces)])
    crossed = {name + "_clutter": old[name] * old["clutter"] for name in ("inlet", "slim", "share", "width")}
    return old | crossed | {"resolution": old["voxels"], "radius_variation": each(lambda x: min(np.log(g.r_s[x]).std(), .6)), "junctions": each(lambda x: np.log(1 + (g.deg[x] > 2).sum())),
                  "free_ends": each(lambda x: np.log(max((g.deg[x] == 1).sum(), 1)))}


def entries(g, e, p, root):
    """Blood to expect at each point."""
    out = np.bincount(e, p, len(g.xyz))
    for c in range(g.n_pieces):
        given = [x for x in set(g.inlet_nodes) if g.piece[x] == c]
        own = [k for k in range(len(g.ends)) if g.piece[g.ends[k]] == c]
        widest = [g.ends[k] for k in own if g.r_end[k] > (1 - 1e-9) * max(g.r_end[own])]
        for x in given or widest:
            out[x] += root[c] / len(given) if given else .5 * root[c] / len(widest)
    return out


def sides(g, x, blood):
    """(behind, ahead, F): a point's two links and the blood to expect on the first side less that on the other."""
    def beyond(y):
        found, todo = {x, y}, [y]
        while todo:
            new = [z for z in g.adj[todo.pop()] if z not in found]
            found.update(new)
            todo += new
        return found - {x}
    a, b = g.adj[x]
    behind, ahead = beyond(a), beyond(b)
    return a, b, 0 if b in behind else blood[list(behind)].sum() - blood[list(ahead)].sum()


def feedback(g, rows, w, v):
    """Columns by name for the bridges between pieces, whose weights are w, and v those of the roots."""
    i, q = np.array([row[:2] for row in rows if not row[2]]).T
    e, n, m = g.ends[i], g.n_pieces, len(i)
    pc, pq, end = g.piece[e], g.piece[q], g.deg[q] == 1
    lap = np.diag(v.astype(float))
    np.add.at(lap, (pc, pc), w)
    np.add.at(lap, (pc, pq), -w)
    inv = np.linalg.inv(lap)
    p, root = w * (inv[pc, pc] - inv[pq, pc]), v * np.diag(inv)
    out = {name: np.zeros(m) for name in FEEDBACK}
    blood, cut = entries(g, e, p, root), {}
    for k in np.flatnonzero(~end & (g.deg[q] == 2)):
        x = q[k]
        a, b, more = cut[x] = cut.get(x) or sides(g, x, blood)
        n1, n4 = steps(g, x, 1.5, 2, 12), steps(g, x, 4, 5, 14)
        tangent = unit(unit(g.xyz_s[x] - g.xyz_s[g._far(x, a, n1)]) + unit(g.xyz_s[g._far(x, b, n1)] - g.xyz_s[x]))
        out["with_flow"][k] = -more * tangent @ unit(g.xyz[x] - g.xyz[e[k]])
        side = [list(dict.fromkeys(g._far(x, y, s) for s in range(1, n4 + 1))) for y in (a, b)]
        mean = [np.mean(g.log_r[s[1:] or s]) for s in side]
        out["step_with_flow"][k] = more * np.clip(mean[0] - mean[1], -1, 1)
    near = lambda k: (g.piece[q] == pq[k]) & (np.linalg.norm(g.xyz[q] - g.xyz[q[k]], axis=1) <= 2 * (g.r_s[q[k]] + g.h))
    fed = g.fed if g.fed.any() else g.length == g.length.max()
    rooted = inv @ (v * fed)
    for k in range(m):
        out["entered_there"][k] = p[(e == q[k]) & (pq != pc[k])].sum()
        out["claims_on_end"][k] = p[(q == e[k]) & (pc != pq[k])].sum()
        out["claims_nearby"][k] = 0 if end[k] else min(p[near(k) & (pc != pc[k])].sum(), 2)
        out["fed_otherwise"][k] = rooted[pq[k]] - inv[pq[k], pc[k]] / inv[pc[k], pc[k]] * rooted[pc[k]]
    return out
