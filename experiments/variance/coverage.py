"""Of how many vessels L lies within 1.96 `std_error`, by how many samples saw them: coverage.py writes
coverage.md, the table on the page What willis promises. WILLIS names the program; needs nothing but Python."""
import csv
import os
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "experiments"))
import common

CIRCLE = ROOT / "data/broken-circle-of-willis.swc"
TRUTH, RUNS = 2_000_000, 60
GROUPS = (("none", 0, 0), ("1 to 4", 1, 4), ("5 to 19", 5, 19), ("20 and more", 20, None))


def run(folder, samples, seed, options):
    """L, its error (none where it is unknown) and how many samples saw it, by vessel."""
    out = Path(folder) / f"{samples}-{seed}"
    words = [common.WILLIS, "infer", CIRCLE, "--uncertain", "all", "-n", samples, "--seed", seed, "-o", out, "--quiet", "--force", "--dpi", 36, *options]
    subprocess.run([str(word) for word in words], check=True)
    with open(out / "edges.csv", newline="") as file:
        error = lambda text: float(text) if text else None
        rows = [(float(row["likelihood"]), error(row["std_error"]), round(float(row["frequency"]) * samples)) for row in csv.DictReader(file)]
    shutil.rmtree(out)
    return rows


def main():
    lines = []
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(os.cpu_count()) as pool:
        for samples, options in ((1000, ()), (64, ()), (640, ("--epsilon", 0.95)), (64, ("--epsilon", 0.95))):
            truth = run(folder, TRUTH, 10**6, options)
            within, unknown = {name: [0, 0] for name, *_ in GROUPS}, 0
            for rows in pool.map(lambda seed: run(folder, samples, seed, options), range(RUNS)):
                for (found, error, seen), (true, *_) in zip(rows, truth):
                    if error is None:
                        unknown += 1
                        continue
                    name = next(name for name, least, most in GROUPS if seen >= least and (most is None or seen <= most))
                    within[name][0] += abs(found - true * samples / TRUTH) <= 1.96 * error
                    within[name][1] += 1
            shown = [f"{100 * right / of:.1f} % of {of:,}" if of else "" for right, of in within.values()]
            lines.append([" ".join([f"{samples:,}", *(f"`{word}`" for word in options[:1]), *map(str, options[1:])]), *shown, f"{unknown:,}"])
    heading = ["samples", *(f"seen in {name}" for name, *_ in GROUPS), "not known"]
    Path(__file__).with_name("coverage.md").write_text(common.table(heading, lines) + "\n")
    common.made_with("variance", "coverage")


if __name__ == "__main__":
    main()
