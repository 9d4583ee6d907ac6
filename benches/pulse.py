"""Times the pulse: by elimination and by faer's sparse LU, and beside svZeroDSolver on the model that willis converts. Prints the tables.

usage: pulse.py WILLIS SAMPLING   (the program, and the benchmark program that `cargo build --release --benches` makes)

Needs svzerod (tests/requirements.txt); graphs of brains come from WILLIS_BENCH_GRAPHS (../shared/bench) and are left out where they are missing.
"""

import json
import os
import subprocess
import sys
import tempfile
import time

HARMONICS, STEPS = 20, 1000
CIRCLE = os.path.join(os.path.dirname(__file__), "..", "data", "circle-of-willis", "complete.graphml")
# A carotid pressure over 0.9 s, mmHg.
WAVE = [(0.0, 80.0), (0.15, 122.0), (0.35, 102.0), (0.42, 104.0), (0.9, 80.0)]
DYNES = 1333.22387415


def figures(sampling, command, graph):
    said = subprocess.run([sampling, "--bench", command, graph, str(HARMONICS)], check=True, capture_output=True, text=True)
    return [float(word) for word in said.stdout.split()]


def solvers(willis, sampling, folder):
    graphs = {"complete circle": CIRCLE}
    brains = os.environ.get("WILLIS_BENCH_GRAPHS", os.path.join(os.path.dirname(__file__), "..", "..", "shared", "bench"))
    for name, file in {"whole brain": "brain-206-726", "whole brain, 13 ends": "brain-206-726-13-terminals"}.items():
        path = os.path.join(brains, file + ".graphml")
        if os.path.exists(path):
            graphs[name] = path
    for kind, edges in [("arterial", 10_000), ("capillary", 1000), ("capillary", 4000)]:
        path = os.path.join(folder, f"{kind}-{edges}.graphml")
        subprocess.run([willis, "phantom", kind, "--edges", str(edges), "--seed", "1", "--break", "-o", path], check=True, capture_output=True)
        graphs[f"phantom, {kind}, {edges:,}"] = path
    print("| graph | vessels | free nodes | whole cycle, ms | of it elimination | LU in its place | cycle with LU | difference | residual | of LU |")
    print("|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|")
    for name, graph in graphs.items():
        whole = figures(sampling, "pulse", graph)[2]
        vessels, free, _, ours, lu, difference, residual, other = figures(sampling, "pulse-solvers", graph)
        both = (whole - ours + lu) / whole
        print(f"| {name} | {vessels:,.0f} | {free:,.0f} | {whole:.3g} | {ours:.3g} | {lu:.3g} | {both:.2f} times | {difference:.0e} | {residual:.0e} | {other:.0e} |")


def time_stepping(willis, sampling, folder):
    import svzerod

    path = os.path.join(folder, "circle.json")
    subprocess.run([willis, "convert", CIRCLE, path, "--to", "svzerod"], check=True, capture_output=True)
    with open(path) as file:
        model = json.load(file)
    for condition in model["boundary_conditions"]:
        values = condition["bc_values"]
        if condition["bc_type"] == "PRESSURE":
            condition["bc_values"] = {"t": [t for t, _ in WAVE], "P": [p * DYNES for _, p in WAVE]}
        elif condition["bc_type"] == "RESISTANCE":
            r = values["R"]
            condition["bc_type"], condition["bc_values"] = "RCR", {"Rp": 0.2 * r, "Rd": 0.8 * r, "C": 0.69 / r, "Pd": values["Pd"]}

    def run(cycles):
        model["simulation_parameters"] = {"number_of_cardiac_cycles": cycles, "number_of_time_pts_per_cardiac_cycle": STEPS + 1}
        solver = svzerod.Solver(model)
        begun = time.perf_counter()
        solver.run()
        return time.perf_counter() - begun, solver.get_full_result()["flow_in"].to_numpy()

    took = min(run(10)[0] for _ in range(5)) / 10
    last = run(30)[1]
    settled = next(n for n in range(1, 30) if abs(run(n)[1] - last).max() < 1e-3 * abs(last).max())
    whole = figures(sampling, "pulse", CIRCLE)[2]
    print(f"\nThe complete circle, one thread: svZeroDSolver {1e3 * took:.3g} ms a cycle of {STEPS} steps, {settled} cycles until the flow is within 0.1 % of periodic; "
          f"willis {whole:.2g} ms for {HARMONICS} harmonics, which are periodic.")


with tempfile.TemporaryDirectory() as folder:
    solvers(sys.argv[1], sys.argv[2], folder)
    time_stepping(sys.argv[1], sys.argv[2], folder)
