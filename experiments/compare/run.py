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
FIGURES = ("measure", "cliffs_delta", "delta_low", "delta_high", "doubt_share", "p", "p_holm")
MEASURES = ("length_mm", "volume_mm3", "radius_mm", "ends", "parts", "box_dimension")
# What the second group lacks, and how often groups are drawn; of extractions as they are, and of the runs that repair them.
LACKS = {"no difference": None, "without L-PComm": "L-PComm", "without L-P2": "L-P2"}
DRAWS = {"no difference": 200, "without L-PComm": 60, "without L-P2": 60}


def make(folder, kind, at):
    """An extraction of the whole circle, or of one that lacks an artery, damaged by its seed; and a run that repairs it."""
    path = folder / f"{kind.replace(' ', '-')}-{at}.swc"
    seed = 10_000 * (1 + list(LACKS).index(kind)) + at
    without = ("--without", LACKS[kind]) if LACKS[kind] else ()
    common.willis("phantom", "cerebral", *without, "--break", "--seed", seed, "-o", path)
    run = path.with_suffix(".run")
    common.willis("infer", path, "-o", run, "--samples", 100, "--seed", seed)
    return path, run


def compare(folder, kind, repaired, seed, pools):
    """The rows of comparison.csv of two groups that are drawn from the pools."""
    draw = random.Random(seed)
    if LACKS[kind]:
        groups = [draw.sample(pools["no difference"], SIZE), draw.sample(pools[kind], SIZE)]
    else:
        both = draw.sample(pools[kind], 2 * SIZE)
        groups = [both[:SIZE], both[SIZE:]]
    study = folder / f"{kind.replace(' ', '-')}-{repaired}-{seed}.csv"
    rows = [f"{group}{at},{made[repaired]},{group}" for group, members in zip("ab", groups) for at, made in enumerate(members)]
    study.write_text("\n".join(["subject,input,group", *rows]) + "\n")
    out = study.with_suffix("")
    common.willis("measure", study, "-o", out, "--compare", "group", "--measures", ",".join(MEASURES), "--seed", seed)
    return common.rows(out / "comparison.csv")


def main():
    results = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        pools = {kind: common.everywhere(lambda at, kind=kind: make(folder, kind, at), range(POOL)) for kind in LACKS}
        for kind, draws in DRAWS.items():
            for repaired in (False, True):
                for seed, rows in enumerate(common.everywhere(lambda seed: compare(folder, kind, repaired, seed, pools), range(draws))):
                    results += [{"groups": kind, "repaired": int(repaired), "seed": seed, **{name: row[name] for name in FIGURES}} for row in rows]
    common.write_results(HERE, results)
    report(results)


def report(results):
    lines = []
    for kind, repaired in dict.fromkeys((row["groups"], int(row["repaired"])) for row in results):
        of, draws = [row for row in results if (row["groups"], int(row["repaired"])) == (kind, repaired)], DRAWS[kind]
        share = lambda rows, test: f"{100 * sum(map(test, rows)) / draws:.1f} %"
        each = [share([row for row in of if row["measure"] == name], lambda row: float(row["p"]) <= 0.05) for name in MEASURES]
        families = [[row for row in of if int(row["seed"]) == seed] for seed in range(draws)]
        found = share(families, lambda rows: any(float(row["p_holm"]) <= 0.05 for row in rows))
        holds = [float(row["delta_low"]) <= 0 <= float(row["delta_high"]) for row in of]
        doubt = [float(row["doubt_share"] or 0) for row in of]
        lines.append([kind, "runs" if repaired else "extractions", draws, *each, found, f"{100 * sum(holds) / len(holds):.1f} %", f"{sum(doubt) / len(doubt):.2f}"])
    header = ["groups", "of", "draws", *(f"`{name}`" for name in MEASURES), "any, by Holm", "interval holds 0", "share of doubt"]
    common.splice(HERE / "README.md", "rates", common.table(header, lines))


if __name__ == "__main__":
    main()
