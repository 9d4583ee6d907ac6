//! svZeroDSolver itself reads what `willis convert --to svzerod` writes, and its flow is that of willis. Needs `WILLIS_PYTHON` with svzerod.

use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};
use willis::internals::formats::{SolverSetting, read_waveform, write_svzerod};
use willis::internals::network::{Condition, Network, Node, Vessel, Windkessel};
use willis::internals::phantom::{Anatomy, Recipe};
use willis::internals::simulation::pulse::fourier::{coefficients, samples};
use willis::internals::simulation::pulse::womersley::Fluid;
use willis::internals::simulation::pulse::{Friction, Pulse};
use willis::{FlowOptions, PulseOptions, ReadOptions, Silent, solver_model};

use crate::pulse_case::{BLOOD, Case, pressure_wave};

/// Solves each model and prints per vessel its flow (mL/s) at both ends and pressure (dyn/cm²) at both ends over the last cycle, as lists.
/// What follows the paths replaces every inlet's pressure: times and values of one period, and steps a cycle.
const SCRIPT: &str = r#"
import json, sys, time
import svzerod
paths, wave = sys.argv[1].split("\n"), json.loads(sys.argv[2])
for path in paths:
    model = json.load(open(path))
    model["simulation_parameters"]["absolute_tolerance"] = 1e-10
    if wave:
        model["simulation_parameters"].update(number_of_time_pts_per_cardiac_cycle=wave["steps"] + 1, number_of_cardiac_cycles=wave["cycles"])
        for bc in model["boundary_conditions"] if "t" in wave else []:
            if bc["bc_type"] == "PRESSURE" and bc["bc_name"].startswith("INLET"):
                bc["bc_values"] = {"P": wave["P"], "t": wave["t"]}
    solver = svzerod.Solver(model)
    start = time.perf_counter()
    solver.run()
    took = time.perf_counter() - start
    result = solver.get_full_result()
    columns = ["flow_in", "flow_out", "pressure_in", "pressure_out"]
    print(json.dumps({"seconds": took, "vessels": {name: [of[c].tolist() for c in columns] for name, of in result.groupby("name")}}))
"#;

/// What svZeroDSolver says of models; `None`, said aloud, where it is absent.
fn solved(paths: &[&Path], wave: &Value) -> Option<Vec<Value>> {
    let Ok(python) = std::env::var("WILLIS_PYTHON") else {
        eprintln!("skipped: WILLIS_PYTHON names no Python with tests/requirements.txt");
        return None;
    };
    let list: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
    let output = Command::new(python).args(["-c", SCRIPT, &list.join("\n"), &wave.to_string()]).output().expect("python runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).expect("text");
    Some(said.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect())
}

fn written(folder: &Path, name: &str, network: &Network) -> std::path::PathBuf {
    let path = folder.join(format!("{name}.json"));
    write_svzerod(&mut std::fs::File::create(&path).expect("a file"), network, &SolverSetting::default()).expect("a model");
    path
}

/// Whether the vessel of a row is turned in a model: it stops where the network has it begin.
fn turned(model: &Value, network: &Network, row: usize) -> bool {
    let [a, _] = network.ends(row);
    let stops_at_junction = model["junctions"].as_array().expect("junctions").iter().any(|junction| {
        junction["junction_name"] == json!(format!("J{a}"))
            && junction["inlet_vessels"].as_array().expect("rows").contains(&json!(row))
    });
    let outlet = &model["vessels"][row]["boundary_conditions"]["outlet"];
    stops_at_junction || *outlet == json!(format!("OUTLET_{}", network.node(a).id))
}

fn reals(value: &Value) -> Vec<f64> {
    value.as_array().expect("numbers").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// Every circle that ships, and the tree from the heart: steady flow and pressures, of the largest.
#[test]
fn it_reads_every_circle_and_finds_its_steady_flow() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut networks = vec![Anatomy::CircleOfWillis.network(&Recipe::default()).expect("a phantom")];
    for file in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/data/circle-of-willis")).expect("the circles") {
        networks.push(willis::read(&file.expect("a file").path(), &ReadOptions::default()).expect("a circle").network);
    }
    let paths: Vec<_> = networks.iter().enumerate().map(|(k, n)| written(folder.path(), &k.to_string(), n)).collect();
    let Some(said) = solved(&paths.iter().map(|p| &**p).collect::<Vec<_>>(), &Value::Null) else { return };
    let mut worst = 0.0_f64;
    for ((network, path), said) in networks.iter().zip(&paths).zip(said) {
        let model: Value = serde_json::from_slice(&std::fs::read(path).expect("the model")).expect("JSON");
        let input = willis::Input::from_network(network.clone());
        let run = willis::simulate(&input, &[], &FlowOptions::default()).expect("a flow");
        let state = &run.result.unperturbed;
        let largest = state.vessels.iter().map(|v| v.flow.abs()).fold(0.0, f64::max);
        for (row, vessel) in state.vessels.iter().enumerate() {
            let found = &said["vessels"][format!("branch{row}_seg0")];
            let [flow, at_a, at_b] = [0, 2, 3].map(|column| *reals(&found[column]).last().expect("a time"));
            let (sign, ends) = if turned(&model, network, row) { (-1.0, [at_b, at_a]) } else { (1.0, [at_a, at_b]) };
            worst = worst.max((sign * flow * 1e-6 - vessel.flow).abs() / largest);
            for (node, pressure) in network.ends(row).into_iter().zip(ends) {
                let known = state.pressure[node].expect("a pressure");
                worst = worst.max((pressure / 10.0 - known).abs() / known);
            }
        }
    }
    println!("largest difference {worst:.1e}");
    assert!(worst < 1e-9, "{worst:e}");
}

