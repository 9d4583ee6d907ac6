"""Whether hydraulics decides where P is known: P stacked with what the samples measured, and the same with all radii made equal."""
import csv
import os
import shutil
import xml.etree.ElementTree as tree
from statistics import median

import bench
import command
import common
import judge
import numpy as np

NAMESPACE = "{http://graphml.graphdrawing.org/xmlns}"
KINDS = ("as measured", "all radii equal")
# Beside the log-odds of P: how often a bridge is in the forest, its resilience there (L over the samples in which it is), its wall shear
# against the tree's own.
SETS = {"frequency": [1], "resilience": [2], "wall shear": [3, 4], "all of them": [1, 2, 3, 4]}


def equal(path):
    """Gives all vessels, nodes and terminals of a candidate graph their median radius and resistance."""
    graph = tree.parse(path)
    named = {key.get("id"): key.get("attr.name") for key in graph.iter(NAMESPACE + "key")}
    of = lambda name: [data for data in graph.iter(NAMESPACE + "data") if named[data.get("key")] == name and data.text]
    radius = repr(median(float(data.text) for data in of("radius_mm")))
    for data in of("radius_mm"):
        data.text = radius
    for data in of("points"):
        data.text = ";".join(" ".join([*point.split()[:3], radius]) for point in data.text.split(";"))
    terminals = of("resistance_mmHg_s_per_mL")
    for data in terminals:
        data.text = repr(median(float(d.text) for d in terminals))
    graph.write(path)


def edges(case, seed, weights, work, kind):
    """All rows of edges.csv of one case, by way of its candidate graph."""
    kept = case.within(work / "hydraulics" / kind.replace(" ", "-") / str(seed)) / "edges.csv"
    if not kept.exists():
        kept.parent.mkdir(parents=True, exist_ok=True)
        graph, scratch = kept.with_suffix(".graphml"), kept.with_suffix(".scratch")
        loops = ["--loops", case.folder / "loops.csv"] if (case.folder / "loops.csv").exists() else []
        common.willis("candidates", case.folder / "fragments.swc", "-o", graph, "--bc", case.folder / "conditions.csv", *loops, "--prior", weights)
        if kind == KINDS[1]:
            equal(graph)
        common.willis("infer", graph, "-o", scratch, "--dpi", 72)
        os.replace(scratch / "edges.csv", kept)
        shutil.rmtree(scratch)
        graph.unlink()
    with open(kept, newline="") as file:
        return list(csv.DictReader(file))


def measured(job):
    """(features, right or not, the rows) of the candidates of a case."""
    case, seed, weights, work, kind = job
    rows = edges(case, seed, weights, work, kind)
    column = lambda name: np.array([float(row[name] or "nan") for row in rows])
    often, radius, n = column("frequency"), column("radius_mm"), 1000
    flows = column("likelihood") > 0
    rho = np.log(np.where(flows, column("likelihood") / np.maximum(often * n, 1), 1))
    # tau = sqrt(2 mu rho): ln tau is half of ln rho, but for a constant. The tree's own: a line over ln r of its observed vessels.
    own = flows & np.array([row["origin"] == "observed" for row in rows])
    line, spread = np.zeros(2), 1.0
    if own.sum() > 3:
        design = np.column_stack([np.ones(len(rows)), np.log(radius)])
        line = np.linalg.lstsq(design[own], 0.5 * rho[own], rcond=None)[0]
        spread = max((0.5 * rho[own] - design[own] @ line).std(), 0.1)
    shear = np.where(flows, np.clip((0.5 * rho - line[0] - line[1] * np.log(radius)) / spread, -4, 4), 0)
    odds = lambda p: np.log(np.clip(p, 1e-4, 1 - 1e-4) / np.clip(1 - p, 1e-4, 1))
    x = np.column_stack([odds(column("probability")), odds(often), np.where(flows, rho - rho[own].mean() if own.any() else 0, 0), shear, np.abs(shear)])
    some = np.array([row["origin"] == "candidate" for row in rows], bool)
    candidates = [row for row, is_one in zip(rows, some) if is_one]
    known = judge.score.Case(judge.truth(case.folder))
    right = np.array([known.match(*judge.ends(row)) is not None for row in candidates], bool)
    return x[some], right, candidates


def precision(case, got, columns, model):
    """Average precision of a case ranked by a stacked model, or by P alone."""
    x, _, rows = got
    score = model.predict_proba(x[:, columns])[:, 1] if model is not None and len(x) else x[:, 0]
    ranked = [dict(row, stacked=repr(float(s))) for row, s in zip(rows, score)]
    return judge.ranked(case, ranked, "stacked")


def hydraulics(work, cases):
    """Average precision of P with each set of figures less that of P alone, the stack fitted on the other subjects."""
    from sklearn.linear_model import LogisticRegression
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    weights, rows = command.by_fold(work), []
    # Circles are small, so those of the training draws are asked too: each subject by the weights that never saw it.
    subjects = {c.subject for c in cases}
    draws = [("judged", c) for c in cases if c.data == "circles" or (c.data, c.level) == ("brains", "medium")]
    draws += [(seed, c) for seed, found in bench.training(work).items() for c in found if c.data == "circles" and c.subject in subjects]
    for data, level in dict.fromkeys((c.data, c.level) for _, c in draws):
        seeds, some = zip(*((seed, c) for seed, c in draws if (c.data, c.level) == (data, level)))
        for kind in KINDS:
            got = bench.each(measured, [(c, seed, weights[c.fold], work, kind) for seed, c in zip(seeds, some)])
            alone = [precision(c, g, [0], None) for c, g in zip(some, got)]
            for name, extra in SETS.items():
                columns, stacked = [0, *extra], [np.nan] * len(some)
                for fold in range(bench.FOLDS):
                    inner = [g for c, g in zip(some, got) if c.fold != fold and len(g[0])]
                    model = make_pipeline(StandardScaler(), LogisticRegression(max_iter=1000))
                    model.fit(np.vstack([g[0][:, columns] for g in inner]), np.concatenate([g[1] for g in inner]))
                    for k, c in enumerate(some):
                        if c.fold == fold:
                            stacked[k] = precision(c, got[k], columns, model)
                rows.append(("hydraulics", data, level, f"{name}, {kind}", "AP difference", judge.mean(some, [a - b for a, b in zip(stacked, alone)])))
    return rows


def table(r):
    """A row a data set and set of figures, a column a kind of radii."""
    import tables

    lines = []
    for data, level in r.groups("hydraulics"):
        cases = next(row["cases"] for row in r.rows if row["part"] == "hydraulics" and (row["data"], row["level"]) == (data, level))
        for name in SETS:
            lines.append([f"{data}, {level} ({cases})", name] + [tables.cell(r.get("hydraulics", data, level, f"{name}, {kind}", "AP difference"), True) for kind in KINDS])
    return {"hydraulics": common.table(["cases", "beside P", *KINDS], lines)}

