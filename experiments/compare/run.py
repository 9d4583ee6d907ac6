"""How often does willis measure --compare find a difference between two groups of phantoms, where there is none and where there is one?
Writes results.csv and the table of README.md. WILLIS names the program; needs nothing but Python."""
import random
import tempfile
from pathlib import Path

import sys

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common

POOL, SIZE = 96, 12
MEASURES = ("length_mm", "volume_mm3", "radius_mm", "ends", "parts", "box_dimension")
# What the second group lacks, and how often groups are drawn.
KINDS = {"no difference": (), "without L-PComm": ("--without", "L-PComm")}
DRAWS = {"no difference": 200, "without L-PComm": 60}


def make(folder, kind, at):
    """An extraction of the whole circle, or of one that lacks an artery, damaged by its seed."""
    path = folder / f"{kind.replace(' ', '-')}-{at}.swc"
    offset = 10_000 * (1 + list(KINDS).index(kind))
    common.willis("phantom", "cerebral", *KINDS[kind], "--break", "--seed", offset + at, "-o", path)
    return path


def compare(folder, kind, seed, pools):
    """The rows of comparison.csv of two groups that are drawn from the pools."""
    draw = random.Random(seed)
    if KINDS[kind]:
        groups = [draw.sample(pools["no difference"], SIZE), draw.sample(pools[kind], SIZE)]
    else:
        both = draw.sample(pools[kind], 2 * SIZE)
        groups = [both[:SIZE], both[SIZE:]]
    study = folder / f"{kind.replace(' ', '-')}-{seed}.csv"
    rows = [f"{group}{at},{path},{group}" for group, paths in zip("ab", groups) for at, path in enumerate(paths)]
    study.write_text("\n".join(["subject,input,group", *rows]) + "\n")
    out = study.with_suffix("")
    common.willis("measure", study, "-o", out, "--compare", "group", "--measures", ",".join(MEASURES), "--seed", seed)
    return common.rows(out / "comparison.csv")


def main():
    results = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        pools = {kind: common.everywhere(lambda at, kind=kind: make(folder, kind, at), range(POOL)) for kind in KINDS}
        for kind in KINDS:
            for seed, rows in enumerate(common.everywhere(lambda seed: compare(folder, kind, seed, pools), range(DRAWS[kind]))):
                results += [{"groups": kind, "seed": seed, **{name: row[name] for name in ("measure", "cliffs_delta", "delta_low", "delta_high", "p", "p_holm")}} for row in rows]
    common.write_results(HERE, results)
    report(results)


def report(results):
    lines = []
    for kind, draws in DRAWS.items():
        of = [row for row in results if row["groups"] == kind]
        share = lambda rows, test: f"{100 * sum(map(test, rows)) / draws:.1f} %"
        each = [share([row for row in of if row["measure"] == name], lambda row: float(row["p"]) <= 0.05) for name in MEASURES]
        families = [[row for row in of if int(row["seed"]) == seed] for seed in range(draws)]
        found = share(families, lambda rows: any(float(row["p_holm"]) <= 0.05 for row in rows))
        holds = [float(row["delta_low"]) <= 0 <= float(row["delta_high"]) for row in of]
        lines.append([kind, draws, *each, found, f"{100 * sum(holds) / len(holds):.1f} %"])
    header = ["groups", "draws", *(f"`{name}`" for name in MEASURES), "any, by Holm", "interval holds 0"]
    common.splice(HERE / "README.md", "rates", common.table(header, lines))


if __name__ == "__main__":
    main()
