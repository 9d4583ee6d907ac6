"""The networks of the experiments: the literature Circle of Willis with its variants, and real subjects where they are.

Real subjects are read from the folder in WILLIS_SHARED_DATA (../shared/data); what is absent is skipped and named.
"""
import csv
import os
import sys
from pathlib import Path
from xml.sax.saxutils import quoteattr

ROOT = Path(__file__).resolve().parent.parent
SHARED = Path(os.environ.get("WILLIS_SHARED_DATA", ROOT / "../shared/data"))
WORK = ROOT / "target/experiments"


class Network:
    """A graph file and what the experiments need to know of it."""

    def __init__(self, group, name, path, conditions, artery, collateral, has_positions=True):
        self.group, self.name, self.path, self.has_positions = group, name, path, has_positions
        # Arguments of willis by boundary condition: "ground" and "terminals".
        self.conditions = conditions
        # The inflow artery to narrow, the communicating artery to occlude (None: there is none).
        self.artery, self.collateral = artery, collateral


def write_graphml(path, nodes, edges):
    """Writes node id -> attributes and (a, b, attributes) as GraphML."""
    path.parent.mkdir(parents=True, exist_ok=True)
    keys = {}
    for kind, rows in (("node", nodes.values()), ("edge", [e[2] for e in edges])):
        for row in rows:
            for key, value in row.items():
                keys[kind, key] = "string" if isinstance(value, str) else "double"
    data = lambda kind, row: "".join(f'<data key="{kind}-{k}">{v if not isinstance(v, str) else quoteattr(v)[1:-1]}</data>' for k, v in row.items())
    with open(path, "w") as out:
        out.write('<?xml version="1.0"?>\n<graphml xmlns="http://graphml.graphdrawing.org/xmlns">\n')
        for (kind, key), of in keys.items():
            out.write(f'<key id="{kind}-{key}" for="{kind}" attr.name="{key}" attr.type="{of}"/>\n')
        out.write('<graph edgedefault="undirected">\n')
        for node, row in nodes.items():
            out.write(f"<node id={quoteattr(node)}>{data('node', row)}</node>\n")
        for a, b, row in edges:
            out.write(f"<edge source={quoteattr(a)} target={quoteattr(b)}>{data('edge', row)}</edge>\n")
        out.write("</graph>\n</graphml>\n")


def literature():
    """The published circle and its ten variants, which ship with the project."""
    grounded = ROOT / "data/outlets-at-ground.csv"
    for path in sorted((ROOT / "data/circle-of-willis").glob("*.graphml"), key=lambda p: (p.stem != "complete", p.stem)):
        conditions = {"ground": ["--bc", str(grounded)], "terminals": []}
        labels = path.read_text()
        collateral = next((label for label in ("L-PComm", "R-PComm") if f">{label}<" in labels), None)
        side = collateral[0] if collateral else "L"
        yield Network("literature", path.stem, path, conditions, f"{side}-ICA I", collateral)


FOUND = {"ground": ["--outlets", "ground"], "terminals": ["--outlets", "murray"]}


def insist():
    """Traced circles of stroke patients: the free ends of carotids, basilar and vertebral arteries are inlets."""
    patients = {}
    for row in csv.DictReader(open(SHARED / "insist-cow/derived_vessels_mm.csv")):
        patients.setdefault(row["patient"], []).append(row)
    for patient, rows in patients.items():
        degree = {}
        nodes = {}
        for row in rows:
            for end in "ab":
                node = row[f"node_{end}"]
                degree[node] = degree.get(node, 0) + 1
                nodes[node] = {f"{axis}_mm": float(row[f"{end}{axis}_mm"]) for axis in "xyz"}
        edges = [
            (r["node_a"], r["node_b"], {"length_mm": float(r["length_mm"]), "radius_mm": float(r["mean_radius_mm"]), "label": r["segment"]})
            for r in rows
        ]
        carotids = {}
        for row in rows:
            free = [row[f"node_{end}"] for end in "ab" if degree[row[f"node_{end}"]] == 1]
            if row["segment"] in ("ICA L", "ICA R", "BA", "VA L", "VA R") and free:
                nodes[free[0]].update(role="inlet", pressure_mmHg=100.0)
                if row["segment"].startswith("ICA"):
                    carotids[row["segment"][-1]] = row["segment"]
        if not carotids:
            continue
        present = {r["segment"] for r in rows}
        side = next((s for s in "LR" if s in carotids and f"PComm {s}" in present), min(carotids))
        path = WORK / f"networks/{patient}.graphml"
        write_graphml(path, nodes, edges)
        collateral = f"PComm {side}" if f"PComm {side}" in present else None
        yield Network("insist-cow", patient, path, FOUND, carotids[side], collateral)


