"""The published circle and its ten variants, broken with many seeds: is the exact variant found again?"""
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
    try:
        alone = ask.alone(source, work / f"{name}.alone")
    except SystemExit:  # no arteries that could be named
        alone = ask.REFUSED
    return lacks, seed, truth, found, median, nearest, alone


def run(work, options):
    seeds = [seed for first, last in options.seeds for seed in range(first, last)]
    rows = common.everywhere(case, [(work, lacks, seed) for lacks in VARIANTS for seed in seeds])
    right = lambda answer, truth: ask.missing(answer.get("segments", answer)) == truth
    # Of a row: with landmarks, with nothing but the file, the nearest end, the median of L.
    columns = (3, 6, 5, 4)
    count = lambda some: [sum(right(row[k], row[2]) for row in some) for k in columns]
    lines = []
    for lacks in VARIANTS:
        own = [row for row in rows if row[0] == lacks]
        sure = [sum(row[k]["probabilities"]["variant"] for row in own) / len(own) for k in (3, 6)]
        lines.append([f"without {lacks}" if lacks else "complete", *(f"{n} of {len(own)}" for n in count(own)), *(f"{p:.2f}" for p in sure)])
    for first, last in options.seeds:
        own = [row for row in rows if first <= row[1] < last]
        lines.append([f"seeds {first} to {last - 1}", *(f"{n} of {len(own)} ({100 * n / len(own):.1f} %)" for n in count(own)), "", ""])
    lines.append(["**all**", *(f"**{n} of {len(rows)} ({100 * n / len(rows):.1f} %)**" for n in count(rows)), "", ""])
    text = common.table(["circle", "willis, landmarks", "willis, nothing but the file", "nearest end", "median of L", "mean probability of the answer, landmarks", "nothing but the file"], lines)
    pairs = {
        name: [({s: s not in row[2] for s in ask.RING}, ask.with_third(row[k]) if k in (3, 6) else row[k]) for row in rows]
        for name, k in zip(("willis, landmarks", "willis, nothing but the file", "nearest end", "median of L"), columns)
    }
    text += "\n\n" + topcow.field_table(common, pairs)
    for name in list(pairs)[:2]:
        text += f"\n\nEach segment by {name}:\n\n" + topcow.segment_table(common, pairs[name])
    for k, how in ((3, "with landmarks"), (6, "with nothing but the file")):
        answered = [row for row in rows if row[k] is not ask.REFUSED]
        text += f"\n\n### Answers {how}\n\nCases that `classify` refused, which count as wrong: {len(rows) - len(answered)}.\n\n"
        if not answered:
            continue
        text += failures(answered, k)
        error, table = tables.reliability([(row[k]["probabilities"]["variant"], right(row[k], row[2])) for row in answered])
        segments, _ = tables.reliability([(row[k]["probabilities"]["segments"][s], s not in row[2]) for row in answered for s in ask.RING])
        text += f"Expected calibration error of the answer's probability {error:.3f}, of the segments' {segments:.3f}:\n\n{table}"
    return text


def failures(rows, k):
    """What went wrong, by kind and one by one."""
    lines = []
    for row in rows:
        found, truth = row[k], row[2]
        got = ask.missing(found["segments"])
        if got != truth:
            kinds = ["a segment is taken for missing" for s in got if s not in truth] + ["a missing segment is taken for there" for s in truth if s not in got]
            lines.append([row[0] or "complete", row[1], " and ".join(dict.fromkeys(kinds)), found["variant"], f"{found['probabilities']['variant']:.2f}"])
    kinds = Counter(line[2] for line in lines)
    text = "What went wrong, by kind: " + ("; ".join(f"{kind}: {n}" for kind, n in kinds.most_common()) or "nothing") + ".\n\n"
    return text + (common.table(["circle", "seed", "how", "answer", "its probability"], lines) + "\n\n" if lines else "")
