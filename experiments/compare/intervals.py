"""Does the interval of 95 % of a repaired network hold its true length? Writes intervals.csv and the table of README.md. WILLIS names the program; needs
nothing but Python."""
import json
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
import common

# Phantoms whose damage no choice of a method was made on, and what they lack.
KINDS = {"whole": (), "without L-PComm": ("--without", "L-PComm"), "without R-A1": ("--without", "R-A1")}
EACH = 32


def measured(folder, kind, seed):
    """The length of the whole, mm: as it is once the true gaps are closed, as it is kept, and its interval."""
    scan, run, out = (folder / f"{kind}-{seed}{end}".replace(" ", "-") for end in (".swc", "-run", "-measured"))
    common.willis("phantom", "cerebral", *KINDS[kind], "--break", "--seed", seed, "-o", scan)
    common.willis("infer", scan, "-o", run, "-n", 10)
    common.willis("measure", run, "-o", out)
    observed = sum(float(row["length_mm"]) for row in common.rows(run / "edges.csv") if row["origin"] == "observed")
    gaps = json.loads(scan.with_suffix(".truth.json").read_text())["breaks"]
    (found,) = [row for row in common.rows(out / "intervals.csv") if row["figure"] == "length_mm"]
    figures = {"true_mm": observed + sum(gap["gap_mm"] for gap in gaps), "gaps": len(gaps)}
    return {"phantom": kind, "seed": seed, **figures, **{name: found[name] for name in ("value", "mean", "low", "high")}}


def main():
    results = []
    with tempfile.TemporaryDirectory() as temporary:
        for at, kind in enumerate(KINDS):
            seeds = range(40_000 + 1000 * at, 40_000 + 1000 * at + EACH)
            results += common.everywhere(lambda seed, kind=kind: measured(Path(temporary), kind, seed), seeds)
    common.write_results(HERE, results, "intervals.csv")
    lines = []
    for kind in KINDS:
        rows = [{name: value if name == "phantom" else float(value) for name, value in row.items()} for row in results if row["phantom"] == kind]
        mean = lambda of, rows=rows: sum(map(of, rows)) / len(rows)
        held = mean(lambda row: row["low"] <= row["true_mm"] <= row["high"])
        lines.append([
            kind,
            len(rows),
            f"{mean(lambda row: row['true_mm']):.0f}",
            f"{100 * held:.0f} %",
            f"{mean(lambda row: row['high'] - row['low']):.0f}",
            f"{mean(lambda row: row['mean'] - row['true_mm']):+.1f}",
            f"{mean(lambda row: row['value'] - row['true_mm']):+.1f}",
        ])
    header = ["phantom", "runs", "true length, mm", "interval holds it", "width, mm", "error of the mean, mm", "of the kept, mm"]
    common.splice(HERE / "README.md", "intervals", common.table(header, lines))


if __name__ == "__main__":
    main()
