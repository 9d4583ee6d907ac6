"""Exact marginals of forests of fragments with weights far apart, for tests/inference/posterior.rs.

    python3 -m pip install mpmath==1.4.1
    python3 reference.py            # writes reference.json beside itself, the same bytes every time
    python3 reference.py --check    # changes nothing; fails when reference.json would differ

    wide    all log weights uniform in -60 ... 60
    mutual  fragments in pairs that prefer each other by e^40 to e^60, roots of e^-60 to e^-20
    grid    8 x 8 fragments that bridge to their neighbours, log weights uniform in -60 ... 60: more than one clique
    hub     40 short chains on one fragment, log weights uniform in -60 ... 60

The log weights are the doubles in the file, taken exactly. L = diag(v + sum w) - w is inverted by LU with 400 digits,
P(bridge) = w (G_cc - G_pc), P(root) = v G_cc, ln Z = ln det L: the formulas as they stand, cancellation and all. A
second run with 500 digits must agree to 1e-40.

Doubles are strings of the shortest decimal that rounds to them: parsers of JSON numbers may miss the last bit.
"""

import json
import random
import sys
from pathlib import Path

from mpmath import exp, log, matrix, mp, mpf, nstr

AGREE = mpf(10) ** -40


class Draw:
    """Only random() of the generator: its bits are the same in every version of Python."""

    def __init__(self, seed):
        self.generator = random.Random(seed)

    def below(self, n):
        return int(self.generator.random() * n)

    def within(self, low, high):
        return float(f"{low + (high - low) * self.generator.random():.6g}")


def wide(draw, fragments, bridges):
    rows = []
    while len(rows) < bridges:
        c, p = draw.below(fragments), draw.below(fragments)
        if c != p:
            rows.append([c, p, draw.within(-60, 60)])
    return [draw.within(-60, 60) for _ in range(fragments)], rows


def mutual(draw, fragments, bridges):
    roots, rows = wide(draw, fragments, bridges)
    for c in range(0, fragments - 1, 2):
        rows += [[c, c + 1, draw.within(40, 60)], [c + 1, c, draw.within(40, 60)]]
    return [draw.within(-60, -20) for _ in roots], [[c, p, w if w >= 40 else w / 2] for c, p, w in rows]


def grid(draw, side):
    rows = []
    for c in range(side * side):
        for p in (c - 1 if c % side else None, c + 1 if c % side < side - 1 else None, c - side, c + side):
            if p is not None and 0 <= p < side * side:
                rows.append([c, p, draw.within(-60, 60)])
    return [draw.within(-60, 60) for _ in range(side * side)], rows


def hub(draw, chains, length):
    rows, fragments = [], 1
    for _ in range(chains):
        above = 0
        for _ in range(length):
            rows += [[fragments, above, draw.within(-60, 60)], [above, fragments, draw.within(-60, 60)]]
            above, fragments = fragments, fragments + 1
    return [draw.within(-60, 60) for _ in range(fragments)], rows


def solve(roots, rows, digits):
    mp.dps = digits
    n = len(roots)
    v, w = [exp(mpf(x)) for x in roots], [exp(mpf(x)) for _, _, x in rows]
    laplacian = matrix(n, n)
    for c in range(n):
        laplacian[c, c] = v[c]
    for (c, p, _), x in zip(rows, w):
        laplacian[c, c] += x
        laplacian[c, p] -= x
    lower_upper, _ = mp.LU_decomp(laplacian)
    total = sum(log(abs(lower_upper[i, i])) for i in range(n))
    g = laplacian ** -1
    return [x * (g[c, c] - g[p, c]) for (c, p, _), x in zip(rows, w)], [v[c] * g[c, c] for c in range(n)], total


def double(x):
    return repr(float(nstr(x, 25)))


def reference(name, roots, rows):
    got, again = solve(roots, rows, 400), solve(roots, rows, 500)
    for a, b in zip(got[0] + got[1] + [got[2]], again[0] + again[1] + [again[2]]):
        assert abs(a - b) <= AGREE * abs(b), name
    bridges, of_roots, total = again
    return {
        "name": name,
        "log_total": double(total),
        "roots": [[repr(x), double(p)] for x, p in zip(roots, of_roots)],
        "bridges": [[c, p, repr(x), double(q)] for (c, p, x), q in zip(rows, bridges)],
    }


def main():
    cases = []
    for seed, (fragments, bridges) in enumerate([(2, 3), (4, 9), (8, 30), (12, 60), (20, 120)]):
        cases.append(reference(f"wide-{fragments}", *wide(Draw(seed), fragments, bridges)))
        cases.append(reference(f"mutual-{fragments}", *mutual(Draw(100 + seed), fragments, bridges)))
    cases.append(reference("grid", *grid(Draw(7), 8)))
    cases.append(reference("hub", *hub(Draw(8), 40, 2)))
    text = "[\n" + ",\n".join(json.dumps(case, separators=(",", ":")) for case in cases) + "\n]\n"
    path = Path(__file__).with_name("reference.json")
    if sys.argv[1:] == ["--check"]:
        sys.exit(0 if path.read_text() == text else f"{path} would differ")
    path.write_text(text)


main()
