"""What two published tools do with fragments, by their own rules: navis.heal_skeleton and ITKTubeTK's ConvertTubesToTubeTree."""
import heapq

import numpy as np
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

# ITKTubeTK's two limits, (distance / radius of the parent's point, continuity angle in degrees); its defaults come first.
LIMITS = [(ratio, angle) for angle in (180, 90, 60, 40) for ratio in (2, 4, 8, 12, 18)]


def heal(g):
    """(end, end, -distance, kept) as navis.heal_skeleton(method="LEAFS") joins fragments: the minimum spanning tree of the
    fragments, two of which are as far apart as their closest ends; neither a longest bridge nor a smallest fragment."""
    leaf = np.flatnonzero(g.deg <= 1)
    distance, piece = cdist(g.xyz[leaf], g.xyz[leaf]), g.piece[leaf]
    distance[piece[:, None] == piece[None]] = np.inf
    tree, rows = np.isin(piece, piece[:1]), []
    # Prim's algorithm: the nearest end of any fragment that is not in the tree.
    while not tree.all():
        reach = np.where(tree[:, None] & ~tree[None], distance, np.inf)
        a, b = np.unravel_index(np.argmin(reach), reach.shape)
        rows.append((leaf[a], leaf[b], -distance[a, b], True))
        tree |= piece == piece[b]
    return rows


def near(g):
    """(distance, distance / radius of the parent's point, bend in degrees, point, end) of every point within the widest limit of a
    free end of another fragment, nearest first."""
    widest, tree, found = max(ratio for ratio, _ in LIMITS), cKDTree(g.xyz), []
    for e in g.ends:
        at = np.array(tree.query_ball_point(g.xyz[e], widest * g.r.max()), int)
        gap = g.xyz[e] - g.xyz[at]
        d = np.linalg.norm(gap, axis=1)
        use = (g.piece[at] != g.piece[e]) & (d <= widest * g.r[at])
        inward = g.xyz[g.adj[e][0]] - g.xyz[e]
        cos = gap[use] @ inward / np.maximum(d[use] * np.linalg.norm(inward), 1e-12)
        found.append(np.column_stack([d[use], d[use] / g.r[at[use]], np.degrees(np.arccos(np.clip(cos, -1, 1))), at[use], np.full(use.sum(), e)]))
    found = np.vstack(found)
    return found[np.lexsort((found[:, 4], found[:, 3], found[:, 0]))]


def tubetk(g, found, ratio, angle):
    """(point, end, score, kept) as ConvertTubesToTubeTree grows its trees. From any point of one fragment to an end of another the
    shortest link counts that is no longer than `ratio` radii of the point and bends by no more than `angle` degrees. Trees grow from
    the fragments with most such links, then the longest, in turn, always along the shortest link to a fragment that no tree has. A
    fragment with branches stands for a tube."""
    graph, visited, kept = {}, set(), set()
    found = found[(found[:, 1] <= ratio) & (found[:, 2] <= angle)]
    parent, child = g.piece[found[:, 3].astype(int)], g.piece[found[:, 4].astype(int)]
    _, shortest = np.unique(parent * g.n_pieces + child, return_index=True)
    for k in shortest:
        graph.setdefault(int(parent[k]), {})[int(child[k])] = (float(found[k, 0]), int(found[k, 3]), int(found[k, 4]))
    for root in sorted(range(g.n_pieces), key=lambda c: (-len(graph.get(c, ())), -g.length[c], c)):
        if root in visited:
            continue
        visited.add(root)
        queue = [(*link, root, child) for child, link in graph.get(root, {}).items()]
        heapq.heapify(queue)
        while queue:
            _, _, _, parent, child = heapq.heappop(queue)
            if child in visited:
                continue
            visited.add(child)
            kept.add((parent, child))
            for next_child, link in graph.get(child, {}).items():
                heapq.heappush(queue, (*link, child, next_child))
    rows = {}
    for parent, children in graph.items():
        for child, (d, p, e) in children.items():
            chosen = (parent, child) in kept
            key = (min(p, e), max(p, e))
            rows[key] = max(rows.get(key, (-np.inf, False)), (1e3 * chosen - d, chosen))
    return [(a, b, *row) for (a, b), row in sorted(rows.items())]
