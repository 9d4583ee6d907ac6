"""The published circle, random geometries of it, and redundant connections between its junctions."""
import math
import random
import xml.etree.ElementTree as xml

from networks import ROOT

# The ring, in the order of a walk round it; both P1 meet at the tip of the basilar, which closes it.
RING = ["L-P1", "L-PComm", "L-ICA II", "L-A1", "AComm", "R-A1", "R-ICA II", "R-PComm", "R-P1"]
NEAREST = 6
# mm, standard deviation along each axis: 1.7 mm in all, and of the logarithm of a radius.
SHIFT, SPREAD = 1.0, 0.05
# Half a voxel of 0.5 mm, as in a time-of-flight angiogram: a vessel that the scan would not show.
CAP = 0.25
SPACE = "{http://graphml.graphdrawing.org/xmlns}"
AXES = ("x_mm", "y_mm", "z_mm")


def published():
    """Nodes id -> attributes, vessels (a, b, attributes) of the file that ships with the project."""
    graph = xml.parse(ROOT / "data/circle-of-willis/complete.graphml").getroot()
    names = {key.get("id"): (key.get("attr.name"), key.get("attr.type")) for key in graph.iter(SPACE + "key")}

    def attributes(element, wanted):
        found = {names[d.get("key")][0]: (d.text, names[d.get("key")][1]) for d in element.iter(SPACE + "data")}
        return {k: float(found[k][0]) if found[k][1] != "string" else found[k][0] for k in wanted if k in found}

    wanted = (*AXES, "role", "pressure_mmHg", "resistance_mmHg_s_per_mL")
    nodes = {node.get("id"): attributes(node, wanted) for node in graph.iter(SPACE + "node")}
    vessels = [(e.get("source"), e.get("target"), attributes(e, ("label", "length_mm", "radius_mm"))) for e in graph.iter(SPACE + "edge")]
    return nodes, vessels


def chord(nodes, a, b):
    return math.dist([nodes[a][x] for x in AXES], [nodes[b][x] for x in AXES])


def perturbed(nodes, vessels, seed, shift=SHIFT, spread=SPREAD):
    """Every node moved, every radius scaled, every length in proportion to the distance between its ends."""
    draw = random.Random(seed)
    moved = {n: {**row, **{x: row[x] + draw.gauss(0, shift) for x in AXES}} for n, row in nodes.items()}
    scaled = []
    for a, b, row in vessels:
        stretch = chord(moved, a, b) / chord(nodes, a, b)
        scaled.append((a, b, {**row, "length_mm": row["length_mm"] * stretch, "radius_mm": row["radius_mm"] * math.exp(draw.gauss(0, spread))}))
    return moved, scaled


def candidates(nodes, vessels, rule):
    """Each junction joined to its nearest six; pairs that a vessel joins already are left out."""
    ends = [n for a, b, _ in vessels for n in (a, b)]
    junctions = [n for n in nodes if ends.count(n) > 2]
    # The radius at a junction is that of its widest vessel, as in the file.
    radius = {n: max(row["radius_mm"] for a, b, row in vessels if n in (a, b)) for n in junctions}
    joined = {frozenset((a, b)) for a, b, _ in vessels}
    found = []
    for a in junctions:
        near = sorted((n for n in junctions if n != a), key=lambda n: (chord(nodes, a, n), int(n)))
        for b in near[:NEAREST]:
            if frozenset((a, b)) not in joined:
                joined.add(frozenset((a, b)))
                both = (radius[a], radius[b])
                r = {"mean": sum(both) / 2, "min": min(both), "cap": min(*both, CAP)}[rule]
                found.append((a, b, {"label": f"{a}-{b}", "length_mm": chord(nodes, a, b), "radius_mm": r}))
    return found
