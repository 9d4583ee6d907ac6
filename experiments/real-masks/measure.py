"""Real masks as they are, with gaps and fusions put into them, and with specks, answered by willis; the table of README.md too.

    measure.py SKELBENCH DATA WORK [--masks 001,002] [--seeds 1,2,3]

Prints results.csv: mask, put in (nothing, specks, or the seed of skelbench's implant.py, whose figures they then are), answer, figure, value. DATA holds
kdxf-masks. WILLIS names the program, whose time and memory GNU time measures. Cases and answers are kept in WORK, and gone on from.
"""
import argparse
import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import nibabel
import numpy as np
from scipy import ndimage

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import common

HERE = Path(__file__).resolve().parent
WILLIS = os.environ.get("WILLIS", "target/release/willis")
ANSWERS = {"default": [], "nothing cut": ["--cut", "never"]}
#: Of each kind of speck so many, of twelve voxels, between so many mm from all vessels, and as far as the first from one another.
SPECKS, AWAY = 100, (3.0, 12.0)


def infer(mask, out, options):
    """CPU seconds and peak memory in MB of a run, which is made once. GNU time starts it: a child of Python counts Python's memory too."""
    kept = out.with_suffix(".json")
    if not kept.exists():
        words = ["time", "-f", "%U %S %M", "-o", out.with_suffix(".time"), WILLIS, "infer", mask, "-o", out, "--force", "--quiet", "--threads", "2"]
        subprocess.run([str(word) for word in [*words, *options]], check=True)
        user, system, kib = map(float, out.with_suffix(".time").read_text().split())
        kept.write_text(json.dumps({"cpu_s": user + system, "peak_mb": kib / 1024}))
    return json.loads(kept.read_text())


def whole(out):
    """What run.json says of the topology."""
    counts = json.loads((out / "run.json").read_text())["counts"]
    topology = counts["topology"]
    return {"vessels": counts["observed"], "outlets": counts["outlets"], "cycles": topology["cycles"], "parts": topology["components"]}


def specks(raw, case):
    """The mask with specks, blocks of 2 x 2 x 3 voxels and others grown voxel by voxel, and their places in mm."""
    image = nibabel.load(raw)
    mask = np.asarray(image.dataobj) > 0
    zoom = np.linalg.norm(image.affine[:3, :3], axis=0)
    rng = np.random.default_rng(0)
    away = ndimage.distance_transform_edt(~mask, sampling=zoom)
    low, high = np.argwhere(mask).min(0), np.argwhere(mask).max(0)
    changed, places = mask.copy(), []
    while len(places) < 2 * SPECKS:
        centre = rng.integers(low, high)
        if not AWAY[0] < away[tuple(centre)] < AWAY[1] or any(np.linalg.norm((centre - place) * zoom) < AWAY[0] + 1 for place in places):
            continue
        voxels = {(i, j, k) for i in range(2) for j in range(2) for k in range(3)} if len(places) < SPECKS else {(0, 0, 0)}
        while len(voxels) < 12:
            voxel = list(sorted(voxels)[rng.integers(len(voxels))])
            voxel[rng.integers(3)] += rng.choice([-1, 1])
            voxels.add(tuple(voxel))
        for voxel in voxels:
            changed[tuple(np.clip(centre + np.array(voxel), 0, np.array(mask.shape) - 1))] = True
        places.append(centre)
    case.mkdir(parents=True, exist_ok=True)
    nibabel.save(nibabel.Nifti1Image(changed.astype(np.uint8), image.affine), case / "mask.nii.gz")
    (case / "places.json").write_text(json.dumps([(image.affine @ np.r_[place, 1])[:3].tolist() for place in places]))


def joined(implant, case, out):
    """How many of the specks hang on the longest part of the answer."""
    net = implant.Fixed(implant.S.read_graphml(out / "topology.graphml"), 0.6).net
    length = np.bincount(net.comp[net.pairs[:, 0]], np.linalg.norm(net.xyz[net.pairs[:, 0]] - net.xyz[net.pairs[:, 1]], axis=1))
    near = [net.kd.query_ball_point(place, 2.5) for place in json.loads((case / "places.json").read_text())]
    return {"specks_joined": sum(any(net.comp[point] == length.argmax() for point in points) for points in near)}


def measured(given, implant):
    for mask in given.masks.split(","):
        raw = given.data / f"kdxf-masks/KDXF_{mask}.nii.gz"
        for put_in in ["nothing", "specks", *given.seeds.split(",")]:
            case, judge = given.work / "cases" / f"{mask}-{put_in}", lambda answer: {}
            if put_in == "specks":
                judge = lambda answer: joined(implant, case, answer)
                if not (case / "places.json").exists():
                    specks(raw, case)
            elif put_in != "nothing":
                judge = lambda answer: implant.judge(case, answer)
                if not (case / "truth.json").exists():
                    words = [sys.executable, given.bench / "implant.py", "make", raw, case, "--seed", put_in]
                    subprocess.run([str(word) for word in words], check=True, stdout=subprocess.DEVNULL)
            for name, options in ANSWERS.items():
                if name != "default" and put_in == "specks":
                    continue
                answer = given.work / name.replace(" ", "-") / f"{mask}-{put_in}"
                answer.parent.mkdir(parents=True, exist_ok=True)
                figures = infer(raw if put_in == "nothing" else case / "mask.nii.gz", answer, options) | whole(answer)
                for figure, value in (figures | judge(answer)).items():
                    yield [mask, put_in, name, figure, f"{value:.6g}"]


def table():
    """README.md's table, of results.csv: a row a mask and the means."""
    found = {}
    for row in common.rows(HERE / "results.csv"):
        kind = row["put_in"] if row["put_in"] in ("nothing", "specks") else "implants"
        found.setdefault((row["mask"], kind, row["answer"], row["figure"]), []).append(float(row["value"]))
    masks = sorted({mask for mask, *_ in found})
    columns = {
        "vessels": ("nothing", "default", "vessels", "%.0f"), "cycles, nothing cut": ("nothing", "nothing cut", "cycles", "%.0f"),
        "cycles": ("nothing", "default", "cycles", "%.0f"), "parts": ("nothing", "default", "parts", "%.0f"), "CPU, s": ("nothing", "default", "cpu_s", "%.1f"),
        "peak, MB": ("nothing", "default", "peak_mb", "%.0f"), "gaps closed": ("implants", "default", "gaps_closed", "%.3f"),
        "fusions undone": ("implants", "default", "fusions_undone", "%.3f"), "safe lost": ("implants", "default", "safe_lost", "%.3f"),
        "cycles with implants": ("implants", "default", "cycles", "%.1f"), "of 200 specks joined": ("specks", "default", "specks_joined", "%.0f"),
    }
    cell = lambda mask, key: np.nanmean(found[mask, *key])
    lines = [[mask, *(form % cell(mask, key) for *key, form in columns.values())] for mask in masks]
    lines.append(["mean", *(("%.1f" if form == "%.0f" else form) % np.mean([cell(mask, key) for mask in masks]) for *key, form in columns.values())])
    common.splice(HERE / "README.md", "masks", common.table(["KDXF", *columns], lines))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bench", "data", "work"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--masks", default=",".join(f"{n:03}" for n in range(1, 11)))
    parser.add_argument("--seeds", default="1,2,3")
    given = parser.parse_args()
    sys.path.insert(0, str(given.bench))
    import implant

    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["mask", "put_in", "answer", "figure", "value"])
    for row in measured(given, implant):
        out.writerow(row)
        sys.stdout.flush()


if __name__ == "__main__":
    table() if sys.argv[1:] == ["table"] else main()
