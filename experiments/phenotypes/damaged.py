"""gapbench's phenotype task, with nothing but the file: which of the seven segments are there, beside the rules of other programs."""
import importlib
import json
import subprocess
import sys
from pathlib import Path

import ask
import common
import numpy as np
import patients
import tables
import topcow
from networks import SHARED

VARIANTS = 4
LEVELS = patients.LEVELS
RULES = {"MST": "minimum spanning tree", "tubetk": "TubeTK's rule"}
DATA = "circles"


def bridging():
    """The modules of experiments/gap-bridging that hold the rules and the bootstrap."""
    sys.path.append(str(Path(__file__).resolve().parent.parent / "gap-bridging"))
    return (importlib.import_module(name) for name in ("bench", "rules", "judge", "score"))


def own(job):
    """phenotype.json (None where classify refuses) and the kept topology of one case; kept in the work folder."""
    case, work = job
    out = work / "answers" / f"{case.level}-{case.name}"
    kept, found = out.with_name(f"{out.name}.edges.csv"), out.with_name(f"{out.name}.phenotype.json")
    if not found.exists():
        out.parent.mkdir(exist_ok=True)
        try:
            answer = ask.alone(case.folder / "fragments.swc", out, ask.folds(case.subject), ["edges.csv"])
        except SystemExit as end:
            print(end, file=sys.stderr)
            answer = None
        found.write_text(json.dumps(answer))
    return json.loads(found.read_text()), [row for row in common.rows(kept) if row["origin"] == "candidate"]


def by_rule(job):
    """Of one case, what score.py says of the rules of others and of what willis kept."""
    _, rules, _, score = MODULES
    case, limits, kept = job
    truth = json.loads((case.folder / "truth.json").read_text())
    answers = {name: rows for name, rows in rules.answers(case, limits).items() if name in RULES}
    return {name: score.score(truth, rows) for name, rows in (answers | {"kept": kept}).items()}


MODULES = ()


def made(work, seed):
    """The cases of a seed, made unless they are there."""
    folder = work / "cases"
    if not folder.exists():
        command = [sys.executable, patients.GAPBENCH / "make_cases.py", SHARED / "insist-cow", folder, "--seed", seed, "--phenotype", "--variants", VARIANTS]
        subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
    return folder


def run(work, options):
    global MODULES
    if not ((SHARED / "insist-cow").exists() and (patients.GAPBENCH / "make_cases.py").exists()):
        print(f"skipped: there is no {SHARED / 'insist-cow'} or no {patients.GAPBENCH}")
        return None
    MODULES = bench, rules, judge, _ = tuple(bridging())
    folder = made(work, options.seed)
    cases = [bench.Case(DATA, level, case.name, case) for level in LEVELS for case in sorted((folder / level).iterdir())]
    # What has a limit gets it from the subjects of the other folds.
    bench.FOLD_OF.update({subject: k % bench.FOLDS for k, subject in enumerate(sorted({case.subject for case in cases}))})
    answers = common.everywhere(own, [(case, work) for case in cases])
    limits = rules.limits(cases)
    judged = bench.each(by_rule, [(case, limits, kept) for case, (_, kept) in zip(cases, answers)])
    scored = [{patients.name_of(s["segment"]): bool(s["present"]) for s in json.loads((case.folder / "truth.json").read_text())["phenotype"]} for case in cases]
    return tables_of(cases, scored, [found or ask.REFUSED for found, _ in answers], judged, judge, unfed(cases, options.seed))


def unfed(cases, seed):
    """Of each case, whether what was removed leaves an A2 or a P2 that nothing feeds."""
    sys.path.append(str(Path(__file__).resolve().parent.parent / "labels"))
    labels = importlib.import_module("cases")
    trees, make_cases = labels.trees()
    traced = {subject: {name for branch in tree.branches for name in branch["arteries"]} for subject, tree in trees.items()}
    out = []
    for case in cases:
        subject, _, variant = case.name.rpartition("_")
        *_, removed = labels.damaged(make_cases, trees, subject, case.level, int(variant), seed)
        has = lambda *names: all(name in traced[subject] and name not in removed for name in names)
        lost = [
            f"{s}-{end}"
            for s, o in ("LR", "RL")
            for end, ways in (("A2", ((f"{s}-A1",), ("AComm", f"{o}-A1"))), ("P2", ((f"{s}-P1",), (f"{s}-PComm",))))
            if f"{s}-{end}" in traced[subject] and not any(has(*way) for way in ways)
        ]
        out.append(bool(lost))
    return out


def interval(figure):
    """`0.950 (0.93-0.97)`."""
    return "-" if figure is None else f"{figure[0]:.3f} ({figure[1]:.2f}-{figure[2]:.2f})"


