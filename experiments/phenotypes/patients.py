"""Labelled tracings of patients, whole and damaged: is the presence of each segment found?"""
import json
import os
import subprocess
import sys
from pathlib import Path

import ask
import common
import joining
import tables
import topcow
from networks import ROOT, SHARED

GAPBENCH = Path(os.environ.get("WILLIS_GAPBENCH", ROOT / "../shared/gapbench")).resolve()
LEVELS = ("easy", "medium", "hard")
# iCafe's names in gapbench -> the artery whose in- or outlet their free end is; of several the first is taken.
OUTLETS = {"M1": ("M1", "M2", "M3"), "A2": ("A2",), "P2": ("P2",), "ICA": ("ICA",), "VA": ("VA",)}
# Further than this from every free end of the extraction (mm), an end was not seen.
SEEN = 8.0


def name_of(segment):
    """`A1 L` -> `L-A1`."""
    words = segment.split()
    return words[0] if len(words) == 1 else f"{words[1]}-{words[0]}"


def landmarks(tree, fragments, path):
    """Writes the in- and outlets of the whole tracing that its extraction shows."""
    import numpy as np
    rows = [line.split() for line in fragments.read_text().splitlines() if line.strip() and not line.startswith("#")]
    at = {row[0]: i for i, row in enumerate(rows)}
    degree = np.zeros(len(rows), int)
    for i, row in enumerate(rows):
        if row[6] in at:
            degree[i] += 1
            degree[at[row[6]]] += 1
    free = np.array([[float(x) for x in rows[i][2:5]] for i in np.flatnonzero(degree <= 1)])
    ends = {}
    for node, branches in tree.inc.items():
        if len(branches) == 1:
            branch = tree.branches[branches[0]]
            ends.setdefault(branch["label"], []).append(branch["p"][0] if branch["u"] == node else branch["p"][-1])
    lines = []
    wanted = [(f"{side}-{artery}", [f"{label} {side}" for label in labels]) for artery, labels in OUTLETS.items() for side in "LR"]
    wanted.append(("BA", ["BA"] if not any(f"VA {side}" in ends for side in "LR") else []))
    for label, sources in wanted:
        points = [p for source in sources for p in ends.get(source, [])]
        seen = [p for p in points if np.linalg.norm(free - p, axis=1).min() <= SEEN]
        if seen:
            lines.append(f"{label},{','.join(repr(float(x)) for x in seen[0])}\n")
    # Where an outlet is beyond the field of view or was lost, a person marks where the segment is seen to end.
    have = {line.split(",")[0] for line in lines}
    for side in "LR":
        other = "LR".replace(side, "")
        marks = [
            (f"{side}-A1/{side}-A2", {f"{side}-A2"}, (("A1", "A2"), ("AComm", "A2"), ("AComm", "A1")), ("A1", "A2", "AComm"), f"A1 {other}"),
            (f"{side}-P1/{side}-P2", {f"{side}-P2"}, (("P1", "P2"), ("PComm", "P2"), ("PComm", "P1")), ("P1", "P2", "PComm"), f"ICA {side}"),
            (f"{side}-ICA/{side}-A1", {f"{side}-ICA", f"{side}-M1"}, (("ICA", "A1"), ("M1", "A1")), ("A1",), f"A2 {side}"),
        ]
        for label, instead, pairs, alone, away in marks:
            if not have & instead:
                point = meeting(tree, side, pairs, alone, away)
                if point is not None and np.linalg.norm(free - point, axis=1).min() <= SEEN:
                    lines.append(f"{label},{','.join(repr(float(x)) for x in point)}\n")
    path.write_text("label,x_mm,y_mm,z_mm\n" + "".join(lines))
    return [line.split(",")[0] for line in lines]


def meeting(tree, side, pairs, alone, away):
    """Where two arteries meet, the first pair that does; else a free end of one of them that `away` does not touch."""
    name = lambda artery: artery if artery == "AComm" else f"{artery} {side}"
    nodes = {}
    for b in tree.branches:
        nodes.setdefault(b["label"], []).extend((b["u"], b["v"]))
    shared = [n for a, b in pairs for n in nodes.get(name(a), []) if n in nodes.get(name(b), [])]
    ends = [n for artery in alone for n in nodes.get(name(artery), []) if len(tree.inc[n]) == 1 and n not in nodes.get(away, [])]
    for node in shared + ends:
        b = tree.branches[tree.inc[node][0]]
        return b["p"][0] if b["u"] == node else b["p"][-1]
    return None