/// The network with every vessel in pieces of at most some length (m), with what its row was.
fn in_pieces(network: &Network, longest: f64) -> (Network, Vec<Vec<usize>>) {
    let mut fine = Network::new();
    for node in network.nodes() {
        fine.add_node(node.clone());
    }
    let mut rows = Vec::new();
    for ([a, b], vessel) in network.vessels() {
        let count = (vessel.length / longest).ceil().max(1.0) as usize;
        let piece = Vessel { wall: vessel.wall, ..Vessel::new(vessel.length / count as f64, vessel.radius, vessel.origin) };
        let mut from = a;
        let mut own = Vec::new();
        for k in 1..=count {
            let to = if k == count { b } else { fine.add_node(Node { id: format!("{a}-{b}-{k}"), ..Node::default() }) };
            own.push(fine.vessel_count());
            fine.add_vessel([from, to], piece.clone());
            from = to;
        }
        rows.push(own);
    }
    (fine, rows)
}

/// A carotid pressure into the complete circle, outlets behind a Windkessel of 0.69 s whose R1 is matched by the converter. svZeroDSolver lumps
/// each vessel, so that it comes to the linear theory with the profile frozen as its vessels become pieces of a few millimetres: the flow,
/// RMS over the largest of each vessel, as in Boileau et al. 2015.
#[test]
fn its_waveforms_come_to_those_of_the_linear_theory() {
    const STEPS: usize = 1000;
    const WAVE: &[u8] = b"time_s,pressure_mmHg\n0,80\n0.15,122\n0.35,102\n0.42,104\n0.9,80\n";
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/circle-of-willis/complete.graphml");
    let mut network = willis::read(path.as_ref(), &ReadOptions::default()).expect("a circle").network;
    let wave = read_waveform(WAVE).expect("a waveform").0;
    let period = wave.own_period();
    let c = coefficients(&wave, period, 60);
    let (mut conditions, mut drives) = (Vec::new(), Vec::new());
    for node in 0..network.node_count() {
        match network.node(node).condition {
            Some(Condition::Resistance { resistance, venous }) => {
                network.node_mut(node).windkessel = Windkessel { proximal: None, compliance: Some(0.69 / resistance) }.stated();
                conditions.push((node, Condition::Resistance { resistance, venous }));
            }
            Some(_) => {
                conditions.push((node, Condition::Pressure(c[0].re)));
                drives.push(pressure_wave(node, &c));
            }
            None => {}
        }
    }
    let fluid = Fluid { friction: Friction::Parabolic, ..BLOOD };
    let pulse: Pulse = Case { fluid, period, ..Case::new(&network, &conditions, drives) }.solve();
    let folder = tempfile::tempdir().expect("a folder");
    let lengths = [1.0, 0.02, 0.005];
    let fine: Vec<_> = lengths.iter().map(|longest| in_pieces(&network, *longest)).collect();
    let paths: Vec<_> = fine.iter().enumerate().map(|(k, (n, _))| written(folder.path(), &k.to_string(), n)).collect();
    let told = json!({
        "t": wave.times, "P": wave.values.iter().map(|p| p * 10.0).collect::<Vec<f64>>(), "steps": STEPS, "cycles": 15,
    });
    let Some(said) = solved(&paths.iter().map(|p| &**p).collect::<Vec<_>>(), &told) else { return };
    // The same by the conditions of a simulation, which the converter writes: no compliance is stated, and the wave is in a file.
    let table = folder.path().join("wave.csv");
    std::fs::write(&table, WAVE).expect("written");
    let mut bare = fine[2].0.clone();
    (0..bare.node_count()).for_each(|node| bare.node_mut(node).windkessel = None);
    let pulse_of = PulseOptions {
        waveforms: vec![table.display().to_string()],
        friction: Friction::Parabolic,
        harmonics: 60,
        ..PulseOptions::default()
    };
    let options = FlowOptions { pulse: Some(pulse_of), ..FlowOptions::default() };
    let (model, setting) = solver_model(&willis::Input::from_network(bare), &options, &mut Silent).expect("a model");
    let path = folder.path().join("whole.json");
    write_svzerod(&mut std::fs::File::create(&path).expect("a file"), &model, &setting).expect("a model");
    let by_itself = solved(&[&path], &json!({ "steps": STEPS, "cycles": 15 })).expect("a solution").swap_remove(0);
    let mut worsts = Vec::new();
    let all = fine.iter().zip(&paths).zip(&said).map(|((fine, path), said)| (fine, path, said));
    for ((network_of, rows), path, said) in all.chain([(&fine[2], &path, &by_itself)]) {
        let model: Value = serde_json::from_slice(&std::fs::read(path).expect("the model")).expect("JSON");
        let mut errors = Vec::new();
        for (row, own) in rows.iter().enumerate() {
            // The flow into the first piece and out of the last.
            for (piece, end, place) in [(own[0], 0, 0), (own[own.len() - 1], 1, 2)] {
                let is_turned = turned(&model, network_of, piece);
                let column = if is_turned { 1 - end } else { end };
                let theirs = reals(&said["vessels"][format!("branch{piece}_seg0")][column]);
                let ours = samples(&pulse.vessels[row].flow[place], STEPS);
                let largest = ours.iter().fold(0.0, |most: f64, q| most.max(q.abs()));
                // The last cycle: the time of its first sample is that of the wave's.
                let off = |(q, theirs): (&f64, &f64)| (q - if is_turned { -1e-6 } else { 1e-6 } * theirs).powi(2);
                let square: f64 = ours.iter().zip(&theirs[theirs.len() - STEPS - 1..]).map(off).sum();
                if largest > 1e-3 * pulse.largest_flow {
                    errors.push(100.0 * (square / STEPS as f64).sqrt() / largest);
                }
            }
        }
        errors.sort_by(f64::total_cmp);
        let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
        let seconds = said["seconds"].as_f64().expect("a time");
        println!(
            "{} vessels: RMS of Q, median {median:.2} %, worst {worst:.2} %; {:.1} ms a cycle",
            network_of.vessel_count(),
            1e3 * seconds / 15.0
        );
        worsts.push(worst);
    }
    assert!(worsts[0] > worsts[1] && worsts[1] > worsts[2] && worsts[2] < 1.0 && worsts[3] < 1.0, "{worsts:?}");
}