def brava():
    """Whole cerebral trees: the three widest ends are inlets; the widest of them is narrowed, nothing is occluded."""
    nodes, edges, radius, degree = {}, {}, {}, {}
    for row in csv.DictReader(open(SHARED / "brava/derived_nodes.csv")):
        nodes.setdefault(row["subject"], {})[row["node"]] = {f"{axis}_mm": float(row[f"{axis}_mm"]) for axis in "xyz"}
        radius[row["subject"], row["node"]] = float(row["radius_mm"])
        degree[row["subject"], row["node"]] = int(row["degree"])
    for row in csv.DictReader(open(SHARED / "brava/derived_edges.csv")):
        figures = {"length_mm": float(row["length_mm"]), "radius_mm": float(row["r_poiseuille_mm"]), "label": f"vessel {row['edge']}"}
        if figures["length_mm"] > 0 and figures["radius_mm"] > 1e-3:
            edges.setdefault(row["subject"], []).append((row["node_a"], row["node_b"], figures))
    for subject, vessels in edges.items():
        ends = sorted((n for n in nodes[subject] if degree[subject, n] == 1), key=lambda n: -radius[subject, n])[:3]
        for end in ends:
            nodes[subject][end].update(role="inlet", pressure_mmHg=100.0)
        path = WORK / f"networks/{subject}.graphml"
        write_graphml(path, nodes[subject], vessels)
        artery = next(figures["label"] for a, b, figures in vessels if ends[0] in (a, b))
        yield Network("brava", subject, path, FOUND, artery, None)


def padmos():
    """Literature arteries from the heart on with a traced cerebral tree and calibrated terminal resistances."""
    mmhg = 133.322387415
    nodes, edges = {}, []
    for row in csv.DictReader(open(SHARED / "padmos-patient0/derived_edges.csv")):
        for end in ("node_a", "node_b"):
            nodes.setdefault(row[end], {})
        label = row["vessel"].strip('"')
        edges.append((row["node_a"], row["node_b"], {"length_mm": float(row["length_mm"]), "radius_mm": float(row["r_poiseuille_mm"]), "label": label}))
    terminals = {}
    for row in csv.DictReader(open(SHARED / "padmos-patient0/derived_terminals.csv")):
        if row["kind"] == "inlet":
            nodes[row["node"]].update(role="inlet", pressure_mmHg=100.0)
        else:
            resistance = (float(row["R1_Pa_s_per_m3"]) + float(row["R2_Pa_s_per_m3"])) / mmhg / 1e6
            terminals[row["node"]] = {"role": "outlet", "resistance_mmHg_s_per_mL": resistance, "venous_pressure_mmHg": 666 / mmhg}
    for node, condition in terminals.items():
        nodes[node].update(condition)
    path = WORK / "networks/padmos-patient0.graphml"
    write_graphml(path, nodes, edges)
    grounded = path.with_suffix(".ground.csv")
    grounded.write_text("node,kind\n" + "".join(f"{node},ground\n" for node in terminals))
    artery = next(e[2]["label"] for e in edges if e[2]["label"].startswith("L") and "int. carotid" in e[2]["label"])
    yield Network("padmos-patient0", "padmos-patient0", path, {"ground": ["--bc", str(grounded)], "terminals": []}, artery, "L. PCoA", has_positions=False)


def networks():
    """All networks at hand."""
    yield from literature()
    for group, folder in ((insist, "insist-cow"), (brava, "brava"), (padmos, "padmos-patient0")):
        if (SHARED / folder).is_dir():
            yield from group()
        else:
            print(f"skipped: no {SHARED / folder}", file=sys.stderr)
