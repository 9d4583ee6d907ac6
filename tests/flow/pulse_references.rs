//! The pulse against independent programs: the linear theory in NumPy, openBF (non-linear, in time) and svZeroDSolver (lumped, in time).
//! Their figures are in a folder beside the project; without it the tests say that they are skipped.

use std::path::PathBuf;

use num_complex::Complex64;
use serde_json::Value;
use willis::internals::flow::WallLaw;
use willis::internals::formats::read_waveform;
use willis::internals::network::units::{cubic_metres_per_second, ml_per_min, mmhg};
use willis::internals::network::{Condition, Network, Role, Windkessel};
use willis::internals::simulation::pulse::fourier::{coefficients, samples};
use willis::internals::simulation::pulse::typical::Typical;
use willis::internals::simulation::pulse::womersley::Fluid;
use willis::internals::simulation::pulse::{Friction, Pulse, Pulses};
use willis::{FlowOptions, PulseOptions, ReadOptions};

use crate::pulse_case::{BLOOD, Case, flow, pressure_wave};
use crate::vessels::{network, tube};

fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/pulsatile"));
    if !folder.is_dir() {
        println!("skipped: {} is not there", folder.display());
        return None;
    }
    Some(folder)
}

fn json(folder: &std::path::Path, name: &str) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join(name)).expect("a file")).expect("JSON")
}

/// The pulse of a file with options.
fn solve(path: &std::path::Path, pulse: PulseOptions, viscosity: f64) -> (Network, Pulses) {
    let input = willis::read(path, &ReadOptions::default()).expect("a network");
    let options = FlowOptions { pulse: Some(pulse), viscosity, ..FlowOptions::default() };
    let run = willis::simulate(&input, &[], &options).expect("a flow");
    let pulses = run.pulses.as_ref().expect("it was asked for").0.clone();
    (input.network, pulses)
}

/// openBF's network of a name at its operating point with its inflow. One of its tables of inflow has a time that falls, which a reader
/// refuses, so that they are taken as they stand.
fn openbf(folder: &std::path::Path, name: &str, friction: Friction, harmonics: usize) -> (Network, Pulse) {
    let known = &json(folder, "openbf.json")[name];
    let number = |key: &str| known[key].as_f64().expect("a number");
    let path = folder.join(format!("openbf-{name}.graphml"));
    let network = willis::read(&path, &ReadOptions::default()).expect("a network").network;
    let (_, inflow) = table(folder.join(format!("openbf-{name}.inlet.csv")));
    let values: Vec<f64> = inflow[1].iter().copied().map(cubic_metres_per_second).collect();
    let q = coefficients(&wave(&inflow[0], &values), number("period_s"), harmonics);
    let conditions = network.nodes().enumerate().filter_map(|(node, stated)| match (stated.role, stated.condition) {
        (Some(Role::Inlet), _) => Some((node, Condition::Flow(q[0].re))),
        (_, condition) => condition.map(|condition| (node, condition)),
    });
    let conditions: Vec<(usize, Condition)> = conditions.collect();
    let inlet = network.nodes().position(|node| node.role == Some(Role::Inlet)).expect("an inlet");
    let fluid =
        Fluid { viscosity: number("viscosity_cP") / 1e3, density: number("density_kg_per_m3"), friction, wall_viscosity: 0.0 };
    let drives = vec![flow(inlet, &q)];
    let case = Case { law: WallLaw::Stated, fluid, period: number("period_s"), ..Case::new(&network, &conditions, drives) };
    let pulse = case.solve();
    (network, pulse)
}

fn complex(value: &Value) -> Vec<Complex64> {
    let pair = |c: &Value| Complex64::new(c[0].as_f64().expect("re"), c[1].as_f64().expect("im"));
    value.as_array().expect("pairs").iter().map(pair).collect()
}

