"""Names that `willis label` gave against the truth: score.py CASES ANSWERS [--levels ...] [--worst N]; ANSWERS holds CASE.names.csv, CASE.landmarks.csv, CASE.segments.csv."""
import argparse
import csv
import json
import sys
from multiprocessing import Pool
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
import cases
import common

LEVELS = ("whole", *cases.LEVELS)
LABELS = [f"{s}-{a}" for a in ("ICA", "M1", "M2", "A1", "A2", "P1", "P2", "PComm") for s in "LR"] + ["BA", "AComm", cases.OTHER]
AT = {label: i for i, label in enumerate(LABELS)}
TRUE = len(LABELS) - 1
# M1 and M2 as one: where one becomes the other is a convention where no bifurcation is traced.
AS_ONE = np.array([AT[label.replace("M1", "M2")] for label in LABELS])
# Of a row of names.csv: points of an edge are interpolated this densely (mm), so that the nearest row is one of the same vessel.
DENSE = 0.25
BINS, REPLICAS = 15, 2000
# The kinds of landmarks, by the label in cases.MARKS without its sides; a row of landmarks.csv answers for a kind if it names all of these arteries.
KINDS = {
    "ICA/M1/A1": ("ICA", "M1", "A1"), "A1/A2": ("A1", "A2"), "M1/M2": ("M1", "M2"), "ICA/PComm": ("ICA", "PComm"), "P1/P2/PComm": ("PComm", "P2"),
    "P1/P2": ("P1", "P2"), "BA/P1/P1": ("BA", "P1"),
}


def truth(folder):
    """The truth of a case: the dictionary, points in the file's frame, number of the label of each, and the length (mm) each stands for."""
    known = json.loads((folder / "truth.json").read_text())
    rows = np.loadtxt(folder / "fragments.swc", ndmin=2)
    at = {int(n): i for i, n in enumerate(rows[:, 0])}
    links = [(i, at[int(p)]) for i, p in enumerate(rows[:, 6]) if p > 0]
    if (folder / "loops.csv").exists():
        links += [(at[int(r["id_a"])], at[int(r["id_b"])]) for r in common.rows(folder / "loops.csv")]
    a, b = np.array(links).T
    half = np.linalg.norm(rows[a, 2:5] - rows[b, 2:5], axis=1) / 2
    names = {int(r["id"]): r["label"] for r in common.rows(folder / "labels.csv")}
    label = np.array([AT[names[int(n)]] for n in rows[:, 0]])
    return known, rows[:, 2:5], label, np.bincount(a, half, len(rows)) + np.bincount(b, half, len(rows))


def answer(path):
    """Points of names.csv with the label and the probability of each, made dense along every edge."""
    edges = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            edges.setdefault(row["edge"], []).append((float(row["along_mm"]), float(row["x_mm"]), float(row["y_mm"]), float(row["z_mm"]), AT.get(row["label"], TRUE), float(row["probability"])))
    points, label, p = [], [], []
    for rows in edges.values():
        rows = np.array(sorted(rows))
        t, near = rows[:, 0], np.arange(len(rows), dtype=float)
        at = np.unique(np.r_[t, np.arange(t[0], t[-1], DENSE)])
        row = np.rint(np.interp(at, t, near)).astype(int) if len(rows) > 1 else np.zeros(len(at), int)
        points.append(np.stack([np.interp(at, t, rows[:, k]) for k in (1, 2, 3)], 1))
        label.append(rows[row, 4].astype(int))
        p.append(rows[row, 5])
    return np.concatenate(points), np.concatenate(label), np.concatenate(p)


def bins(p, right, weight, n):
    """Per bin of probability: weight, sum of probability, what was right; (3, n)."""
    at = np.minimum((np.asarray(p) * n).astype(int), n - 1)
    return np.array([np.bincount(at, weight * x, n) for x in (np.ones(len(at)), p, np.asarray(right, float))])


def expected_error(sums):
    """Expected calibration error of bins summed: (..., 3, n)."""
    return np.abs(sums[..., 1, :] - sums[..., 2, :]).sum(-1) / sums[..., 0, :].sum(-1)


def kind_of(label):
    return "/".join(cases.bare(name) for name in label.split("/"))


def nearest(label, point, found):
    """mm from a true landmark to the row of landmarks.csv that answers for it (the most probable of several); infinite if there is none."""
    side = label.split("/")[-1].partition("-")[0]
    wanted = {name if name in ("BA", "AComm") else f"{side}-{name}" for name in KINDS[kind_of(label)]}
    rows = [r for r in found if wanted <= set(r["label"].split("/")) and "/" in r["label"]]
    if not rows:
        return np.inf
    best = max(rows, key=lambda r: (set(r["label"].split("/")) == set(label.split("/")), float(r["probability"])))
    return float(np.linalg.norm([float(best[f"{axis}_mm"]) - x for axis, x in zip("xyz", point)]))


