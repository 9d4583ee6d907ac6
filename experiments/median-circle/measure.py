"""One geometry pruned at the median: which vessels stay, and what L is made of."""
import common
from circles import RING, candidates, perturbed, published
from networks import ROOT, WORK, write_graphml

EPSILONS = ["0.2", "0.3", "0.5"]
RADII = {"none": "no candidates", "mean": "mean of the ends", "min": "smaller end", "cap": "smaller end, at most 0.25 mm"}
UNCERTAIN = {"all": "all", "candidates": "candidates", "ring": "candidates and the ring"}
GROUND = ["--bc", str(ROOT / "data/outlets-at-ground.csv")]
# Everything else as it is in the other runs: (spread of the radii, samples, boundary conditions).
CHOICES = {
    "base": ("as above", 0.05, 1000, GROUND),
    "samples": ("16,384 samples", 0.05, 16384, GROUND),
    "spread": ("radii that spread by 20 %", 0.20, 1000, GROUND),
    "terminals": ("outlets with terminal resistances", 0.05, 1000, []),
}
SETTINGS = [("base", radius, "all") for radius in RADII] + [("base", radius, "candidates") for radius in list(RADII)[1:]] + [("base", "mean", "ring")]
SETTINGS += [(choice, "mean", "all") for choice in CHOICES if choice != "base"]
WORKING = WORK / "median-circle"


def kind(label):
    """The artery without its side."""
    return label.removeprefix("L-").removeprefix("R-")


ARTERIES = list(dict.fromkeys(map(kind, RING)))


def flow_shares(source, out, conditions):
    """Label -> share of the inflow, nothing occluded."""
    common.willis("simulate", source, "-o", out, *conditions)
    inflow = common.record(out)["total_inflow_mL_per_min"]
    return {e["label"]: abs(float(e["flow_mL_per_min"])) / inflow for e in common.rows(out / "edges.csv")}


def factors(edges, samples):
    """Label of each vessel of the ring -> frequency, and frequency and mean ρ in the forest, the two factors of L, over the medians of what carries flow."""
    carrying = [e for e in edges if float(e["likelihood"]) > 0]
    frequency = lambda e: float(e["frequency"])
    strength = lambda e: float(e["likelihood"]) / samples / frequency(e) if float(e["likelihood"]) > 0 else 0.0
    often, strong = (common.quantile([f(e) for e in carrying], 0.5) for f in (frequency, strength))
    return {e["label"]: (frequency(e), frequency(e) / often, strength(e) / strong) for e in edges if e["label"] in RING}


def measure(job):
    """All ε of one geometry and setting."""
    (choice, radius, uncertain), seed = job
    _, spread, samples, conditions = CHOICES[choice]
    nodes, vessels = perturbed(*published(), seed, spread=spread)
    false = [] if radius == "none" else candidates(nodes, vessels, radius)
    origin = lambda row: "candidate" if uncertain == "ring" and row["label"] in RING else "observed"
    edges = [(a, b, {**row, "origin": origin(row)}) for a, b, row in vessels]
    source = WORKING / f"{choice}-{radius}-{uncertain}-{seed}.graphml"
    write_graphml(source, nodes, edges + [(a, b, {**row, "origin": "candidate"}) for a, b, row in false])
    out = source.with_suffix("")
    which = [] if uncertain == "all" else ["--uncertain", "candidates"]
    common.willis("infer", source, "-o", out, "--preset", "paper", *which, "--epsilon", ",".join(EPSILONS), "-n", samples, "--seed", seed, "--dpi", 36, *conditions)
    shares = flow_shares(source, out / "flow", conditions) if choice == "base" and uncertain == "all" else {}
    results = []
    for epsilon in EPSILONS:
        found = common.rows(out / f"epsilon-{epsilon}" / "edges.csv")
        above = {e["label"]: e["above_median"] == "1" for e in found}
        true = [row["label"] for _, _, row in vessels]
        results.append({
            "choice": choice, "radius": radius, "uncertain": uncertain, "epsilon": epsilon, "geometry": seed,
            "true": len(true), "true_above": sum(above[label] for label in true),
            "false": len(false), "false_above": sum(above[row["label"]] for _, _, row in false),
            "ring": "".join(str(int(above[label])) for label in RING),
            "shares": shares, "factors": factors(found, samples),
        })
    return results
