"""Expert masks of two patients in CT and MR (TopCoW), their classes hidden: the class of what is named, and the seven segments."""
import answer
import cases
import common
import numpy as np
from networks import SHARED

DATA = SHARED / "topcow-masks"
# Classes of the masks; A1 and A2, M1 and M2, P1 and P2 are one class each, the third A2 (15) counts as left.
CLASSES = {
    1: ("BA",), 2: ("R-P1", "R-P2"), 3: ("L-P1", "L-P2"), 4: ("R-ICA",), 5: ("R-M1", "R-M2"), 6: ("L-ICA",), 7: ("L-M1", "L-M2"), 8: ("R-PComm",), 9: ("L-PComm",),
    10: ("AComm",), 11: ("R-A1", "R-A2"), 12: ("L-A1", "L-A2"), 15: ("L-A2", "R-A2"),
}
# The benchmark's own graphs of the two patients: what is absent.
ABSENT = {"003": {"L-A1"}, "014": {"L-PComm", "R-PComm"}}


def case(job):
    """(name, share of the named length with the right class, named share, {segment: probability}, patient)."""
    import nibabel
    from scipy.ndimage import distance_transform_edt

    path, work, model = job
    image = nibabel.load(path)
    classes = np.asarray(image.dataobj).astype(int)
    name = path.name.removesuffix(".nii.gz")
    hidden, out = work / f"{name}.nii.gz", work / f"{name}.graphml"
    if not (work / f"{name}.names.csv").exists():
        nibabel.save(nibabel.Nifti1Image((classes > 0).astype(np.uint8), image.affine), hidden)
        answer.label(hidden, out, model)
    rows = common.rows(work / f"{name}.names.csv")
    xyz = np.array([[float(r[f"{axis}_mm"]) for axis in "xyz"] for r in rows])
    voxel = np.rint(xyz @ np.linalg.inv(image.affine)[:3, :3].T + np.linalg.inv(image.affine)[:3, 3]).astype(int)
    voxel = np.clip(voxel, 0, np.array(classes.shape) - 1)
    near = distance_transform_edt(classes == 0, return_distances=False, return_indices=True)
    true = classes[tuple(near[(slice(None), *voxel.T)])]
    mm = np.array([float(r["length_mm"]) for r in rows])
    right = np.array([r["label"] in CLASSES[int(k)] for r, k in zip(rows, true)])
    named = np.array([r["label"] not in ("", cases.OTHER) for r in rows])
    segments = {r["segment"]: float(r["probability"]) for r in common.rows(work / f"{name}.segments.csv")}
    return name, mm @ right / mm.sum(), mm @ named / mm.sum(), segments, name.rpartition("_")[2]


def run(work, options):
    if not DATA.exists():
        print(f"skipped: there is no {DATA}")
        return None
    model = options.model or (options.models / "arteries.toml" if options.models else None)
    lines = []
    for name, right, named, segments, patient in common.everywhere(case, [(path, work, model) for path in sorted(DATA.glob("*.nii.gz"))]):
        wrong = [s for s in cases.RING if (segments[s] > 0.5) == (s in ABSENT[patient])]
        lines.append([name, f"{right:.3f}", f"{named:.3f}", f"{7 - len(wrong)} of 7", ", ".join(f"{s} {segments[s]:.3f}" for s in cases.RING)])
    return common.table(["mask", "class right, all length", "length named", "segments right", "probability of each segment"], lines)
