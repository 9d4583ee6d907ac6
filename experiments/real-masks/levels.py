"""Masks thinned at a level where necks break, answered by willis; the tables of levels in README.md.

    levels.py SKELBENCH DATA WORK [--masks 005,006,007] [--seeds 1] [--simulated CASES] [--changes "level .5;necks .7"] [--each]

WORK/cases holds cases of implant.py, a folder MASK-SEED each, as measure.py makes them; CASES holds simulated scans of make_cases.py made with --save-mask, as
level/subject. The mask of each is changed, thinned and answered. Beside implant.py's figures of real masks stand the share of the length of the skeleton before anything was put in that the answer
shows within 1.5 mm, and its radii there over those of the answer to the mask as it is. WILLIS names the program.
"""
import argparse
import os
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import nibabel
import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

WILLIS = os.environ.get("WILLIS", "target/release/willis")
#: The skeleton is shown by lines within so many mm.
SHOWN = 1.5
#: Half of the 26 steps to neighbours.
STEPS = [(i, j, k) for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1) if (i, j, k) > (0, 0, 0)]


def at_level(mask, affine, sigma, level, finer):
    """The mask smoothed by sigma mm and cut at a level, on a grid so many times finer."""
    zoom = np.linalg.norm(affine[:3, :3], axis=0)
    field = ndimage.gaussian_filter(mask.astype(np.float32), sigma / zoom) if finer == 1 else None
    if finer > 1:
        # Smoothed on the finer grid, where each voxel is finer x finer x finer equal ones.
        fine = mask.astype(np.float32).repeat(finer, 0).repeat(finer, 1).repeat(finer, 2)
        field = ndimage.gaussian_filter(fine, sigma * finer / zoom)
        affine = affine @ np.diag([1 / finer] * 3 + [1.0])
        affine[:3, 3] += affine[:3, :3] @ np.full(3, (1 - finer) / 2)
    return field >= level, affine


def necks_opened(mask, affine, sigma, least):
    """The mask with necks taken out that close a loop and are weak: their level is below so much of those of both vessels.

    The smoothed mask falls into basins around its peaks. Two basins that touch have a pass between them; its level over the lesser peak is how strong their
    neck is. In the order of their strength necks join basins (Kruskal's algorithm); of those that would close a loop the weak ones are taken out.
    """
    from skimage.measure import label
    from skimage.morphology import local_maxima
    from skimage.segmentation import watershed

    zoom = np.linalg.norm(affine[:3, :3], axis=0)
    whole = np.ones((3, 3, 3))
    box = tuple(slice(max(0, s.start - 1), s.stop + 1) for s in ndimage.find_objects(mask.astype(np.uint8))[0])
    inside = mask[box]
    field = ndimage.gaussian_filter(mask.astype(np.float32), sigma / zoom)[box]
    peaks = label(local_maxima(np.where(inside, field, 0), connectivity=3) & inside, connectivity=3)
    basin = watershed(-field, peaks, mask=inside, connectivity=whole)
    peak = ndimage.maximum(field, basin, np.arange(basin.max() + 1))
    shape, passes, walls = np.array(inside.shape), {}, {}
    for step in STEPS:
        here = tuple(slice(max(0, -s), n - max(0, s)) for s, n in zip(step, shape))
        there = tuple(slice(max(0, s), n - max(0, -s)) for s, n in zip(step, shape))
        across = (basin[here] != basin[there]) & (basin[here] > 0) & (basin[there] > 0)
        start = np.argwhere(across) + [max(0, -s) for s in step]
        for p, q in zip(start.tolist(), (start + step).tolist()):
            p, q = tuple(p), tuple(q)
            if basin[p] > basin[q]:
                p, q = q, p
            pair = basin[p], basin[q]
            passes[pair] = max(passes.get(pair, 0.0), min(field[p], field[q]))
            walls.setdefault(pair, set()).add(q)
    strength = {pair: level / min(peak[list(pair)]) for pair, level in passes.items()}
    parent = list(range(basin.max() + 1))

    def find(a):
        while parent[a] != a:
            parent[a] = parent[parent[a]]
            a = parent[a]
        return a

    changed, taken = inside.copy(), 0
    for pair in sorted(strength, key=strength.get, reverse=True):
        a, b = map(find, pair)
        if a != b:
            parent[a] = b
        elif strength[pair] < least:
            changed[tuple(np.array(sorted(walls[pair])).T)] = False
            taken += 1
    out = mask.copy()
    out[box] = changed
    return out, affine


