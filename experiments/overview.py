"""The table of this folder's README: the headline figures of every experiment, from its results alone; of one that is stale, none."""
import sys
from pathlib import Path

import common

HERE = Path(__file__).resolve().parent


def rows(name, table="results.csv"):
    return common.rows(HERE / name / table)


def is_stale(name):
    return (HERE / name / "README.md").read_text().startswith("> **Stale.**")


def in_readme(name, mark):
    """The cells of the first table after a mark of a README, a dictionary a row."""
    lines = iter((HERE / name / "README.md").read_text().split(f"<!-- {mark} -->")[1].splitlines())
    cells = lambda line: [cell.strip() for cell in line.strip("|").split("|")]
    header = next(cells(line) for line in lines if line.startswith("|"))
    next(lines)
    out = []
    for line in lines:
        if not line.startswith("|"):
            return out
        out.append(dict(zip(header, cells(line))))
    return out


def median(values):
    return common.quantile(list(values), 0.5)


stenosis = rows("controlled-stenosis")
falls = lambda outlets: f"{sum(float(r['rho_G_ratio']) < 1 for r in stenosis if r['outlets'] == outlets)} of {sum(r['outlets'] == outlets for r in stenosis)} networks"
modulation = [r for r in rows("resistance-modulation") if r["reading"] == "increment" and r["u"] == "0.3:0.5"]
ratio = lambda outlets, key: f"{median(float(r[key]) for r in modulation if r['outlets'] == outlets):.2f}"
topologies = [r for r in rows("redundant-topologies") if r["extraction"] == "whole"]
kept = lambda what: f"{100 * sum(int(r[what + '_above']) for r in topologies) / sum(int(r[what]) for r in topologies):.0f} %"
circles = [r for r in rows("median-circle") if r["choice"] == "base" and r["radius"] == "mean" and r["uncertain"] == "all"]
whole = ["{} of {}".format(sum("0" not in r["ring"] for r in some), len(some)) for some in ([r for r in circles if r["epsilon"] == epsilon] for epsilon in ("0.2", "0.3", "0.5"))]
speed = [r for r in rows("throughput") if r["threads"] == "1"]
gaps = {(r["part"], r["data"], r["level"], r["row"], r["figure"]): float(r["value"]) for r in rows("gap-bridging")}
of_brains = lambda method, figure: f"{gaps['main', 'brains', 'medium', method, figure]:.3f}"
skeletons = {(r["level"], r["answer"], r["figure"]): float(r["value"]) for r in rows("skeletons")}
real = in_readme("real-masks", "masks:begin")[-1]
answers = [r for r in rows("proofreading") if (r["level"], r["order"]) == ("good", "review")]
asked = lambda count, figure: "{:.3f}".format(sum(values := [float(r["value"]) for r in answers if (r["asked"], r["figure"]) == (count, figure)]) / len(values))
found = [r for r in rows("candidates") if r["rule"] == "default"]
tubes = {(r["width"], r["rule"]): float(r["bias_percent"]) for r in rows("masks", "radii.csv") if r["image"] == "mask"}
flows = [r for r in rows("flow-shares") if (r["outlets"], r["network"]) == ("resistance", "complete")]
inflow = {name: sum(float(r["flow_mL_per_min"]) for r in flows if r["vessel"].endswith(name)) for name in ("ICA I", "VA")}
named = {r["level"]: r["M1 and M2 as one"] for r in in_readme("labels", "patients:begin")}
drawn = in_readme("phenotypes", "literature")[-1]["willis, nothing but the file"].strip("*")
relations = [[cell.strip() for cell in line.strip("|\n").split("|")] for line in (HERE / "metamorphic/table.md").read_text().splitlines()[2:]]
kills = in_readme("faults", "kills:begin")
nothing = in_readme("compare", "rates:begin")[0]
gains = [r for r in rows("variance") if r["kind"] == "scheme" and r["equal_cost"]]
best = max(gains, key=lambda r: float(r["equal_cost"]))
lines = [
    ["`controlled-stenosis`", "the paper: ρ_G 23.7→20.8, 18.0→16.0, 17.0→15.5: falls for all three phenotypes", f"falls in {falls('ground')} with outlets at ground, in {falls('terminals')} behind terminal resistances"],
    ["`resistance-modulation`", "the paper: flow falls, pressure rises, ρ falls, by up to half", f"R(1+u), u in 0.3-0.5, medians: ground ρ_G × {ratio('ground', 'rho_G_ratio')}, flow × {ratio('ground', 'inflow_ratio')}; terminals ρ_G × {ratio('terminals', 'rho_G_ratio')}, flow × {ratio('terminals', 'inflow_ratio')}"],
    ["`redundant-topologies`", "the paper: the median topology keeps the phenotype, ε = 0.2, 0.3, 0.5", f"above the median: {kept('true')} of the true vessels, {kept('false')} of the redundant ones, {len(topologies) // 3} networks"],
    ["`median-circle`", "the paper: the same", f"the whole ring above the median in {', '.join(whole)} random geometries of the published circle (ε = 0.2, 0.3, 0.5)"],
    ["`throughput`", "the paper: 0.4 ± 0.2 ms a simulation", f"{min(float(r['microseconds']) for r in speed):.2f} to {max(float(r['microseconds']) for r in speed):.1f} µs, one thread, {len(speed)} networks"],
    ["`gap-bridging`", "Which candidates are right, on held-out subjects, compared with other programs and rules on the same gaps?", f"brains, medium damage: AP {of_brains('willis', 'AP')}, F1 {of_brains('willis', 'F1')}, path {of_brains('willis', 'path')} at {of_brains('willis', 'false length fed')} of false length fed"],
    ["`candidates`", "Which search finds the most true connections with the fewest candidates?", f"the default: {sum(int(r['found']) for r in found):,} of {sum(int(r['links']) for r in found):,} true connections among {sum(int(r['candidates']) for r in found):,} candidates"],
    ["`skeletons`", "On automatic skeletons of unseen subjects: which candidates are right, which vessels only touch, and what does repairing both do to the topology?", f"good scans: path {skeletons['good', 'mask-cut', 'path']:.3f}, {skeletons['good', 'mask-uncut', 'path']:.3f} without cuts"],
    ["`real-masks`", "What does willis make of masks that a segmenter really wrote?", f"ten masks, mean: {real['cycles']} cycles kept; of what was put in, {real['gaps closed']} of the gaps closed, {real['fusions undone']} of the fusions undone"],
    ["`proofreading`", "What does a person gain by each decision?", f"good scans: path {asked('0', 'path')}, after 20 decisions {asked('20', 'path')}, after 60 {asked('60', 'path')}"],
    ["`masks`", "Which rule finds the radius of a vessel in a mask, and at what cost?", "bias of tubes of 2 voxels: " + ", ".join(f"{rule} {tubes['2', rule]:+.1f} %" for rule in ("area", "distance", "inscribed"))],
    ["`flow-shares`", "Does the published Circle of Willis distribute flow as measured in people?", f"{sum(inflow.values()):.0f} mL/min in all, {100 * inflow['VA'] / sum(inflow.values()):.1f} % by the vertebrals (terminal resistances)"],
    ["`labels`", "Which artery is which, from geometry alone, in whole and broken circles of patients that the model never saw?", f"share of the length with its name, M1 and M2 as one: {'; '.join(f'{level} {share}' for level, share in named.items())}"],
    ["`phenotypes`", "Which segments of the circle are there, with landmarks and with nothing but the file?", f"drawn circles, with nothing but the file: {drawn} variants exact"],
    ["`metamorphic`", "How far does an answer move where the same vessels are described in another way?", f"{len(relations)} relations: {sum(int(r[4]) for r in relations)} decisions flip, {sum(int(r[5]) for r in relations)} roles differ"],
    ["`compare`", "Does a comparison of groups find a difference where there is one, and none where there is none?", f"no difference: {nothing['any, by Holm']} of {nothing['draws']} draws with any p of Holm <= 0.05; intervals hold 0 in {nothing['interval holds 0']}"],
    ["`faults`", "What stands after a kill or an error at a system call of each command that writes?", f"{len(kills)} commands, {sum(int(r['tried']) for r in kills):,} kills and errors, {sum(int(r['wrong']) for r in kills)} wrong"],
    ["`variance`", "Would antithetic, stratified or low-discrepancy masks, or control variates, reduce the error of L at the same cost?", f"the best median ratio of standard errors at equal cost: {float(best['equal_cost']):.2f} ({best['scheme']}, {best['graph']})"],
]
lines = [[name, question, "stale" if is_stale(name.strip("`")) else said] for name, question, said in lines]
before = (HERE / "README.md").read_text()
common.splice(HERE / "README.md", "overview", common.table(["experiment", "question, or what the paper says", "here"], lines))
if "--check" in sys.argv[1:] and (HERE / "README.md").read_text() != before:
    sys.exit("experiments/README.md was not of these results; it is now")
