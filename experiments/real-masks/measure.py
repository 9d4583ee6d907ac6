"""Real masks as they are, and with gaps and fusions put into them, answered by willis. measure.py SKELBENCH DATA WORK [--masks 001,002] [--seeds 1,2,3].

Prints results.csv: mask, seed (0: nothing put in), answer, figure, value. DATA holds kdxf-masks. WILLIS names the program, whose time and memory are
measured by the system. Cases and answers are kept in WORK. The figures are those of skelbench's implant.py.
"""
import argparse
import csv
import json
import os
import subprocess
import sys
from pathlib import Path

WILLIS = os.environ.get("WILLIS", "target/release/willis")
ANSWERS = {"default": [], "nothing cut": ["--cut", "never"], "cavities kept": ["--cavities", "keep"]}


def infer(mask, out, options):
    """CPU seconds and peak memory in MB of a run, which is made once."""
    kept = out.with_suffix(".json")
    if not kept.exists():
        words = [WILLIS, "infer", mask, "-o", out, "--force", "--quiet", "--threads", "2", *options]
        process = subprocess.Popen([str(word) for word in words])
        _, status, used = os.wait4(process.pid, 0)
        if status:
            raise SystemExit(f"{words}: status {status}")
        kept.write_text(json.dumps({"cpu_s": used.ru_utime + used.ru_stime, "peak_mb": used.ru_maxrss / 1024}))
    return json.loads(kept.read_text())


def whole(out):
    """What run.json says of the topology."""
    counts = json.loads((out / "run.json").read_text())["counts"]
    return {"vessels": counts["observed"], "cycles": counts["topology"]["cycles"], "parts": counts["topology"]["components"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bench", type=Path)
    parser.add_argument("data", type=Path)
    parser.add_argument("work", type=Path)
    parser.add_argument("--masks", default=",".join(f"{n:03}" for n in range(1, 11)))
    parser.add_argument("--seeds", default="1,2,3")
    given = parser.parse_args()
    sys.path.insert(0, str(given.bench))
    import implant

    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["mask", "seed", "answer", "figure", "value"])
    for mask in given.masks.split(","):
        raw = given.data / f"kdxf-masks/KDXF_{mask}.nii.gz"
        for seed in ["0", *given.seeds.split(",")]:
            case = given.work / "cases" / f"{mask}-{seed}"
            if seed != "0" and not (case / "truth.json").exists():
                words = [sys.executable, given.bench / "implant.py", "make", raw, case, "--seed", seed]
                subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL)
            for name, options in ANSWERS.items():
                if seed != "0" and name == "cavities kept":
                    continue
                answer = given.work / name.replace(" ", "-") / f"{mask}-{seed}"
                answer.parent.mkdir(parents=True, exist_ok=True)
                figures = infer(raw if seed == "0" else case / "mask.nii.gz", answer, options) | whole(answer)
                if seed != "0":
                    figures |= implant.judge(case, answer)
                for figure, value in figures.items():
                    out.writerow([mask, seed, name, figure, f"{value:.6g}"])
                sys.stdout.flush()


if __name__ == "__main__":
    main()
