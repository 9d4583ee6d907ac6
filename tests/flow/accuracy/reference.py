"""Exact solutions of ill-conditioned circuits, for tests/flow/accuracy.rs.

    python3 -m pip install mpmath==1.4.1
    python3 reference.py            # writes reference.json beside itself, the same bytes every time
    python3 reference.py --check    # changes nothing; fails when reference.json would differ

Three families of circuits of 24 nodes, six of each, and two with a floating piece:

radii    random networks, radii log-uniform from 0.05 to 2.5 mm
link-9   two such halves joined by one vessel 1e-9 times weaker than a typical one. The far half is a dead end in the
         first three (pressures there are all equal); in the others a terminal resistance as weak as the link drains it
link-15  the same with 1e-15
floating a piece of six nodes with no condition; and link-15 with the link taken away

What a circuit holds are the doubles in the file, taken exactly: conductances (m3/(Pa s)), fixed pressures (Pa),
terminals. Elimination in rational numbers has no rounding at all, and Python rounds a fraction to the nearest double,
so pressures, drops and flows are the nearest doubles to the truth, and a vessel without flow has a drop of exactly 0.
mpmath solves every circuit again by LU with 60 digits, and the two must agree to 1e-25 of each pressure.

Doubles are strings of the shortest decimal that rounds to them: parsers of JSON numbers may miss the last bit.
"""

import json
import math
import random
import sys
from fractions import Fraction
from pathlib import Path

from mpmath import lu_solve, matrix, mp, mpf

mp.dps = 60
VISCOSITY = 3.5e-3
NODES = 24
DIGITS_AGREE = mpf(10) ** -25


class Draw:
    """Only random() of the generator: its bits are the same in every version of Python."""

    def __init__(self, seed):
        self.generator = random.Random(seed)

    def below(self, n):
        return int(self.generator.random() * n)

    def log_uniform(self, low, high):
        # Six digits, so that the last bit of a platform's pow cannot matter.
        return float(f"{low * (high / low) ** self.generator.random():.6g}")

    def shuffled(self, items):
        items = list(items)
        for i in range(len(items) - 1, 0, -1):
            j = self.below(i + 1)
            items[i], items[j] = items[j], items[i]
        return items


def conductance(length_mm, radius_mm):
    length, radius = length_mm / 1e3, radius_mm / 1e3
    return math.pi * (radius * radius * radius * radius) / (8.0 * VISCOSITY * length)


def vessel(draw, a, b, weaker=1.0):
    length, radius = draw.log_uniform(2.0, 40.0), draw.log_uniform(0.05, 2.5)
    if weaker < 1.0:
        length, radius = 10.0, float(f"{0.35 * weaker**0.25:.6g}")
    return {"ends": [a, b], "length": length, "radius": radius, "conductance": conductance(length, radius)}


def piece(draw, nodes, extra):
    """A random tree over the nodes and `extra` more vessels, one of them beside another."""
    vessels = [vessel(draw, nodes[draw.below(i)], nodes[i]) for i in range(1, len(nodes))]
    for _ in range(extra - 1):
        a, b = draw.shuffled(nodes)[:2]
        vessels.append(vessel(draw, a, b))
    beside = vessels[draw.below(len(vessels))]["ends"]
    vessels.append(vessel(draw, beside[1], beside[0]))
    return vessels


def condition(draw, circuit, near):
    """1-2 inlets, 2-3 grounds and a terminal resistance among the nodes `near`."""
    inlets, grounds = 1 + draw.below(2), 2 + draw.below(2)
    nodes = draw.shuffled(near)[: inlets + grounds + 1]
    circuit["fixed"] = [[n, draw.log_uniform(9e3, 16e3)] for n in nodes[:inlets]]
    circuit["fixed"] += [[n, 0.0] for n in nodes[inlets:-1]]
    terminal(draw, circuit, nodes[-1], draw.log_uniform(1e-13, 1e-9))


def terminal(draw, circuit, node, g):
    venous = float(draw.below(2) * 600)
    circuit["terminals"].append([node, g, g * venous])


def family_radii(draw, index):
    circuit = {"vessels": piece(draw, draw.shuffled(range(NODES)), 18), "terminals": []}
    if index == 0:
        circuit["vessels"].append(vessel(draw, 5, 5))
    condition(draw, circuit, range(NODES))
    return circuit


