"""What all samples of small graphs come to in rational numbers, for tests/inference/wide_vessels.rs.

    python3 reference.py            # writes reference.json beside itself, the same bytes every time
    python3 reference.py --check    # changes nothing; fails when reference.json would differ

Radii are log-uniform from 0.005 to 10 mm, so conductances lie up to 14 orders apart. Every pattern of open vessels is solved by
elimination in fractions: the doubles of the file are taken exactly, nothing is rounded, and a vessel carries blood where its drop is not
exactly 0. Then come the resilience C drop^2 / (pi r^2 l) of every vessel, the maximum spanning forest (Kruskal; resiliences are compared to
24 bits, the lower row first), and the means over all patterns, each as probable as any other.

Doubles are strings of the shortest decimal that rounds to them: parsers of JSON numbers may miss the last bit.
"""

import json
import math
import random
import struct
import sys
from fractions import Fraction
from pathlib import Path

VISCOSITY = 3.5e-3
GRAPHS = 48


class Draw:
    """Only random() of the generator: its bits are the same in every version of Python."""

    def __init__(self, seed):
        self.generator = random.Random(seed)

    def below(self, n):
        return int(self.generator.random() * n)

    def log_uniform(self, low, high):
        # Six digits, so that the last bit of a platform's pow cannot matter.
        return float(f"{low * (high / low) ** self.generator.random():.6g}")

    def other(self, n, *taken):
        return [i for i in range(n) if i not in taken][self.below(n - len(taken))]


def conductance(length_mm, radius_mm):
    length, radius = length_mm / 1e3, radius_mm / 1e3
    return math.pi * (radius * radius * radius * radius) / (8.0 * VISCOSITY * length)


def volume(length_mm, radius_mm):
    length, radius = length_mm / 1e3, radius_mm / 1e3
    return math.pi * (radius * radius) * length


def graph(seed):
    """A random tree of 4 to 6 nodes and more vessels between its nodes, 7 or 8 in all; an inlet, an outlet, by chance one more of each."""
    if seed == 0:
        return {"nodes": 3, "vessels": [[0, 1, 10.0, 10.0], [1, 2, 10.0, 0.005]], "fixed": [[0, 13332.2], [2, 0.0]], "terminals": []}
    draw = Draw(f"wide vessels {seed}")
    nodes = 4 + draw.below(3)
    pairs = [[draw.below(i), i] for i in range(1, nodes)]
    while len(pairs) < 7 + seed % 2:
        a = draw.below(nodes)
        pairs.append([a, draw.other(nodes, a)])
    # Either all radii, or only very wide and very narrow ones: then loops of wide vessels hang on narrow ones.
    two_kinds = draw.below(2) == 0

    def radius():
        if not two_kinds:
            return draw.log_uniform(0.005, 10.0)
        return draw.log_uniform(3.0, 10.0) if draw.below(2) == 0 else draw.log_uniform(0.005, 0.02)

    inlet = draw.below(nodes)
    outlet = draw.other(nodes, inlet)
    fixed, terminals = [[inlet, draw.log_uniform(9e3, 16e3)], [outlet, 0.0]], []
    third = draw.other(nodes, inlet, outlet)
    kind = draw.below(3)
    if kind == 1:
        fixed.append([third, draw.log_uniform(4e3, 8e3)])
    if kind == 2:
        terminals.append([third, draw.log_uniform(1e8, 1e12), 600.0])
    vessels = [[a, b, draw.log_uniform(2.0, 40.0), radius()] for a, b in pairs]
    return {"nodes": nodes, "vessels": vessels, "fixed": fixed, "terminals": terminals}


def eliminate(a, b):
    n = len(b)
    for k in range(n):
        pivot = next(i for i in range(k, n) if a[i][k] != 0)
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


def drops(case, opened):
    """The exact drop along every open vessel; zero where no condition reaches."""
    vessels = case["vessels"]
    reached = {n for n, _ in case["fixed"]} | {n for n, _, _ in case["terminals"]}
    while True:
        more = {n for row in opened for n in vessels[row][:2] if set(vessels[row][:2]) & reached} - reached
        if not more:
            break
        reached |= more
    pressure = {n: Fraction(p) for n, p in case["fixed"]}
    free = [n for n in sorted(reached) if n not in pressure]
    at = {n: i for i, n in enumerate(free)}
    a, b = [[Fraction(0)] * len(free) for _ in free], [Fraction(0)] * len(free)
    for row in opened:
        p, q, length, radius = vessels[row]
        c = Fraction(conductance(length, radius))
        for here, there in ((p, q), (q, p)):
            if here in at:
                a[at[here]][at[here]] += c
                if there in at:
                    a[at[here]][at[there]] -= c
                else:
                    b[at[here]] += c * pressure[there]
    for node, resistance, venous in case["terminals"]:
        a[at[node]][at[node]] += 1 / Fraction(resistance)
        b[at[node]] += Fraction(venous) / Fraction(resistance)
    pressure.update(zip(free, eliminate(a, b)))
    return {row: pressure.get(vessels[row][0], 0) - pressure.get(vessels[row][1], 0) for row in opened}


def to_24_bits(x):
    bits = struct.unpack("<q", struct.pack("<d", x))[0]
    return struct.unpack("<d", struct.pack("<q", (bits + (1 << 28)) >> 29 << 29))[0]


def forest(case, resilience):
    root = list(range(case["nodes"]))
    for row in sorted(resilience, key=lambda row: (-to_24_bits(float(resilience[row])), row)):
        a, b = (root[n] for n in case["vessels"][row][:2])
        if a != b:
            root = [b if r == a else r for r in root]
            yield row


def means(case):
    vessels = case["vessels"]
    m = len(vessels)
    likelihood, count, network = [Fraction(0)] * m, [0] * m, Fraction(0)
    for pattern in range(1, 1 << m):
        opened = [row for row in range(m) if pattern >> row & 1]
        resilience = {}
        for row, drop in drops(case, opened).items():
            if drop != 0:
                _, _, length, radius = vessels[row]
                resilience[row] = drop * drop * Fraction(conductance(length, radius)) / Fraction(volume(length, radius))
        network += sum(resilience.values()) / len(opened)
        for row in forest(case, resilience):
            likelihood[row] += resilience[row]
            count[row] += 1
    share = Fraction(1, 1 << m)
    return [float(x * share) for x in likelihood], [float(n * share) for n in count], float(network * share)


def text():
    figures = lambda row: [x if isinstance(x, int) else repr(x) for x in row]
    lines = []
    for seed in range(GRAPHS):
        case = graph(seed)
        likelihood, frequency, network = means(case)
        for key in ("vessels", "fixed", "terminals"):
            case[key] = [figures(row) for row in case[key]]
        case.update(likelihood=figures(likelihood), frequency=figures(frequency), network_resilience=repr(network))
        lines.append(" " + json.dumps(case))
    return "[\n" + ",\n".join(lines) + "\n]\n"


if __name__ == "__main__":
    path = Path(__file__).with_name("reference.json")
    if "--check" in sys.argv[1:]:
        sys.exit(0 if path.read_text() == text() else f"{path} differs")
    path.write_text(text())