def case(job):
    folder, tree, work, prior = job
    level, name = folder.parent.name, folder.name
    out = work / f"{level}-{name}"
    truth = json.loads((folder / "truth.json").read_text())
    scored = {name_of(s["segment"]): bool(s["present"]) for s in truth["phenotype"]}
    marks = out.with_suffix(".landmarks.csv")
    seen = landmarks(tree, folder / "fragments.swc", marks)
    if not scored or not {"L-ICA", "R-ICA", "BA", "L-VA", "R-VA"} & set(seen):
        return None
    loops = ["--loops", folder / "loops.csv"] if (folder / "loops.csv").exists() else []
    found, median = ask.answer(folder / "fragments.swc", marks, out, loops or ["--seed", "0"], prior)
    links = out.with_suffix(".links.csv")
    joining.joined(folder / "fragments.swc", links, 15.0)
    if loops:
        links.write_text(links.read_text() + "".join(line + "\n" for line in loops[1].read_text().splitlines()[1:]))
    nearest = ask.fixed(folder / "fragments.swc", marks, out.with_suffix(".nearest"), ["--loops", links])
    return level, name, scored, found, median, nearest


def whole(folders):
    """Per patient whether each labelled segment is present, by the table and by the command."""
    agree = wrong = 0
    odd = []
    for folder in folders:
        out = folder["work"] / "whole"
        common.willis("classify", folder["tracing"], "-o", out)
        segments = json.loads((out / "phenotype.json").read_text())["segments"]
        for name in ask.RING:
            if segments[name] == (name in folder["labels"]):
                agree += 1
            else:
                wrong += 1
                odd.append(f"{folder['tracing'].parent.name} {name}")
    return agree, wrong, odd


def run(work, options):
    data = SHARED / "insist-cow"
    if not (data.exists() and (GAPBENCH / "make_cases.py").exists()):
        print(f"skipped: there is no {data} or no {GAPBENCH}")
        return None
    sys.path.insert(0, str(GAPBENCH))
    import make_cases
    codes = ["", "L-ICA", "R-ICA", "L-M1", "R-M1", "L-M2", "R-M2", "L-A1", "R-A1", "L-A2", "R-A2", "AComm", "L-M3", "R-M3", "L-VA", "R-VA", "BA", "L-P1", "R-P1", "L-P2", "R-P2", "L-PComm", "R-PComm"]
    folders = []
    for tracing in sorted(data.glob("*/tracing*.swc")):
        labels = {codes[int(float(row["VesselType"]))] for row in common.rows(tracing.with_name("Feature_Vessel.csv"))}
        folders.append({"tracing": tracing, "labels": labels, "work": work})
    agree, wrong, odd = whole(folders)
    cases = work / "cases"
    if not cases.exists():
        command = [sys.executable, GAPBENCH / "make_cases.py", data, cases, "--seed", options.seed, "--phenotype", "--variants", 1]
        subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
    trees = make_cases.load_all(data)
    jobs = []
    for level in LEVELS:
        for folder in sorted((cases / level).iterdir()):
            subject = json.loads((folder / "truth.json").read_text())["subject"]
            jobs.append((folder, trees[subject], work, ask.folds(subject)))
    rows = [row for row in common.everywhere(case, jobs) if row]
    right = lambda segments, scored: all(segments[name] == there for name, there in scored.items())
    lines, pairs, parts = [], [], []
    for level in LEVELS:
        own = [row for row in rows if row[0] == level]
        exact = [sum(right(row[k]["segments"] if k == 3 else row[k], row[2]) for row in own) / len(own) for k in (3, 5, 4)]
        absent = [not row[3]["segments"][name] for row in own for name, there in row[2].items() if not there]
        lines.append([level, len(own), *(f"{x:.3f}" for x in exact), f"{sum(absent) / len(absent):.3f}"])
    for row in rows:
        pairs.append((row[3]["probabilities"]["variant"], right(row[3]["segments"], row[2])))
        parts += [(row[3]["probabilities"]["segments"][name], there) for name, there in row[2].items()]
    (error, table), (of_segments, segments) = tables.reliability(pairs), tables.reliability(parts)
    text = f"Whole tracings: {agree} of {agree + wrong} segments as the table of vessels has them{': not ' + ', '.join(odd) if odd else ''}.\n\n"
    text += common.table(["damage", "cases", "willis, exact", "nearest end", "median of L", "absent stays absent"], lines)
    field = {}
    for level in LEVELS:
        for name, k in (("willis", 3), ("nearest end", 5), ("median of L", 4)):
            own = [row for row in rows if row[0] == level]
            field[f"{level}: {name}"] = [(row[2], ask.with_third(row[3]) if k == 3 else row[k]) for row in own]
    by_willis = [pair for level in LEVELS for pair in field[f"{level}: willis"]]
    text += "\n\n" + topcow.field_table(common, field)
    text += "\n\nEach segment by willis, all levels of damage:\n\n" + topcow.segment_table(common, by_willis)
    return text + f"\n\nExpected calibration error of the segments' probability {of_segments:.3f}:\n\n{segments}\n\nand of the variant's {error:.3f}:\n\n{table}"
