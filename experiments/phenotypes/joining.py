"""The plain rule: every free end is joined to the nearest point of another fragment, as heal tools do."""
import numpy as np
from scipy.spatial import cKDTree


def joined(source, out, reach):
    """A copy of a broken SWC in one piece where free ends are within `reach` (mm) of another fragment; links that SWC cannot hold."""
    rows = [line.split() for line in source.read_text().splitlines() if line.strip() and not line.startswith("#")]
    ids = [row[0] for row in rows]
    at = {name: i for i, name in enumerate(ids)}
    points = np.array([[float(x) for x in row[2:5]] for row in rows])
    parent = [at.get(row[6], -1) for row in rows]
    degree = np.zeros(len(rows), int)
    piece = np.arange(len(rows))

    def root(i):
        while piece[i] != i:
            piece[i] = piece[piece[i]]
            i = piece[i]
        return i

    for i, p in enumerate(parent):
        if p >= 0:
            degree[i] += 1
            degree[p] += 1
            piece[root(i)] = root(p)
    fragment = np.array([root(i) for i in range(len(rows))])
    tree = cKDTree(points)
    links = set()
    for end in np.flatnonzero(degree <= 1):
        near = [j for j in tree.query_ball_point(points[end], reach) if fragment[j] != fragment[end]]
        if near:
            best = min(near, key=lambda j: (np.linalg.norm(points[j] - points[end]), j))
            links.add((min(end, best), max(end, best)))
    out.write_text("id_a,id_b\n" + "".join(f"{ids[a]},{ids[b]}\n" for a, b in sorted(links)))
    return len(links)