def tables_of(cases, scored, found, judged, judge, impossible):
    """All tables of the part as Markdown."""
    exact = [float(all(f["segments"][s] == there for s, there in own.items())) if own else None for f, own in zip(found, scored)]
    still = [np.mean([f["segments"][s] is False for s in absent]) if (absent := [s for s, there in own.items() if not there]) else None for f, own in zip(found, scored)]
    lines, less = [], []
    for level in LEVELS:
        at = [k for k, case in enumerate(cases) if case.level == level]
        mean = lambda values: judge.mean([cases[k] for k in at], [values[k] for k in at])
        of = lambda name, figure: [r[name][figure] for r in judged]
        rules = [interval(mean(of(name, "phenotype_exact"))) for name in RULES]
        lines.append([level, len(at), interval(mean(exact)), interval(mean(of("kept", "phenotype_exact"))), *rules, interval(mean(still)), interval(mean(of("kept", "absent_kept_absent"))), *(interval(mean(of(name, "absent_kept_absent"))) for name in RULES)])
        less.append([level, *(interval(mean([a - r[name]["phenotype_exact"] for a, r in zip(exact, judged)])) for name in RULES), *(interval(mean([r["kept"]["phenotype_exact"] - r[name]["phenotype_exact"] for r in judged])) for name in RULES)])
    text = "Share of cases in which all scored segments are right, and share of absent segments that stay absent, mean of the cases:\n\n"
    text += common.table(["damage", "cases", "`classify`, exact", "kept topology, exact", *(f"{name}, exact" for name in RULES.values()), "`classify`, absent stays absent", "kept topology", *RULES.values()], lines)
    text += "\n\nExact, less that of the rules:\n\n" + common.table(["damage", *(f"`classify` - {name}" for name in RULES.values()), *(f"kept topology - {name}" for name in RULES.values())], less)
    rows = []
    for level in LEVELS:
        cells = [level]
        for which in (True, False):
            own = [exact[k] for k, case in enumerate(cases) if case.level == level and impossible[k] is which and exact[k] is not None]
            cells.append(f"{np.mean(own):.3f} of {len(own)}")
        rows.append(cells)
    text += "\n\nWhat is removed is drawn without regard to anatomy. `classify`, exact, where an A2 or a P2 is left that nothing feeds, and elsewhere:\n\n"
    text += common.table(["damage", "an artery that nothing feeds", "none"], rows)
    field = {f"{level}: `classify`": [(own, ask.with_third(f)) for case, f, own in zip(cases, found, scored) if case.level == level and own] for level in LEVELS}
    text += "\n\n" + topcow.field_table(common, field)
    rows = []
    for kind in dict.fromkeys(s.rpartition("-")[2] for s in ask.RING):
        cells = [kind]
        for level in LEVELS:
            said = [(f["segments"][s], there) for case, f, own in zip(cases, found, scored) if case.level == level for s, there in own.items() if s.rpartition("-")[2] == kind]
            for what in (True, False):
                some = [a == b for a, b in said if b is what]
                cells.append(f"{np.mean(some):.3f} of {len(some)}" if some else "-")
        rows.append(cells)
    text += "\n\nEach segment, left and right together: sensitivity (present and found) and specificity (absent and not found):\n\n"
    text += common.table(["segment", *(f"{level}, {what}" for level in LEVELS for what in ("sensitivity", "specificity"))], rows)
    refused = [case for case, f in zip(cases, found) if not f["probabilities"]["segments"]]
    scored = [own if f["probabilities"]["segments"] else {} for f, own in zip(found, scored)]
    pairs = [(case, f["probabilities"]["segments"][s], there) for case, f, own in zip(cases, found, scored) for s, there in own.items()]
    sure = [f"{case.level} {case.name} {s} P {p:.5f}" for case, f, own in zip(cases, found, scored) for s, there in own.items() if (p := f["probabilities"]["segments"][s]) > 0.999 and not there or p < 0.001 and there]
    parts = [judge.bins(np.array([p for c, p, _ in pairs if c is case]), np.array([t for c, _, t in pairs if c is case], bool))[0] if any(c is case for c, *_ in pairs) else None for case in cases]
    error = judge.estimate(cases, parts, judge.expected_error)
    _, table = tables.reliability([(p, there) for _, p, there in pairs])
    text += f"\n\nCases that `classify` refused, which count as wrong above: {len(refused)}{' (' + ', '.join(f'{case.level} {case.name}' for case in refused) + ')' if refused else ''}."
    text += f"\n\nExpected calibration error of the segments' probability, all levels, {len(pairs)} segments: {interval(error)}. Wrong with a probability above .999 or below .001: {len(sure)}{' (' + ', '.join(sure) + ')' if sure else ''}.\n\n{table}"
    return text