#: By name: how a mask is changed, and whether the whole mask is looked at beside the lines.
CHANGES = {
    "as it is": (lambda mask, affine: (mask, affine), False),
    "level .5": (lambda mask, affine: at_level(mask, affine, 0.35, 0.5, 1), False),
    "level .7": (lambda mask, affine: at_level(mask, affine, 0.35, 0.7, 1), False),
    "level .55, twice as fine": (lambda mask, affine: at_level(mask, affine, 0.35, 0.55, 2), False),
    "level .5, whole mask beside": (lambda mask, affine: at_level(mask, affine, 0.35, 0.5, 1), True),
    "level .7, whole mask beside": (lambda mask, affine: at_level(mask, affine, 0.35, 0.7, 1), True),
    "level .55, twice as fine, whole mask beside": (lambda mask, affine: at_level(mask, affine, 0.35, 0.55, 2), True),
    "necks .5": (lambda mask, affine: necks_opened(mask, affine, 0.35, 0.5), False),
    "necks .7": (lambda mask, affine: necks_opened(mask, affine, 0.35, 0.7), False),
    "necks .9": (lambda mask, affine: necks_opened(mask, affine, 0.35, 0.9), False),
}


def answer(mask, affine, whole, out):
    """The folder of the answer to a mask, which is made once; with the whole mask beside the lines where it is given."""
    if not (out / "run.json").exists():
        out.parent.mkdir(parents=True, exist_ok=True)
        file, options = out.with_suffix(".nii.gz"), ["-n", 1, "--force", "--quiet", "--threads", 1]
        nibabel.save(nibabel.Nifti1Image(mask.astype(np.uint8), affine), file)
        words = [WILLIS, "infer", file, "-o", out, *options]
        if whole:
            lines = out.with_suffix(".npz")
            subprocess.run([WILLIS, "skeleton", str(file), "-o", str(lines), "--force", "--quiet"], check=True)
            words = [WILLIS, "infer", lines, "--mask", whole, "-o", out, *options]
        subprocess.run([str(word) for word in words], check=True)
        file.unlink()
    return out


def points_of(folder):
    """Points and radii (mm) of the vessels of an answer, a quarter of a mm apart."""
    root = ElementTree.parse(folder / "topology.graphml").getroot()
    space = root.tag[: root.tag.index("}") + 1]
    key = next(key.get("id") for key in root.iter(space + "key") if key.get("attr.name") == "points")
    out = []
    for data in root.iter(space + "data"):
        if data.get("key") == key and data.text:
            line = np.array([[float(x) for x in point.split()[:4]] for point in data.text.split(";") if point.strip()])
            along = np.r_[0, np.cumsum(np.linalg.norm(np.diff(line[:, :3], axis=0), axis=1))]
            at = np.linspace(0, along[-1], max(2, int(along[-1] / 0.25) + 1))
            out.append(np.stack([np.interp(at, along, line[:, k]) for k in range(line.shape[1])], 1))
    return np.vstack(out)


def true_lines(raw, kept):
    """The middles of the skeleton's edges of a mask, and their lengths, mm."""
    if not kept.exists():
        image = nibabel.load(raw)
        _, points, edges, _, _ = implant.skeleton(np.asarray(image.dataobj) > 0, image.affine)
        ends = points[edges[:, 0]], points[edges[:, 1]]
        np.savez(kept, middles=(ends[0] + ends[1]) / 2, lengths=np.linalg.norm(ends[0] - ends[1], axis=1))
    found = np.load(kept)
    return found["middles"], found["lengths"]


