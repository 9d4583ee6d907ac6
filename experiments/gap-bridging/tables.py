"""The tables of README.md, from results.csv alone."""
import bench
import common
import contest
import hydraulics
import questions

# Where results.csv and the figures go: elsewhere for a look at some subjects only.
FOLDER = bench.HERE
COLUMNS = ("part", "data", "level", "row", "figure", "value", "low", "high", "cases")


def save(rows):
    """Writes rows into results.csv in place of those of the same parts."""
    path = FOLDER / "results.csv"
    old = common.rows(path) if path.exists() else []
    fresh = {row[0] for row in rows}
    new = [dict(zip(COLUMNS, (*row[:5], *(f"{v:.4f}" for v in row[5][:3]), row[5][3]))) for row in rows if row[5]]
    order = {part: k for k, part in enumerate(("main", "flow", "hydraulics", "robust", "loops", "draws"))}
    common.write_results(FOLDER, sorted([r for r in old if r["part"] not in fresh] + new, key=lambda r: order[r["part"]]))


def digits(text):
    """Three decimals, without the zero before the point."""
    return f"{float(text):.3f}".replace("0.", ".", 1) if abs(float(text)) < 1 else f"{float(text):.3f}"


def cell(row, signed=False):
    """value [low, high]."""
    if row is None:
        return ""
    if row["figure"] == "bridges a case":
        return "{:.0f} [{:.0f}, {:.0f}]".format(*(float(row[k]) for k in ("value", "low", "high")))
    value, low, high = (digits(row[k]) for k in ("value", "low", "high"))
    return f"{'+' if signed and float(row['value']) >= 0 else ''}{value} [{low}, {high}]"


class Results:
    """Look-up in results.csv."""

    def __init__(self):
        self.rows = common.rows(FOLDER / "results.csv")
        self.by = {tuple(row[c] for c in COLUMNS[:5]): row for row in self.rows}

    def get(self, *key):
        return self.by.get(key)

    def value(self, *key):
        return float(self.by[key]["value"])

    def groups(self, part):
        """(data, level) in order."""
        return list(dict.fromkeys((r["data"], r["level"]) for r in self.rows if r["part"] == part))


def main(r):
    lines, paired = [], []
    both = [figure for figure in contest.FIGURES if figure != "floor"]
    for data, level in r.groups("main"):
        if level == "all":
            continue
        cases = r.get("main", data, level, "willis", "bridges a case")
        name = f"{data}, {level} ({cases['cases']})"
        for method in contest.METHODS:
            lines.append([name, method] + [cell(r.get("main", data, level, method, figure)) for figure in contest.FIGURES])
        paired.append([name] + [cell(r.get("main", data, level, "willis - forest2", figure), True) for figure in both])
    calibrated = [method for method in contest.METHODS if r.get("main", "brains", "all", method, "pooled ECE")]
    sets = list(dict.fromkeys(row["data"] for row in r.rows if row["level"] == "all" and row["figure"] == "pooled ECE"))
    pooled = [[data] + [cell(r.get("main", data, "all", method, "pooled ECE")) for method in calibrated] for data in sets]
    return {"main": common.table(["cases", "method", *contest.FIGURES], lines), "pooled": common.table(["pooled ECE, all levels", *calibrated], pooled), "paired": common.table(["willis less forest2", *both], paired)}


def ablation(r):
    """What ranks the candidates of brains at medium damage, for the book."""
    found = [(ranking, r.get("flow", "brains", "medium", ranking, "AP")) for ranking in questions.RANKINGS]
    return common.table(["ranked by", "AP"], [[ranking, cell(row)] for ranking, row in found if row])


def peers(r):
    """willis and other programs on the same gaps at medium damage, for the paper."""
    names = {"willis": "willis", "tubetk": "the rule of ITKTubeTK", "heal": "`heal_skeleton` of navis", "MST": "minimum spanning tree of the gaps", "geometry": "gap and bend, best first", "boosting": "boosted trees, candidate by candidate"}
    figures = ("AP", "F1", "path", "false length fed", "exact")
    rows = [[data, name] + [cell(r.get("main", data, "medium", method, figure)) for figure in figures] for data in ("brains", "circles") for method, name in names.items()]
    return common.table(["cases", "method", *figures], rows)


def flow(r):
    lines = [[f"{data}, {level}"] + [cell(r.get("flow", data, level, ranking, "AP")) for ranking in questions.RANKINGS] + [cell(r.get("flow", data, level, "frequency - P", "AP"), True)] for data, level in r.groups("flow")]
    return {"flow": common.table(["cases", *questions.RANKINGS, "frequency less P"], lines)}


def robust(r):
    same, other = [], []
    for data, level, kind in dict.fromkeys((row["data"], row["level"], row["row"]) for row in r.rows if row["part"] == "robust"):
        get = lambda figure: r.get("robust", data, level, kind, figure)
        name = f"{data}, {level} ({get('AP')['cases']})"
        if get("kept"):
            count = lambda figure: f"{float(get(figure)['value']):.0f}"
            same.append([kind, name, f"{count('same decisions')} of {get('kept')['cases']}", f"{count('kept that differ')} of {count('kept')}", digits(get("largest change of P")["value"]), cell(get("AP difference"), True)])
        else:
            other.append([kind, name] + [x for figure in ("AP", "F1", "path", "exact") for x in (cell(get(figure)), cell(get(figure + " difference"), True))])
    header = ["weights, inlets", "cases"] + [x for figure in ("AP", "F1", "path", "exact") for x in (figure, "less the usual")]
    return {"same": common.table(["told", "cases", "same decisions", "kept bridges that differ", "largest change of P", "change of AP"], same), "robust": common.table(header, other)}


def loops(r):
    lines = []
    for data, level in r.groups("loops"):
        for method in ("willis", "forest2"):
            get = lambda figure: r.get("loops", data, level, method, figure)
            count = lambda figure: f"{float(get(figure)['value']):.0f}"
            lines.append([f"{data}, {level} ({get('true')['cases']})", method, count("true"), count("found"), cell(get("found of true")), count("false"), cell(get("false a case"))])
    return {"loops": common.table(["cases", "method", "true closures", "found", "share", "false", "false a case"], lines)}


def draws(r):
    lines, figures = [], ("exact", "present", "absent", "AP", "pooled ECE")
    seeds = list(dict.fromkeys(row["row"] for row in r.rows if row["part"] == "draws"))[:-1]
    for data, level in r.groups("draws"):
        every = [r.get("draws", data, level, "all", figure) for figure in figures]
        lines.append([f"{data}, {level} ({every[0]['cases']})"] + [digits(r.value("draws", data, level, seed, "exact")) for seed in seeds] + [cell(row) for row in every])
    return {"draws": common.table(["cases", *(f"exact, {seed}" for seed in seeds), *(f"{figure}, all" for figure in figures)], lines)}


def write(part):
    """Prints the tables of a part and puts them into README.md."""
    for mark, text in {"main": main, "flow": flow, "hydraulics": hydraulics.table, "robust": robust, "loops": loops, "draws": draws}[part](Results()).items():
        if FOLDER == bench.HERE:
            common.splice(FOLDER / "README.md", mark, text)
        print(text + "\n", flush=True)
    if part == "main":
        (FOLDER / "peers.md").write_text(peers(Results()) + "\n")
    if part == "flow":
        (FOLDER / "ablation.md").write_text(ablation(Results()) + "\n")