def family_link(draw, index, weaker):
    nodes = draw.shuffled(range(NODES))
    near, far = nodes[: NODES // 2], nodes[NODES // 2 :]
    circuit = {"vessels": piece(draw, near, 8) + piece(draw, far, 8), "terminals": []}
    condition(draw, circuit, near)
    if weaker > 0.0:
        fixed = {n for n, _ in circuit["fixed"]}
        open_ends = [n for n in near if n not in fixed]
        link = vessel(draw, open_ends[draw.below(len(open_ends))], far[draw.below(len(far))], weaker)
        circuit["vessels"].append(link)
    if index >= 3:
        terminal(draw, circuit, far[draw.below(len(far))], link["conductance"] * draw.log_uniform(0.3, 3.0))
    return circuit


def floating_piece(draw):
    nodes = draw.shuffled(range(NODES))
    circuit = {"vessels": piece(draw, nodes[6:], 12) + piece(draw, nodes[:6], 4), "terminals": []}
    condition(draw, circuit, nodes[6:])
    return circuit


def circuits():
    def seeded(name, make):
        return {"name": name, **make(Draw(name))}

    for i in range(6):
        yield "radii", seeded(f"radii {i}", lambda draw: family_radii(draw, i))
    for exponent in (9, 15):
        for i in range(6):
            name = f"link-{exponent} {i}"
            yield f"link-{exponent}", seeded(name, lambda draw: family_link(draw, i, 10.0**-exponent))
    yield "floating", seeded("floating 0", floating_piece)
    yield "floating", seeded("floating 1", lambda draw: family_link(draw, 0, 0.0))


def grounded(circuit):
    """The nodes that some condition reaches through vessels."""
    reached = {n for n, _ in circuit["fixed"]} | {n for n, _, _ in circuit["terminals"]}
    while True:
        more = {n for v in circuit["vessels"] if set(v["ends"]) & reached for n in v["ends"]} - reached
        if not more:
            return reached
        reached |= more


def laplacian(circuit, free, number):
    """Kirchhoff's current law at the free nodes, matrix and right-hand side, in the given kind of number."""
    row, fixed = {n: i for i, n in enumerate(free)}, dict(circuit["fixed"])
    a = [[number(0) for _ in free] for _ in free]
    b = [number(0) for _ in free]
    for v in circuit["vessels"]:
        c = number(v["conductance"])
        for here, there in (v["ends"], v["ends"][::-1]):
            if here not in row or here == there:
                continue
            a[row[here]][row[here]] += c
            if there in row:
                a[row[here]][row[there]] -= c
            else:
                b[row[here]] += c * number(fixed[there])
    for node, g, s in circuit["terminals"]:
        a[row[node]][row[node]] += number(g)
        b[row[node]] += number(s)
    return a, b


def eliminate(a, b):
    """Gauss, with row exchanges."""
    n = len(b)
    for k in range(n):
        pivot = max(range(k, n), key=lambda i: abs(a[i][k]))
        a[k], a[pivot], b[k], b[pivot] = a[pivot], a[k], b[pivot], b[k]
        for i in range(k + 1, n):
            if a[i][k] != 0:
                factor = a[i][k] / a[k][k]
                for j in range(k, n):
                    a[i][j] -= factor * a[k][j]
                b[i] -= factor * b[k]
    for k in reversed(range(n)):
        b[k] = (b[k] - sum(a[k][j] * b[j] for j in range(k + 1, n))) / a[k][k]
    return b


def solve(circuit):
    """The exact pressures as fractions, and the worst relative error of dense LU in doubles."""
    fixed = dict(circuit["fixed"])
    free = [n for n in sorted(grounded(circuit)) if n not in fixed]
    pressure = [Fraction(fixed.get(n, 0.0)) for n in range(NODES)]
    exact = eliminate(*laplacian(circuit, free, Fraction))
    a, b = laplacian(circuit, free, mpf)
    for x, y in zip(exact, lu_solve(matrix(a), matrix(b))):
        assert abs(mpf(x.numerator) / x.denominator - y) <= DIGITS_AGREE * abs(y), circuit["name"]
    for n, p in zip(free, exact):
        pressure[n] = p
    try:
        rough = eliminate(*laplacian(circuit, free, float))
    except ZeroDivisionError:
        rough = [math.inf] * len(free)
    return pressure, max(abs(x / float(p) - 1.0) for x, p in zip(rough, exact) if p != 0)


def main():
    lines, lu, span = [], {}, {}
    for family, circuit in circuits():
        pressure, worst = solve(circuit)
        lu[family] = max(lu.get(family, 0.0), worst)
        all_c = [v["conductance"] for v in circuit["vessels"]]
        span[family] = max(span.get(family, 0.0), max(all_c) / min(all_c))
        rows = []
        for v in circuit["vessels"]:
            a, b = v["ends"]
            drop = pressure[a] - pressure[b]
            figures = [v["length"], v["radius"], v["conductance"], float(drop), float(drop * Fraction(v["conductance"]))]
            rows.append("   " + json.dumps([a, b, *map(repr, figures)]))
        lines.append(
            f' {{"name": "{circuit["name"]}", "family": "{family}",\n'
            f'  "fixed": {json.dumps([[n, repr(p)] for n, p in circuit["fixed"]])},\n'
            f'  "terminals": {json.dumps([[n, repr(g), repr(s)] for n, g, s in circuit["terminals"]])},\n'
            f'  "pressure": {json.dumps([repr(float(p)) for p in pressure])},\n'
            '  "vessels": [\n' + ",\n".join(rows) + "]}"
        )
    text = "[\n" + ",\n".join(lines) + "\n]\n"
    for family in lu:
        print(f"{family}: conductances span {span[family]:.1e}, dense LU in doubles is wrong by {lu[family]:.1e}")
    path = Path(__file__).with_name("reference.json")
    if "--check" in sys.argv[1:]:
        sys.exit(0 if path.read_text() == text else f"{path.name} is not what this script makes")
    path.write_text(text)


if __name__ == "__main__":
    main()
