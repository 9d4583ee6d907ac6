"""How often the ring of the published circle stays above the median of L, over random geometries of it."""
import sys
from collections import Counter
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common
from circles import RING
from figure import draw
from measure import ARTERIES, CHOICES, EPSILONS, RADII, SETTINGS, UNCERTAIN, kind, measure

GEOMETRIES = range(100)


def chosen(results, **wanted):
    return [r for r in results if all(r[key] == value for key, value in wanted.items())]


def whole(some):
    return sum("0" not in r["ring"] for r in some)


def percent(some, what):
    return f"{100 * sum(r[what + '_above'] for r in some) / sum(r[what] for r in some):.0f} %" if some[0][what] else ""


def survival(results):
    """The ring whole, true vessels and false candidates above the median."""
    for uncertain in UNCERTAIN:
        for radius in RADII:
            for epsilon in EPSILONS:
                some = chosen(results, choice="base", uncertain=uncertain, radius=radius, epsilon=epsilon)
                if some:
                    yield [UNCERTAIN[uncertain], RADII[radius], epsilon, f"{whole(some)} of {len(some)}", percent(some, "true"), percent(some, "false")]


def fallen(results):
    """What is missing, most frequent first."""
    for radius in RADII:
        for epsilon in EPSILONS:
            some = chosen(results, choice="base", uncertain="all", radius=radius, epsilon=epsilon)
            sets = Counter()
            for r in some:
                lost = Counter(kind(label) for label, above in zip(RING, r["ring"]) if above == "0")
                named = [artery if artery == "AComm" else f"{('one', 'both')[lost[artery] - 1]} {artery}" for artery in ARTERIES if lost[artery]]
                sets[", ".join(named) or "nothing"] += 1
            most = sorted(sets.items(), key=lambda s: (-s[1], s[0]))[:3]
            yield [RADII[radius], epsilon, *[f"{name}: {n}" for name, n in most], *[""] * (3 - len(most))]


def why(results, epsilon):
    """Flow with nothing occluded, the two factors of L, and which of them fells each artery of the ring."""
    bare = {r["geometry"]: r["shares"] for r in chosen(results, choice="base", uncertain="all", radius="none", epsilon=epsilon)}
    for radius in RADII:
        some = chosen(results, choice="base", uncertain="all", radius=radius, epsilon=epsilon)
        for artery in ARTERIES:
            pairs = [(r, label) for r in some for label in RING if kind(label) == artery]
            middle = lambda figure: common.quantile([figure(r, label) for r, label in pairs], 0.5)
            lost = [r["factors"][label] for r, label in pairs if r["ring"][RING.index(label)] == "0"]
            seldom = sum(often <= strong for _, often, strong in lost)
            yield [
                RADII[radius], artery, f"{len(pairs) - len(lost)} of {len(pairs)}",
                f"{100 * middle(lambda r, label: bare[r['geometry']][label]):.1f} %", f"{100 * middle(lambda r, label: r['shares'][label]):.1f} %",
                f"{100 * middle(lambda r, label: r['factors'][label][0]):.0f} %", f"{middle(lambda r, label: r['factors'][label][2]):.2g}", seldom, len(lost) - seldom,
            ]


def sensitivity(results):
    """Whole rings, and the artery that is missing most, under other choices."""
    for choice, (name, *_) in CHOICES.items():
        line = [name]
        for epsilon in EPSILONS:
            some = chosen(results, choice=choice, radius="mean", uncertain="all", epsilon=epsilon)
            lost = Counter(kind(label) for r in some for label, above in zip(RING, r["ring"]) if above == "0")
            line.append(f"{whole(some)} of {len(some)}" + (f", {lost.most_common(1)[0][0]}" if lost else ""))
        yield line


def main():
    results = [row for rows in common.everywhere(measure, [(setting, seed) for setting in SETTINGS for seed in GEOMETRIES]) for row in rows]
    common.write_results(HERE, [{key: r[key] for key in list(r)[:10]} for r in results])
    tables = {
        "survival": (["uncertain", "candidate radius", "ε", "ring whole", "true vessels above the median", "false candidates above it"], survival(results)),
        "fallen": (["candidate radius", "ε", "missing in most geometries", "next", "next"], fallen(results)),
        "why": (["candidate radius", "artery", "above the median", "flow in the circle", "with candidates", "in the forest", "ρ there, × median", "fell: seldom in it", "fell: low ρ"], why(results, "0.3")),
        "sensitivity": (["mean of the ends, all uncertain", *[f"ε = {e}" for e in EPSILONS]], sensitivity(results)),
    }
    for mark, (header, lines) in tables.items():
        common.splice(HERE / "README.md", mark, common.table(header, lines))
    draw(HERE, chosen(results, choice="base", uncertain="all"), RADII, EPSILONS)


main()