def judge(job):
    """Every figure of one case, as sums from which all tables are made; None where there is no answer."""
    folder, answers = job
    path = answers / f"{folder.name}.names.csv"
    if not path.exists():
        return None
    known, X, y, w = truth(folder)
    points, label, p = answer(path)
    _, row = cKDTree(points).query(X)
    z, p, true = label[row], p[row], y != TRUE
    mm = np.zeros((len(LABELS), len(LABELS)))
    np.add.at(mm, (y, z), w)
    total = w[true].sum()
    out = {
        "case": folder.name, "subject": known["subject"], "level": known["level"], "mm": mm, "bins": bins(p, z == y, w, BINS),
        "all labels": w[true] @ (z == y)[true] / total, "M1 and M2 as one": w[true] @ (AS_ONE[z] == AS_ONE[y])[true] / total,
        "side": w[true] @ (np.array([LABELS[k][:2] in ("L-", "R-") and LABELS[j][:2] in ("L-", "R-") and LABELS[k][0] != LABELS[j][0] for k, j in zip(z[true], y[true])])) / total,
    }
    where, segments = (answers / f"{folder.name}.{what}.csv" for what in ("landmarks", "segments"))
    found = common.rows(where) if where.exists() else []
    out["marks"] = [(kind_of(label), nearest(label, point, found)) for label, point in known["landmarks"].items()]
    said = {r["segment"]: r for r in common.rows(segments)} if segments.exists() else {}
    out["segments"] = [(s["segment"], bool(s["present"]), float(said[s["segment"]]["probability"])) for s in known["phenotype"] if s["segment"] in said]
    return out


def replicas(subjects):
    """How often each subject is drawn, a row a replica; the first row is the sample itself."""
    draws = np.random.default_rng(0).multinomial(len(subjects), np.full(len(subjects), 1 / len(subjects)), REPLICAS)
    return np.vstack([np.ones(len(subjects), int), draws])


def estimate(rows, part, statistic):
    """(figure, low, high) of a statistic of sums over cases, 95 % by drawing subjects; `part` makes an array of a case, or None."""
    used = [(row["subject"], np.asarray(value, float)) for row in rows if (value := part(row)) is not None]
    subjects = sorted({subject for subject, _ in used})
    if not subjects:
        return np.nan, np.nan, np.nan
    sums = np.array([sum(value for subject, value in used if subject == s) for s in subjects])
    with np.errstate(invalid="ignore", divide="ignore"):
        values = statistic(np.tensordot(replicas(subjects), sums, 1))
    return (float(values[0]), *(float(x) for x in np.nanquantile(values[1:], [0.025, 0.975])))


share = lambda s: s[..., 0] / s[..., 1]


def shown(figure):
    """`.950 (.93-.97)`."""
    if np.isnan(figure[0]):
        return "-"
    short = lambda x: f"{x:.3f}".replace("0.", ".", 1) if x < 1 else f"{x:.3f}"
    return f"{short(figure[0])} ({short(figure[1])}-{short(figure[2])})"


def labels_table(rows):
    """Share of the length with the right name, and calibration of the points, by level."""
    lines = []
    for level in LEVELS:
        own = [r for r in rows if r["level"] == level]
        if own:
            of = lambda key: shown(estimate(own, lambda r: (r[key], 1), share))
            pooled = shown(estimate(own, lambda r: (np.trace(r["mm"]), r["mm"].sum()), share))
            worst = min(own, key=lambda r: r["all labels"])
            lines.append([level, len(own), of("all labels"), of("M1 and M2 as one"), pooled, of("side"), shown(estimate(own, lambda r: r["bins"], expected_error)), f"{worst['case']} {worst['all labels']:.2f}"])
    return common.table(["level", "cases", "all labels", "M1 and M2 as one", "all length, false pieces counted", "length on the wrong side", "ECE of points", "worst case"], lines)


def marks_table(rows):
    """Share of landmarks within 3 and 5 mm of the place in the undamaged tracing, by kind and level."""
    lines = []
    for level in LEVELS:
        own = [r for r in rows if r["level"] == level]
        if not own:
            continue
        within = lambda limit, kind=None: lambda r: (sum(d < limit for k, d in r["marks"] if kind in (None, k)), sum(kind in (None, k) for k, _ in r["marks"]))
        cells = []
        for kind in KINDS:
            n = sum(k == kind for r in own for k, _ in r["marks"])
            cells.append("/".join(f"{estimate(own, within(limit, kind), share)[0]:.2f}" for limit in (3, 5)) if n else "-")
        lines.append([f"{level} ({sum(len(r['marks']) for r in own)})", *cells, *(shown(estimate(own, within(limit), share)) for limit in (3, 5))])
    return common.table(["level (landmarks)", *KINDS, "all within 3 mm", "all within 5 mm"], lines)


