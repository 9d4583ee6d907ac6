"""Images of skelbench cases, with gaps that show nothing and with textured tissue. images.py SKELBENCH TRACINGS CASES LINES OUT LEVELS SEED DROPOUTS:TEXTURE...

CASES/<level>/<subject> are of make_cases.py with that seed, LINES/<level>/<subject> their centerlines with the truth (own.py, or CASES again). OUT has links to
these and an image-<dropouts>-<texture>.nii for each pair: the very image that the threshold of the mask was drawn in, which is checked.
"""
import hashlib
import json
import sys
from pathlib import Path

import nibabel as nib
import numpy as np

bench, tracings, cases, lines, out = (Path(name).resolve() for name in sys.argv[1:6])
levels, seed = sys.argv[6].split(","), int(sys.argv[7])
pairs = [name.split(":") for name in sys.argv[8:]]
sys.path.insert(0, str(bench))
import make_cases as make

FILES = make.find(tracings, set())
DONORS = sorted(FILES)


def drawn(name, level):
    """The image without and with noise, and its origin, as make_cases.py draws them."""
    of = make.LEVELS[level]
    step = of["voxel"] / 2
    rng = np.random.default_rng(int(hashlib.sha256(f"{name}/{level}/{seed}".encode()).hexdigest()[:12], 16))
    truth = make.Truth(*make.read_tracing(FILES[name]), step)
    veins = int(round(of["veins"] * len(np.unique(truth.branch))))
    if veins:
        others = [make.read_tracing(FILES[DONORS[int(k)]]) for k in rng.integers(len(DONORS), size=2)]
        make.add_veins(truth, [make.Truth(*other, step) for other in others], veins, rng, step)
    return make.image(truth, of, rng)


for level in levels:
    for case in sorted((cases / level).iterdir()):
        folder = out / level / case.name
        wanted = [(*pair, folder / f"image-{'-'.join(pair)}.nii") for pair in pairs]
        wanted = [one for one in wanted if not one[2].exists()]
        if not wanted:
            continue
        folder.mkdir(parents=True, exist_ok=True)
        for name in ("fragments.npz", "truth.json", "mask.nii.gz"):
            if (lines / level / case.name / name).exists() and not (folder / name).exists():
                (folder / name).symlink_to(lines / level / case.name / name)
        clean, noisy, origin = drawn(case.name, level)
        of = make.LEVELS[level]
        mask = make.segment(noisy, of)
        if not np.array_equal(mask, np.asarray(nib.load(case / "mask.nii.gz").dataobj) > 0):
            raise SystemExit(f"{case}: the mask is of another image")
        truth = json.loads((case / "truth.json").read_text())
        for dropouts, texture, path in wanted:
            image = noisy
            if float(dropouts) or float(texture):
                rng = np.random.default_rng(list(case.name.encode()) + [seed])
                image = make.spoil(clean, noisy, mask, truth, of["voxel"], origin, float(dropouts), float(texture), rng)
            part = path.with_name("part-" + path.name)
            make.save_nifti(part, image, of["voxel"], origin)
            part.rename(path)
        print(level, case.name, flush=True)