def shown(lines, folder, plain):
    """The share of the length of some lines that an answer shows, and the median of its radii there over those of another answer."""
    middles, lengths = lines
    here, there = points_of(folder), points_of(plain)
    (off, at), (off_plain, at_plain) = (cKDTree(points[:, :3]).query(middles) for points in (here, there))
    both = (off < SHOWN) & (off_plain < SHOWN) & (there[at_plain, 3] > 0)
    return dict(shown=float(lengths[off < SHOWN].sum() / lengths.sum()), radius=float(np.median(here[at[both], 3] / there[at_plain[both], 3])))


def cases_of(given):
    """Per case: mask (a file), its subject, its name, how an answer is judged."""
    for mask in filter(None, given.masks.split(",")):
        for seed in given.seeds.split(","):
            case = given.work / "cases" / f"{mask}-{seed}"
            lines = true_lines(given.data / f"kdxf-masks/KDXF_{mask}.nii.gz", given.work / "cases" / f"{mask}.npz")
            yield case / "mask.nii.gz", mask, case.name, lambda out, plain, case=case, lines=lines: implant.judge(case, out) | shown(lines, out, plain)
    for truth in sorted(given.simulated.glob("*/*/truth.json")) if given.simulated else []:
        case = truth.parent
        name = f"{case.parent.name}-{case.name}"

        def judge(out, plain, case=case):
            of = score.Case(case)
            return score.score(of, *score.read_answer(out, of))

        yield case / "mask.nii.gz", case.parent.name, name, judge


REAL = {"gaps closed": "gaps_closed", "fusions undone": "fusions_undone", "safe lost": "safe_lost", "cycles": "cycles", "parts": "parts",
        "length shown": "shown", "radius": "radius"}
SIMULATED = {"path": "path", "nrun": "nrun", "cut recall": "cut_recall", "lost": "lost_connections", "cycles": "cycles", "join recall": "join_recall"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("bench", "data", "work"):
        parser.add_argument(name, type=Path)
    parser.add_argument("--masks", default="005,006,007")
    parser.add_argument("--seeds", default="1")
    parser.add_argument("--simulated", type=Path)
    parser.add_argument("--changes", default=";".join(CHANGES), help="their names, with ; between")
    parser.add_argument("--each", action="store_true", help="a row a case too")
    given = parser.parse_args()
    global implant, score
    sys.path.insert(0, str(given.bench))
    import implant
    import score

    found = {}
    for file, group, name, judge in cases_of(given):
        image = nibabel.load(file)
        mask = ndimage.binary_fill_holes(np.asarray(image.dataobj) > 0)
        plain = None
        for change in dict.fromkeys(["as it is", *given.changes.split(";")]):
            make, beside = CHANGES[change]
            out = given.work / "levels" / change.replace(" ", "-").replace(",", "") / name
            if not (out / "run.json").exists():
                changed, affine = make(mask, image.affine)
                answer(changed, affine, file if beside else None, out)
            plain = plain or out
            figures = judge(out, plain)
            kind = group if group.isalpha() else "real"
            found.setdefault((kind, change), []).append((name, figures))
            print(name, change, {k: round(v, 3) for k, v in figures.items() if isinstance(v, (int, float))}, file=sys.stderr, flush=True)
    for kind in dict.fromkeys(kind for kind, _ in found):
        columns = REAL if kind == "real" else SIMULATED
        print(f"\n| {kind} | " + " | ".join(columns) + " |\n" + "|---" * (len(columns) + 1) + "|")
        for (of, change), rows in found.items():
            if of == kind:
                cells = lambda rows: " | ".join("%.3f" % np.nanmean([figures[key] for _, figures in rows]) for key in columns.values())
                print(f"| {change} | {cells(rows)} |")
                for row in rows if given.each else []:
                    print(f"| {row[0]} | {cells([row])} |")


if __name__ == "__main__":
    main()