def presence_table(rows):
    """The seven segments: right, whole case right, calibration, Brier score, by level."""
    lines = []
    for level in (*LEVELS, "all"):
        own = [r for r in rows if level in (r["level"], "all") and r["segments"]]
        if not own:
            continue
        right = lambda r: [(p > 0.5) == there for _, there, p in r["segments"]]
        there = lambda r, what: [(p > 0.5) == what for _, is_there, p in r["segments"] if is_there == what]
        figures = [
            estimate(own, lambda r: (sum(right(r)), len(r["segments"])), share), estimate(own, lambda r: (all(right(r)), 1), share),
            estimate(own, lambda r: (sum(there(r, True)), len(there(r, True))), share), estimate(own, lambda r: (sum(there(r, False)), len(there(r, False))), share),
            estimate(own, lambda r: bins([p for *_, p in r["segments"]], [t for _, t, _ in r["segments"]], np.ones(len(r["segments"])), 10), expected_error),
            estimate(own, lambda r: (sum((p - t) ** 2 for _, t, p in r["segments"]), len(r["segments"])), share),
        ]
        sure = sum(p > 0.999 and not t or p < 0.001 and t for r in own for _, t, p in r["segments"])
        lines.append([level, sum(len(r["segments"]) for r in own), *map(shown, figures), sure])
    return common.table(["level", "segments", "right", "all of a case right", "present found", "absent stays absent", "ECE", "Brier", "wrong with P > .999 or < .001"], lines)


def per_label(rows, level, most=12):
    """Recall and precision of each artery, left and right together, and the largest confusions in mm."""
    own = [r for r in rows if r["level"] == level]
    if not own:
        return ""
    mm = sum(r["mm"] for r in own)
    cells = []
    for name in dict.fromkeys(map(cases.bare, LABELS)):
        k = [i for i, label in enumerate(LABELS) if cases.bare(label) == name]
        if mm[k].sum():
            cells.append(f"{name} {mm[k, k].sum() / mm[k].sum():.2f}/{mm[k, k].sum() / max(mm[:, k].sum(), 1e-9):.2f}")
    wrong = sorted(((mm[i, j], f"{LABELS[i]} taken for {LABELS[j]}") for i in range(len(LABELS)) for j in range(len(LABELS)) if i != j and mm[i, j] > 0), reverse=True)
    return f"{level}, recall/precision of length: {', '.join(cells)}. Largest confusions (mm): {', '.join(f'{what} {x:.0f}' for x, what in wrong[:most])}."


def wrong_segments(rows, level):
    """Which segments are wrong at a level."""
    count = {}
    for r in (r for r in rows if r["level"] == level):
        for s, there, p in r["segments"]:
            if (p > 0.5) != there:
                what = cases.bare(s) + (" taken for missing" if there else " taken for there")
                count[what] = count.get(what, 0) + 1
    return f"{level}, segments wrong: " + (", ".join(f"{what} {n}" for what, n in sorted(count.items(), key=lambda x: -x[1])) or "none") + "."


def judged(folder, answers, levels=LEVELS):
    """What judge says of every case of the folder that has an answer, in two processes."""
    jobs = [(case, answers) for case in sorted(folder.iterdir()) if (case / "truth.json").exists() and case.name.split("-")[1] in levels]
    with Pool(2) as pool:
        rows = pool.map(judge, jobs, chunksize=4)
    absent = [case.name for (case, _), row in zip(jobs, rows) if row is None]
    if absent:
        print(f"no answer: {len(absent)} of {len(jobs)} cases ({', '.join(absent[:5])} ...)", file=sys.stderr)
    return [row for row in rows if row]


def report(rows, worst=0):
    """All tables as Markdown."""
    parts = [labels_table(rows), "Landmarks, share within 3 mm / 5 mm:\n\n" + marks_table(rows), "Presence of the seven segments:\n\n" + presence_table(rows)]
    parts += [text for level in LEVELS if (text := per_label(rows, level))] + [wrong_segments(rows, level) for level in LEVELS if any(r["level"] == level for r in rows)]
    if worst:
        parts.append("Worst cases: " + ", ".join(f"{r['case']} {r['all labels']:.2f}" for r in sorted(rows, key=lambda r: r["all labels"])[:worst]) + ".")
    return "\n\n".join(parts)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", type=Path)
    parser.add_argument("answers", type=Path)
    parser.add_argument("--levels", default=",".join(LEVELS))
    parser.add_argument("--worst", type=int, default=0, help="also name the N worst cases")
    options = parser.parse_args()
    rows = judged(options.cases, options.answers, options.levels.split(","))
    if not rows:
        raise SystemExit(f"{options.answers}: no CASE.names.csv of {options.cases}")
    print(report(rows, options.worst))


if __name__ == "__main__":
    main()