/// Every harmonic of pressure and flow in the middle of every vessel, within 1e-9 of the largest of the network.
#[test]
fn the_linear_theory_of_another_program() {
    let Some(folder) = folder() else { return };
    let cases = [
        ("cca", "womersley", Friction::Womersley),
        ("cca", "parabolic", Friction::Parabolic),
        ("ibif", "womersley", Friction::Womersley),
        ("ibif", "parabolic", Friction::Parabolic),
        ("circle", "womersley", Friction::Womersley),
    ];
    for (name, word, friction) in cases {
        let reference = json(&folder, &format!("linear-{name}-{word}.json"));
        let (network, pulse) = openbf(&folder, name, friction, 20);
        let scale = ml_per_min(pulse.largest_flow);
        let mut compared = 0;
        for (label, vessel) in reference["vessels"].as_object().expect("vessels") {
            let row = (0..network.vessel_count()).find(|row| network.vessel(*row).label == *label);
            let Some(row) = row else { continue };
            let found = &pulse.vessels[row];
            let pressure = found.pressure.as_ref().expect("a pressure");
            for (n, q) in complex(&vessel["flow_mL_per_min"]).into_iter().enumerate() {
                let got = found.flow[1][n] * ml_per_min(1.0);
                assert!((got - q).norm() <= 1e-9 * scale, "{name} {word} {label} Q{n}: {got} for {q}");
            }
            for (n, p) in complex(&vessel["pressure_mmHg"]).into_iter().enumerate() {
                let got = pressure[n] * mmhg(1.0);
                assert!((got - p).norm() <= 1e-9 * mmhg(pressure[0].re), "{name} {word} {label} P{n}: {got} for {p}");
            }
            compared += 1;
        }
        assert!(compared > 0 && (name == "circle" || compared == network.vessel_count()), "{name}: {compared} vessels");
    }
}

/// The circles that ship, with a carotid pressure at every inlet: indices of sampled waveforms to 1e-6, harmonics to 1e-9.
#[test]
fn the_circles_of_another_program() {
    let Some(folder) = folder() else { return };
    let reference = json(&folder, "pulse-circles.json");
    for (name, vessels) in reference.as_object().expect("circles") {
        let path = PathBuf::from(format!("{}/data/circle-of-willis/{name}.graphml", env!("CARGO_MANIFEST_DIR")));
        let waveform = folder.join("carotid-pressure.csv").to_str().expect("UTF-8").to_owned();
        let options = PulseOptions { waveforms: vec![waveform], harmonics: 20, ..PulseOptions::default() };
        let (network, pulses) = solve(&path, options, 3.5e-3);
        let columns = willis::internals::report::pulse_vessel_columns(&pulses);
        let scale = ml_per_min(pulses.both.unperturbed.largest_flow);
        for row in 0..network.vessel_count() {
            let label = network.vessel(row).label.as_str();
            let expected = &vessels[label];
            for (n, q) in complex(&expected["flow_harmonics_mL_per_min"]).into_iter().enumerate() {
                let got = pulses.both.unperturbed.vessels[row].flow[1][n] * ml_per_min(1.0);
                assert!((got - q).norm() <= 1e-9 * scale, "{name} {label} Q{n}: {got} for {q}");
            }
            for column in &columns {
                let willis::internals::formats::Values::Real(values) = &column.values else { continue };
                let Some(value) = expected.get(column.name.as_ref()) else { continue };
                match value.as_f64() {
                    None => assert!(values[row].is_nan(), "{name} {label} {}: {}", column.name, values[row]),
                    Some(x) => {
                        let close = (values[row] - x).abs() <= 1e-6 * x.abs().max(1.0);
                        assert!(close, "{name} {label} {}: {} for {x}", column.name, values[row]);
                    }
                }
            }
        }
    }
}

