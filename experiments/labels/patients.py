"""Patients of INSIST, whole and damaged, each named by the model of the others: other draws, other frames, and segments deleted unseen."""
import json
import os
import shutil

import answer
import cases
import common
import numpy as np
import score

# Draws of a patient and level to train on.
TRAINED = 6


def models(work, options):
    """The folder of arteries.toml and its folds, trained unless it is there: one patient left out at a time."""
    folder = options.models or work / "models"
    if not (folder / "arteries.toml").exists():
        folder.mkdir(parents=True, exist_ok=True)
        source = work / "train"
        if not source.exists():
            cases.make(source, seed=1, variants=TRAINED, upright=True)
        common.willis("train", source.name, "--model", "labels", "-o", folder / "arteries.toml", "--folds", 26, "--save-folds", threads=2, folder=work)
    return folder


def named(work, options, name, levels=score.LEVELS, label=(), **draw):
    """What score.judge says of the answers to a draw of the cases; `label` holds further options of `willis label`."""
    folder, answers = work / "cases" / name, work / "answers" / "-".join([name, *map(str, label)]).replace("/", "_")
    if not folder.exists():
        cases.make(folder, levels=levels, **draw)
    answer.answer(folder, answers, models(work, options), levels, extra=label)
    return score.judged(folder, answers, levels)


def patients(work, options):
    """The draw of the study."""
    return score.report(named(work, options, "seed-1", seed=1))


def draws(work, options):
    """Another draw of damage and turns, that nothing was chosen on."""
    rows = named(work, options, f"seed-{options.seed}", seed=options.seed)
    return "\n\n".join([score.labels_table(rows), score.marks_table(rows), score.presence_table(rows)])


def frames(work, options):
    """Whole tracings as LPS and as RAS, turned by up to 30 degrees and not at all; nothing is said of the frame."""
    lines = []
    for frame in ("LPS", "RAS"):
        for upright in (True, False):
            name = "whole-" + frame + ("-upright" if upright else "")
            rows = named(work, options, name, ("whole",), frame=frame, upright=upright)
            lines.append([frame, "as the scanner lay" if upright else "U(0, 30) degrees", len(rows), score.shown(score.estimate(rows, lambda r: (r["all labels"], 1), score.share)), f"{min(r['all labels'] for r in rows):.2f}"])
    return common.table(["frame of the file", "turned", "cases", "length right", "worst case"], lines)


def classified(work, options, name, told, **draw):
    """What `willis classify` says of the segments of a draw of the cases, told a rate of segments out of sight: as score.judge has it."""
    folder, answers = work / "cases" / name, work / "answers" / f"{name}-classify-{told}"
    if not folder.exists():
        cases.make(folder, levels=("medium",), **draw)
    answers.mkdir(parents=True, exist_ok=True)
    of = answer.models(models(work, options))

    def one(case):
        known = json.loads((case / "truth.json").read_text())
        kept, out = answers / f"{case.name}.json", answers / case.name
        if not kept.exists():
            loops = ["--loops", case / "loops.csv"] if (case / "loops.csv").exists() else []
            common.willis("classify", case / "fragments.swc", "-o", out, *loops, "--arteries", of[known["subject"]], "--unseen", told)
            os.replace(out / "phenotype.json", kept)
            shutil.rmtree(out)
        said = json.loads(kept.read_text())["probabilities"]["segments"]
        return {"subject": known["subject"], "hidden": known["hidden"], "segments": [(s["segment"], bool(s["present"]), said[s["segment"]]) for s in known["phenotype"]]}

    return common.everywhere(one, sorted(case for case in folder.iterdir() if (case / "truth.json").exists()))


def unseen(work, options):
    """Present segments deleted entirely at a rate: are those that are not seen as often present as is said?"""
    lines = []
    for rate in (0.15, 0.30):
        for told in (0, rate / 2, rate, 2 * rate):
            rows = classified(work, options, f"deleted-{rate}", told, seed=1, deleted=rate)
            pairs = [(p, there) for r in rows for _, there, p in r["segments"]]
            error = score.estimate(rows, lambda r: score.bins([p for *_, p in r["segments"]], [t for _, t, _ in r["segments"]], np.ones(len(r["segments"])), 10), score.expected_error)
            brier = score.estimate(rows, lambda r: (sum((p - t) ** 2 for _, t, p in r["segments"]), len(r["segments"])), score.share)
            low = [(p, t) for p, t in pairs if p < 0.5]
            sure = sum(p > 0.999 and not t or p < 0.001 and t for p, t in pairs)
            # One who sees every segment that is not hidden, and takes those that it does not see for present at the rate that it was told.
            usual = sum(t for _, t in pairs) / len(pairs)
            if_not_seen = usual * told / (usual * told + 1 - usual)
            perfect = [(1.0 if t and s not in r["hidden"] else if_not_seen, t) for r in rows for s, t, _ in r["segments"]]
            least = score.expected_error(score.bins([p for p, _ in perfect], [t for _, t in perfect], np.ones(len(perfect)), 10))
            lines.append([f"{rate:.2f}", f"{told:.3g}", len(pairs), score.shown(error), f"{least:.3f}".lstrip("0"), score.shown(brier), f"{sum(t for _, t in low) / max(len(low), 1):.2f} of {len(low)}", f"{sum(p for p, _ in low) / max(len(low), 1):.2f}", sure])
    return common.table(["deleted", "`--unseen`", "segments", "ECE", "ECE of a perfect eye", "Brier", "present of those called absent", "their mean probability", "wrong with P > .999 or < .001"], lines)
