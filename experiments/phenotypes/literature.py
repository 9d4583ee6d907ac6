"""The published circle and its ten variants, broken with many seeds: is the exact variant found again?"""
import json
from collections import Counter

import ask
import common
import joining
import tables
import topcow

# What each variant lacks (data/README.md).
VARIANTS = ("", "AComm", "L-A1", "R-A1", "L-P1", "R-P1", "L-PComm", "R-PComm", "L-PComm,R-PComm", "L-PComm,R-P1", "R-PComm,L-P1")


def case(job):
    work, lacks, seed = job
    name = f"{(lacks or 'complete').replace(',', '_')}-{seed}"
    source = work / f"{name}.swc"
    without = ["--without", lacks] if lacks else []
    common.willis("phantom", "cerebral", *without, "--break", "--seed", seed, "-o", source)
    landmarks = work / f"{name}.landmarks.csv"
    found, median = ask.answer(source, landmarks, work / name)
    loops = work / f"{name}.loops.csv"
    links = work / f"{name}.links.csv"
    own = loops.read_text().splitlines()[1:] if loops.exists() else []
    joining.joined(source, links, 15.0)
    links.write_text(links.read_text() + "".join(line + "\n" for line in own))
    nearest = ask.fixed(source, landmarks, work / f"{name}.nearest", ["--loops", links])
    truth = tuple(segment for segment in ask.RING if segment in lacks.split(","))
    lost = len(json.loads(source.with_suffix(".truth.json").read_text())["lost_vessels"])
    return lacks, seed, truth, found, median, nearest, lost


def run(work, options):
    jobs = [(work, lacks, seed) for lacks in VARIANTS for seed in range(*options.seeds)]
    rows = common.everywhere(case, jobs)
    lines, failures = [], []
    right = lambda segments, truth: ask.missing(segments) == truth
    totals = [0, 0, 0]
    for lacks in VARIANTS:
        own = [row for row in rows if row[0] == lacks]
        counts = [sum(right(row[k]["segments"] if k == 3 else row[k], row[2]) for row in own) for k in (3, 5, 4)]
        totals = [a + b for a, b in zip(totals, counts)]
        sure = sum(row[3]["probabilities"]["variant"] for row in own) / len(own)
        lines.append([f"without {lacks}" if lacks else "complete", *(f"{n} of {len(own)}" for n in counts), f"{sure:.2f}"])
    lines.append(["**all**", *(f"**{n} of {len(rows)} ({100 * n / len(rows):.1f} %)**" for n in totals), ""])
    for lacks, seed, truth, found, _, _, lost in rows:
        got = ask.missing(found["segments"])
        if got != truth:
            kinds = ["a segment is taken for missing" for s in got if s not in truth] + ["a missing segment is taken for there" for s in truth if s not in got]
            p = dict((tuple(v["variant"].removeprefix("without ").split(", ")), v["probability"]) for v in found["probabilities"]["variants"])
            failures.append((lacks or "complete", seed, " and ".join(dict.fromkeys(kinds)), found["variant"], found["probabilities"]["variant"], lost, p))
    error, table = tables.reliability([(row[3]["probabilities"]["variant"], right(row[3]["segments"], row[2])) for row in rows])
    segments, _ = tables.reliability([(row[3]["probabilities"]["segments"][s], s not in row[2]) for row in rows for s in ask.RING])
    kinds = Counter(f[2] for f in failures)
    text = common.table(["circle", "willis", "nearest end", "median of L", "mean probability of the answer"], lines)
    pairs = {
        name: [({s: s not in row[2] for s in ask.RING}, ask.with_third(row[3]) if k == 3 else row[k]) for row in rows]
        for name, k in (("willis", 3), ("nearest end", 5), ("median of L", 4))
    }
    text += "\n\n" + topcow.field_table(common, pairs) + "\n\nEach segment by willis:\n\n" + topcow.segment_table(common, pairs["willis"])
    text += "\n\nWhat went wrong, by kind: " + ("; ".join(f"{kind}: {n}" for kind, n in kinds.most_common()) or "nothing") + ".\n\n"
    if failures:
        text += common.table(["circle", "seed", "how", "answer", "its probability"], [[f[0], f[1], f[2], f[3], f"{f[4]:.2f}"] for f in failures]) + "\n\n"
    return text + f"Expected calibration error of the answer's probability {error:.3f}, of the segments' {segments:.3f}:\n\n{table}"