/// A table of waveforms by column.
fn table(path: PathBuf) -> (Vec<String>, Vec<Vec<f64>>) {
    let text = std::fs::read_to_string(path).expect("a table");
    let mut lines = text.lines();
    let names: Vec<String> = lines.next().expect("a header").split(',').map(str::to_owned).collect();
    let mut columns = vec![Vec::new(); names.len()];
    for line in lines {
        line.split(',').zip(&mut columns).for_each(|(x, column)| column.push(x.parse().expect("a number")));
    }
    (names, columns)
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

/// The error of the linear theory against openBF: RMS of Q over the largest |Q| as in Boileau et al. 2015, median and worst vessel in %,
/// PCoA and ACoA apart; the limits are those of the reference's own comparison, rounded up.
#[test]
fn openbf_within_what_the_linear_theory_leaves_out() {
    let Some(folder) = folder() else { return };
    let cases = [
        ("cca", Friction::Womersley, 0.5, 0.5, 0.0),
        ("cca", Friction::Parabolic, 0.5, 0.5, 0.0),
        ("ibif", Friction::Womersley, 1.0, 1.0, 0.0),
        ("circle", Friction::Womersley, 4.0, 18.0, 30.0),
        ("circle", Friction::Parabolic, 4.0, 10.0, 22.0),
    ];
    for (name, friction, median, worst, communicating) in cases {
        let (network, pulse) = openbf(&folder, name, friction, 40);
        let (names, columns) = table(folder.join(format!("openbf-{name}.waveforms.csv")));
        let mut errors = Vec::new();
        for row in 0..network.vessel_count() {
            let label = &network.vessel(row).label;
            let column = |what: &str| names.iter().position(|name| *name == format!("{label}:{what}")).map(|at| &columns[at]);
            let (Some(p), Some(q)) = (column("pressure_mmHg"), column("flow_mL_per_min")) else { continue };
            let found: Vec<f64> = samples(&pulse.vessels[row].flow[1], q.len()).into_iter().map(ml_per_min).collect();
            let error = 100.0 * rms(&found, q) / q.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let mean = q.iter().sum::<f64>() / q.len() as f64;
            let off = (ml_per_min(pulse.vessels[row].flow[1][0].re) - mean).abs();
            if label.contains("CoA") {
                assert!(error <= communicating, "{name} {label}: {error} %");
                assert!(off < 0.2, "{name} {label}: mean off by {off} mL/min");
                let reversed = |flow: &[f64]| {
                    let all: f64 = flow.iter().map(|x| x.abs()).sum();
                    flow.iter().map(|x| (-x * mean.signum()).max(0.0)).sum::<f64>() / all
                };
                let (theirs, ours) = (reversed(q), reversed(&found));
                // The NumPy reference is off by 0.04 with Womersley's profile, by 0.10 with a parabola.
                let within = if friction == Friction::Womersley { 0.05 } else { 0.11 };
                assert!(
                    theirs > 0.05 && ours > 0.05 && (theirs - ours).abs() < within,
                    "{name} {label}: reversed {ours} for {theirs}"
                );
            } else {
                errors.push(error);
                assert!(off < 0.012 * mean.abs(), "{name} {label}: mean off by {off} of {mean} mL/min");
                let pressure = pulse.vessels[row].pressure.as_ref().expect("a pressure");
                let found: Vec<f64> = samples(pressure, p.len()).into_iter().map(mmhg).collect();
                let relative: Vec<f64> = found.iter().zip(p).map(|(a, b)| a / b).collect();
                let error = 100.0 * rms(&relative, &vec![1.0; p.len()]);
                assert!(error < 3.3, "{name} {label}: pressure off by {error} %");
                let swing = |x: &[f64]| x.iter().copied().fold(f64::MIN, f64::max) - x.iter().copied().fold(f64::MAX, f64::min);
                let flow: Vec<f64> = samples(&pulse.vessels[row].flow[1], q.len()).into_iter().map(ml_per_min).collect();
                let index = swing(&flow) / flow.iter().sum::<f64>().abs();
                let theirs = swing(q) / q.iter().sum::<f64>().abs();
                assert!((index / theirs - 1.0).abs() < 0.115, "{name} {label}: PI {index} for {theirs}");
            }
        }
        errors.sort_by(f64::total_cmp);
        let (middle, most) = (errors[errors.len() / 2], errors[errors.len() - 1]);
        println!("{name} {friction:?}: RMS of Q, median {middle:.2} %, worst {most:.2} %");
        assert!(middle <= median && most <= worst, "{name}: {middle} and {most} %");
    }
}

fn reals(value: &Value) -> Vec<f64> {
    value.as_array().expect("numbers").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// A row of two columns as a waveform: values in any unit, taken as SI.
fn wave(times: &[f64], values: &[f64]) -> willis::internals::network::waveform::Waveform {
    let quantity = willis::internals::network::waveform::Quantity::Flow;
    willis::internals::network::waveform::Waveform { quantity, times: times.to_vec(), values: values.to_vec() }
}

/// svZeroDSolver, its consistent units taken as SI: a resistance before an RCR, and the element of C, R and L.
#[test]
fn svzerodsolver() {
    let Some(folder) = folder() else { return };
    let condition = |case: &Value, name: &str| {
        let all = case["boundary_conditions"].as_array().expect("conditions");
        all.iter().find(|c| c["bc_name"] == name).expect("it")["bc_values"].clone()
    };
    let weightless = Fluid { viscosity: 1.0, density: 0.0, friction: Friction::Parabolic, ..BLOOD };
    // R = 8µl/(πr⁴).
    let resistor = |r: f64| tube(1000.0, 1000.0 * (8.0 / (std::f64::consts::PI * r)).powf(0.25));

    let case = json(&folder, "svzerod-R_RCR.json");
    let (inflow, out) = (condition(&case, "INFLOW"), condition(&case, "OUT"));
    let number = |key: &str| out[key].as_f64().expect("a number");
    let mut line = network(2, [([0, 1], resistor(100.0))]);
    line.node_mut(1).windkessel = Windkessel { proximal: Some(number("Rp")), compliance: Some(number("C")) }.stated();
    let q = coefficients(&wave(&reals(&inflow["t"]), &reals(&inflow["Q"])), 1.0, 200);
    let behind = Condition::Resistance { resistance: number("Rp") + number("Rd"), venous: number("Pd") };
    let conditions = [(0, Condition::Flow(q[0].re)), (1, behind)];
    let case = Case { law: WallLaw::Rigid, fluid: weightless, ..Case::new(&line, &conditions, vec![flow(0, &q)]) };
    let pulse = case.solve();
    let (_, columns) = table(folder.join("svzerod-R_RCR.result.csv"));
    for (node, column) in [(0, 2), (1, 3)] {
        let theirs = &columns[column];
        let whole = if theirs.len() % 2 == 1 { theirs.len() - 1 } else { theirs.len() };
        let ours = samples(pulse.pressure[node].as_ref().expect("a pressure"), whole);
        let most = theirs.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        for (a, b) in ours.iter().zip(theirs) {
            assert!((a - b).abs() <= 5e-4 * most, "R_RCR node {node}: {a} for {b}");
        }
    }

    let case = json(&folder, "svzerod-CRL.json");
    let period = case["simulation_parameters"]["cardiac_period"].as_f64().expect("a period");
    let (inlet, out) = (condition(&case, "IN"), condition(&case, "OUT"));
    let p = coefficients(&wave(&reals(&inlet["t"]), &reals(&inlet["P"])), period, 5);
    let q = coefficients(&wave(&reals(&out["t"]), &reals(&out["Q"])), period, 5);
    let line = network(2, [([0, 1], resistor(1.0))]);
    let conditions = [(0, Condition::Pressure(p[0].re)), (1, Condition::Flow(-q[0].re))];
    let leaving: Vec<Complex64> = q.iter().map(|q| -q).collect();
    let drives = vec![pressure_wave(0, &p), flow(1, &leaving)];
    let pulse = Case { law: WallLaw::Rigid, fluid: weightless, period, ..Case::new(&line, &conditions, drives) }.solve();
    let (_, columns) = table(folder.join("svzerod-CRL.result.csv"));
    // C = 1 lies before the tube, at the inlet.
    let stored = |n: usize| p[n] * Complex64::new(0.0, std::f64::consts::TAU * n as f64 / period);
    let entering: Vec<Complex64> = (0..6).map(|n| pulse.vessels[0].flow[0][n] + stored(n)).collect();
    let behind = pulse.pressure[1].clone().expect("a pressure");
    for (ours, column) in [(entering, 1), (behind, 4)] {
        for (t, theirs) in columns[0].iter().zip(&columns[column]) {
            let turn = |n: usize| Complex64::cis(std::f64::consts::TAU * n as f64 * t / period);
            let value: f64 = ours.iter().enumerate().map(|(n, c)| (c * turn(n)).re).sum();
            assert!((value - theirs).abs() <= 5e-4 * 1.5, "CRL column {column} at {t}: {value} for {theirs}");
        }
    }
}

/// No wave reaches a node before it leaves an inlet, and it reaches a node later than those that it passes.
#[test]
fn nothing_arrives_before_it_leaves() {
    let Some(folder) = folder() else { return };
    let wave = read_waveform(&std::fs::read(folder.join("carotid-pressure.csv")).expect("a file")).expect("a waveform").0;
    let c = coefficients(&wave, wave.own_period(), 40);
    let line = network(6, (0..5).map(|k| ([k, k + 1], tube(60.0, 2.0 - 0.2 * k as f64))));
    let conditions = [(0, Condition::Pressure(c[0].re)), (5, Condition::Resistance { resistance: 5e9, venous: 0.0 })];
    let pulse = Case { period: wave.own_period(), ..Case::new(&line, &conditions, vec![pressure_wave(0, &c)]) }.solve();
    let foot = |node: usize| pulse.arrivals.nodes[node];
    for node in 1..6 {
        assert!(foot(node) > foot(node - 1), "{node}: {} s after {} s", foot(node), foot(node - 1));
    }
    // About 8 to 9 m/s along 300 mm.
    assert!((0.02..0.06).contains(&(foot(5) - foot(0))), "{}", foot(5) - foot(0));
}

/// The shapes that ship are those of the model that they name, in the middle of the left internal carotid and of the right vertebral artery,
/// to the four decimals that are written down.
#[test]
fn typical_shapes_are_those_of_their_model() {
    let Some(folder) = folder() else { return };
    let (network, pulse) = openbf(&folder, "circle", Friction::Womersley, 40);
    for (typical, label) in [(Typical::Carotid, "11-L-int-carotidI"), (Typical::Vertebral, "14-R-vertebral")] {
        let row = (0..network.vessel_count()).find(|row| network.vessel(*row).label == label).expect("the artery");
        let flow = &pulse.vessels[row].flow[1];
        for (n, (known, found)) in typical.shape(10).iter().zip(flow).enumerate() {
            let found = found / flow[0];
            assert!((known - found).norm() < 1e-4, "{label}, harmonic {n}: {known} for {found}");
        }
    }
}

/// On the circles that ship, whole and without arteries, with a pressure, a flow and the typical flows at the inlets: no pulse before that of the
/// earliest inlet, at each node but the inlets one that took time from a node beside it, and figures within their bounds.
#[test]
fn figures_of_circles_are_possible() {
    let here = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/data/circle-of-willis"));
    let scratch = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = scratch.path().join(name);
        std::fs::write(&path, text).expect("written");
        path.to_str().expect("UTF-8").to_owned()
    };
    let pressure = write("p.csv", "time_s,pressure_mmHg\n0,80\n0.15,122\n0.35,102\n0.42,104\n0.9,80\n");
    let flow = write("q.csv", "time_s,flow_mL_per_min\n0,150\n0.1,400\n0.25,250\n0.3,280\n0.9,150\n");
    let mut circles = 0;
    for path in std::fs::read_dir(here).expect("circles").map(|entry| entry.expect("a file").path()) {
        circles += 1;
        for waveform in [pressure.clone(), flow.clone(), "typical".to_owned()] {
            let name = format!("{} {waveform}", path.display());
            let (network, pulses) = solve(&path, PulseOptions { waveforms: vec![waveform], ..PulseOptions::default() }, 3.5e-3);
            let arrivals = &pulses.both.unperturbed.arrivals;
            let inlets = (0..network.node_count()).filter(|node| network.node(*node).role == Some(Role::Inlet));
            let earliest = inlets.map(|node| arrivals.nodes[node]).fold(f64::INFINITY, f64::min);
            assert_eq!(earliest, arrivals.first, "{name}");
            for foot in arrivals.nodes.iter().chain(&arrivals.vessels) {
                assert!((0.0..0.3).contains(&(foot - earliest)), "{name}: {foot} s beside {earliest} s");
            }
            for node in (0..network.node_count()).filter(|node| network.node(*node).role != Some(Role::Inlet)) {
                let beside = network.vessels().map(|(ends, _)| ends).filter(|ends| ends.contains(&node)).flatten();
                let first = beside.map(|node| arrivals.nodes[node]).fold(f64::INFINITY, f64::min);
                assert!(arrivals.nodes[node] > first, "{name}: node {node}: {} s, not after {first} s", arrivals.nodes[node]);
            }
            for column in willis::internals::report::pulse_vessel_columns(&pulses) {
                let willis::internals::formats::Values::Real(values) = &column.values else { continue };
                let (low, high) = match column.name.as_ref() {
                    "reversed_share" | "oscillatory_shear_index" => (0.0, 0.5),
                    "pulsatility_index"
                    | "resistive_index"
                    | "reversed_volume_ratio"
                    | "pulse_arrival_ms"
                    | "wall_shear_mean_Pa" => (0.0, f64::INFINITY),
                    _ => continue,
                };
                // Without a mean there is no index.
                let possible = |x: &&f64| !(x.is_nan() || (low..=high).contains(*x));
                let wrong = values.iter().find(possible);
                assert!(wrong.is_none(), "{name}: {} {wrong:?}", column.name);
            }
        }
    }
    assert!(circles >= 11, "{circles} circles");
}
