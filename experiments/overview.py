"""The table of this folder's README, from the results of the experiments."""
import csv
from pathlib import Path

import common

HERE = Path(__file__).resolve().parent


def rows(name):
    with open(HERE / name / "results.csv", newline="") as file:
        return list(csv.DictReader(file))


def median(values):
    return common.quantile(list(values), 0.5)


stenosis = rows("controlled-stenosis")
falls = lambda outlets: f"{sum(float(r['rho_G_ratio']) < 1 for r in stenosis if r['outlets'] == outlets)} of {sum(r['outlets'] == outlets for r in stenosis)} networks"
modulation = [r for r in rows("resistance-modulation") if r["reading"] == "increment" and r["class"] == "0.3:0.5"]
ratio = lambda outlets, key: f"{median(float(r[key]) for r in modulation if r['outlets'] == outlets):.2f}"
topologies = [r for r in rows("redundant-topologies") if r["extraction"] == "whole"]
kept = lambda what: f"{100 * sum(int(r[what + '_above']) for r in topologies) / sum(int(r[what]) for r in topologies):.0f} %"
circles = [r for r in rows("median-circle") if r["choice"] == "base" and r["radius"] == "mean" and r["uncertain"] == "all"]
whole = ["{} of {}".format(sum("0" not in r["ring"] for r in some), len(some)) for some in ([r for r in circles if r["epsilon"] == epsilon] for epsilon in ("0.2", "0.3", "0.5"))]
speed = [r for r in rows("throughput") if r["threads"] == "1"]
lines = [
    ["`controlled-stenosis`", "ρ_G 23.7→20.8, 18.0→16.0, 17.0→15.5: falls for all three phenotypes", f"falls in {falls('ground')} with outlets at ground, in {falls('terminals')} behind terminal resistances"],
    ["`resistance-modulation`", "flow falls, pressure rises, ρ falls, by up to half", f"R(1+u), u in 0.3-0.5, medians: ground ρ_G × {ratio('ground', 'rho_G_ratio')}, flow × {ratio('ground', 'inflow_ratio')}; terminals ρ_G × {ratio('terminals', 'rho_G_ratio')}, flow × {ratio('terminals', 'inflow_ratio')}"],
    ["`redundant-topologies`", "the median topology keeps the phenotype, ε = 0.2, 0.3, 0.5", f"above the median: {kept('true')} of the true vessels, {kept('false')} of the redundant ones, {len(topologies) // 3} networks"],
    ["`median-circle`", "the same", f"the whole ring above the median in {', '.join(whole)} random geometries of the published circle (ε = 0.2, 0.3, 0.5)"],
    ["`throughput`", "0.4 ± 0.2 ms a simulation", f"{min(float(r['microseconds']) for r in speed):.2f} to {max(float(r['microseconds']) for r in speed):.1f} µs, one thread, {len(speed)} networks"],
]
common.splice(HERE / "README.md", "overview", common.table(["experiment", "the paper", "here"], lines))
