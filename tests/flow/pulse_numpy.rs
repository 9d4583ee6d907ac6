//! The pulse and the transport against two NumPy programs that are run here: every circle that ships, every variant that a phantom can
//! leave segments out of, and random networks with random waveforms and walls. Without those programs the tests say that they are skipped.

use std::io::Write;
use std::process::{Command, Stdio};

use num_complex::Complex64;
use serde_json::{Value, json};
use willis::internals::flow::{Thickness, WallLaw};
use willis::internals::formats::read_waveform;
use willis::internals::network::waveform::{Quantity, Waveform};
use willis::internals::network::{Condition, Network, Wall};
use willis::internals::phantom::{Anatomy, Recipe, without};
use willis::internals::simulation::pulse::fourier::coefficients;
use willis::internals::simulation::pulse::womersley::Fluid;
use willis::internals::simulation::pulse::{Drive, Friction, Pulse};
use willis::internals::simulation::simulate;
use willis::internals::simulation::transport::{Transport, Transports};
use willis::{FlowOptions, PulseOptions, ReadOptions};

use crate::draw::Draw;
use crate::networks::{VISCOSITY, boundary, log_radii, random_conditions, random_network};
use crate::pulse_case::Case;
use crate::python_oracle::oracle;

/// Reads one case a line and prints what the two programs say of it. Compliances, R1 of matched outlets and Fourier coefficients are
/// worked out here from radii, laws and points, not taken over.
const SCRIPT: &str = r#"
import importlib.util, json, sys
import numpy as np
def load(path):
    spec = importlib.util.spec_from_file_location(path.rsplit("/", 1)[1][:-3] + "_reference", path)
    module = importlib.util.module_from_spec(spec); spec.loader.exec_module(module); return module
pulse, blood = load(sys.argv[1]), load(sys.argv[1].replace("pulsatile.py", "transport.py"))
pairs = lambda x: [[[c.real, c.imag] for c in row] for row in x]
clean = lambda x: [None if not np.isfinite(v) else float(v) for v in x]
for line in sys.stdin:
    case = json.loads(line)
    a, b, l, r = (np.array(case[key]) for key in "ablr")
    rho, mu, H, T = case["rho"], case["mu"], case["harmonics"], case["period"]
    law, x = case["wall"]
    c = {"olufsen": lambda: pulse.compliance_eh(r, pulse.eh_olufsen(r)), "eh": lambda: pulse.compliance_eh(r, x), "share": lambda: pulse.compliance_eh(r, x[0] * x[1] * r),
         "pwv": lambda: pulse.compliance_pwv(r, np.array(x), rho), "rigid": lambda: 0 * r}[law]()
    area = np.pi * r**2
    with np.errstate(divide="ignore"):
        y0 = np.where(c > 0, area / (rho * np.sqrt(area / (rho * np.where(c > 0, c, 1)))), 0)
    inlets, outlets = {}, {}
    for j, kind, value in case["conditions"]:
        if kind == "resistance":
            R, pv = value
            at = y0[a == j].sum() + y0[b == j].sum()
            r1 = R if case["rc"] is None else min(R, 1 / at if at > 0 else np.inf)
            outlets[j] = (r1, R - r1, 0 if case["rc"] is None else case["rc"] / R, pv)
        else:
            inlets[j] = (kind, np.array([value] + [0] * H, complex))
    for j, kind, t, f in case["drives"]:
        inlets[j] = (kind, pulse.fourier(t, f, T, H))
    s = pulse.solve(a, b, l, r, c, inlets, outlets, T, H, mu=mu, rho=rho, phi=case["phi"], profile=case["profile"], nodes=case["nodes"])
    m = blood.transport(a, b, s["Qm"][:, 0].real if case.get("q") is None else case["q"], area * l, case["nodes"])
    print(json.dumps(dict({k: pairs(s[k]) for k in ("P", "Pm", "Qa", "Qm", "Qb")}, source=m["source"].tolist(), supply=[clean(x) for x in m["supply"]],
                          mean=clean(m["mean"]), sd=clean(m["sd"]), first=clean(m["first"]), through=clean(m["through"]), by_source=[clean(x) for x in m["mean_of_source"]])))
"#;

/// One case: the input of the two programs, and what willis found.
struct Compared {
    name: String,
    told: Value,
    pulse: Pulse,
    transport: Transport,
}

fn wall(law: &WallLaw, network: &Network) -> Value {
    match law {
        WallLaw::Olufsen { .. } => json!(["olufsen", null]),
        WallLaw::Stiffness(stiffness) => json!(["eh", stiffness]),
        WallLaw::Elastic { young, thickness: Thickness::OfRadius(share) } => json!(["share", [young, share]]),
        WallLaw::Elastic { young, thickness: Thickness::Length(length) } => json!(["eh", young * length]),
        WallLaw::Speed(speed) => json!(["pwv", vec![speed; network.vessel_count()]]),
        WallLaw::Rigid => json!(["rigid", null]),
        WallLaw::Stated => {
            let speed = |(_, vessel): ([usize; 2], &willis::internals::network::Vessel)| match vessel.wall {
                Some(Wall::Speed(speed)) => speed,
                other => panic!("the wall {other:?}"),
            };
            json!(["pwv", network.vessels().map(speed).collect::<Vec<f64>>()])
        }
    }
}

/// The input of the two programs for a case; waves as points.
fn told(case: &Case, waves: &[(usize, Waveform)]) -> Value {
    let network = case.network;
    let column = |of: &dyn Fn([usize; 2], &willis::internals::network::Vessel) -> Value| -> Vec<Value> {
        network.vessels().map(|(ends, vessel)| of(ends, vessel)).collect()
    };
    let conditions = case.conditions.iter().map(|(node, condition)| match condition {
        Condition::Pressure(p) => json!([node, "pressure", p]),
        Condition::Flow(q) => json!([node, "flow", q]),
        Condition::Resistance { resistance, venous } => json!([node, "resistance", [resistance, venous]]),
    });
    let kind = |quantity| if quantity == Quantity::Pressure { "pressure" } else { "flow" };
    json!({
        "a": column(&|ends, _| json!(ends[0])), "b": column(&|ends, _| json!(ends[1])),
        "l": column(&|_, vessel| json!(vessel.length)), "r": column(&|_, vessel| json!(vessel.radius)),
        "rho": case.fluid.density, "mu": case.fluid.viscosity, "phi": case.fluid.wall_viscosity,
        "profile": if case.fluid.friction == Friction::Parabolic { json!(2) } else { Value::Null },
        "harmonics": case.drives[0].coefficients.len() - 1, "period": case.period, "rc": case.time_constant,
        "nodes": network.node_count(), "wall": wall(&case.law, network), "conditions": conditions.collect::<Vec<Value>>(),
        "drives": waves.iter().map(|(node, w)| json!([node, kind(w.quantity), w.times, w.values])).collect::<Vec<Value>>(),
    })
}

impl Compared {
    /// A case whose drives are the waves.
    fn of(name: String, case: &Case, waves: &[(usize, Waveform)]) -> Self {
        let boundary = boundary(case.network, case.conditions);
        let steady = simulate(case.network, &boundary, case.fluid.viscosity, &[]).expect("a flow");
        let transport = Transports::of(case.network, &boundary, &steady);
        Self { name, told: told(case, waves), pulse: case.solve(), transport: transport.unperturbed }
    }
}

/// The worst differences of a group of cases.
#[derive(Default)]
struct Worst {
    /// Of flows, over the largest of the network; of pressures, over the largest mean; of shares; of times, over the mean time there.
    figures: [f64; 4],
    nodes: usize,
}

impl Worst {
    fn note(&mut self, at: usize, difference: f64, what: &str) {
        assert!(difference <= 1e-9, "{what}: off by {difference:e}");
        self.figures[at] = self.figures[at].max(difference);
    }

    fn compare(&mut self, case: &Compared, known: &Value) {
        let complex = |c: &Value| Complex64::new(c[0].as_f64().expect("re"), c[1].as_f64().expect("im"));
        let (largest, name) = (case.pulse.largest_flow, &case.name);
        let highest = case.pulse.pressure.iter().flatten().map(|p| p[0].re.abs()).fold(0.0, f64::max);
        for (row, vessel) in case.pulse.vessels.iter().enumerate() {
            for (key, found) in ["Qa", "Qm", "Qb"].into_iter().zip(&vessel.flow) {
                for (n, q) in found.iter().enumerate() {
                    let off = (q - complex(&known[key][row][n])).norm() / largest;
                    self.note(0, off, &format!("{name}, vessel {row}, {key}{n}"));
                }
            }
            for (n, p) in vessel.pressure.iter().flatten().enumerate() {
                self.note(1, (p - complex(&known["Pm"][row][n])).norm() / highest, &format!("{name}, vessel {row}, P{n}"));
            }
        }
        for (node, pressure) in case.pulse.pressure.iter().enumerate() {
            for (n, p) in pressure.iter().flatten().enumerate() {
                self.note(1, (p - complex(&known["P"][node][n])).norm() / highest, &format!("{name}, node {node}, P{n}"));
            }
        }
        let number = |key: &str, node: usize| known[key][node].as_f64();
        // What trickles is a difference of pressures that are nearly equal: it has fewer digits in either program.
        let trickle = 1e-5 * case.transport.inflow.iter().sum::<f64>();
        let column = |source: usize| known["source"].as_array().expect("sources").iter().position(|s| *s == json!(source));
        for node in 0..case.transport.nodes.len() {
            let Some(blood) = case.transport.nodes[node].as_ref().filter(|blood| blood.through > trickle) else {
                assert!(number("through", node).is_none_or(|through| through <= 2.0 * trickle), "{name}, node {node}");
                continue;
            };
            let what = format!("{name}, blood at node {node}");
            let relative = |found: f64, key: &str| (found / number(key, node).expect("a number") - 1.0).abs();
            self.note(3, relative(blood.through, "through"), &what);
            for (at, source) in case.transport.sources.iter().enumerate() {
                let at_known = column(*source);
                let known_share = at_known.map_or(0.0, |k| known["supply"][node][k].as_f64().expect("a share"));
                self.note(2, (blood.supply[at] - known_share).abs(), &what);
                // Weighed by the share: the time of a source that hardly sends anything has the digits of its trickle.
                if known_share > 1e-9 && blood.mean > 0.0 {
                    let mean = known["by_source"][node][at_known.expect("it")].as_f64().expect("a time");
                    let off = blood.supply[at] * blood.mean_of_source[at] - known_share * mean;
                    self.note(3, off.abs() / blood.mean, &what);
                }
            }
            if blood.mean > 0.0 {
                self.note(3, relative(blood.mean, "mean"), &what);
                self.note(3, (blood.variance.sqrt() - number("sd", node).expect("a spread")).abs() / blood.mean, &what);
                self.note(3, (blood.first - number("first", node).expect("a time")).abs() / blood.mean, &what);
            }
            self.nodes += 1;
        }
    }
}

/// Asks the programs about all cases and compares.
fn compare(cases: &[Compared], python: &str, script: &str) {
    let mut child = Command::new(python)
        .args(["-c", SCRIPT, script])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("python starts");
    let lines: Vec<String> = cases.iter().map(|case| case.told.to_string()).collect();
    let mut input = child.stdin.take().expect("its input");
    let writer = std::thread::spawn(move || lines.iter().try_for_each(|line| writeln!(input, "{line}")));
    let output = child.wait_with_output().expect("python ends");
    writer.join().expect("no panic").expect("written");
    assert!(output.status.success(), "the NumPy program ends");
    let said = String::from_utf8(output.stdout).expect("text");
    assert_eq!(said.lines().count(), cases.len());
    let mut worst = Worst::default();
    for (case, line) in cases.iter().zip(said.lines()) {
        worst.compare(case, &serde_json::from_str(line).expect("JSON"));
    }
    assert!(worst.nodes >= 4 * cases.len(), "blood at {} nodes", worst.nodes);
    let [flow, pressure, share, time] = worst.figures;
    println!("{} cases: flow {flow:.1e}, pressure {pressure:.1e}, shares {share:.1e}, times {time:.1e}", cases.len());
}

/// A carotid pressure of 80 to 122 mmHg over 0.9 s, as a table.
const CAROTID: &str = "time_s,pressure_mmHg\n0,80\n0.15,122\n0.35,102\n0.42,104\n0.9,80\n";

/// Nodes with the waves that drive them.
type Waves = Vec<(usize, Waveform)>;

/// The conditions that a network states, with the mean of a wave at every inlet, and the waves.
fn driven(network: &Network, wave: &Waveform) -> (Vec<(usize, Condition)>, Waves) {
    let mean = coefficients(wave, wave.own_period(), 1)[0].re;
    let stated = network.nodes().enumerate().filter_map(|(node, stated)| Some((node, stated.condition?)));
    let is_inlet = |condition: &Condition| matches!(condition, Condition::Pressure(p) if *p > 0.0);
    let stated: Vec<(usize, Condition)> = stated.collect();
    let waves = stated.iter().filter(|(_, c)| is_inlet(c)).map(|(node, _)| (*node, wave.clone())).collect();
    let mean = |(node, c): &(usize, Condition)| (*node, if is_inlet(c) { Condition::Pressure(mean) } else { *c });
    (stated.iter().map(mean).collect(), waves)
}

fn drives(waves: &[(usize, Waveform)], period: f64, harmonics: usize) -> Vec<Drive> {
    let drive = |(node, wave): &(usize, Waveform)| Drive {
        node: *node,
        quantity: wave.quantity,
        coefficients: coefficients(wave, period, harmonics),
    };
    waves.iter().map(drive).collect()
}

/// A circle with the carotid pressure at every inlet.
fn circle(name: &str, network: &Network) -> Compared {
    let wave = read_waveform(CAROTID.as_bytes()).expect("a waveform").0;
    let (conditions, waves) = driven(network, &wave);
    let period = wave.own_period();
    let case = Case { period, ..Case::new(network, &conditions, drives(&waves, period, 20)) };
    Compared::of(name.to_owned(), &case, &waves)
}

/// Every file of data/circle-of-willis by the front door, with the carotid pressure at every inlet.
#[test]
fn every_circle_that_ships() {
    let Some((script, python)) = oracle("pulsatile.py") else { return };
    let here = tempfile::tempdir().expect("a temporary folder");
    let table = here.path().join("carotid.csv");
    std::fs::write(&table, CAROTID).expect("written");
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/data/circle-of-willis");
    let mut files: Vec<_> = std::fs::read_dir(folder).expect("the circles").map(|f| f.expect("a file").path()).collect();
    files.sort();
    assert_eq!(files.len(), 11, "{files:?}");
    let cases: Vec<Compared> = files
        .iter()
        .map(|file| {
            let input = willis::read(file, &ReadOptions::default()).expect("a circle");
            let waveforms = vec![table.to_str().expect("UTF-8").to_owned()];
            let pulse = PulseOptions { waveforms, harmonics: 20, ..PulseOptions::default() };
            let options = FlowOptions { pulse: Some(pulse), transport: true, ..FlowOptions::default() };
            let run = willis::simulate(&input, &[], &options).expect("a flow");
            let stated = circle(&file.display().to_string(), &input.network);
            let pulse = run.pulses.as_ref().expect("it was asked for").0.both.unperturbed.clone();
            Compared { pulse, transport: run.transports.as_ref().expect("it was asked for").unperturbed.clone(), ..stated }
        })
        .collect();
    compare(&cases, &python, &script);
}

/// The segments that people lack.
const SEGMENTS: [&str; 7] = ["L-A1", "R-A1", "AComm", "L-P1", "R-P1", "L-PComm", "R-PComm"];

/// Every set of the seven segments that people lack, fetal circles among them, and the whole tree from the heart.
#[test]
fn every_variant_of_a_phantom() {
    let Some((script, python)) = oracle("pulsatile.py") else { return };
    let network = |kind: Anatomy| kind.network(&Recipe::default()).expect("a phantom");
    let (whole, heart) = (network(Anatomy::Cerebral), network(Anatomy::CircleOfWillis));
    let mut cases = vec![circle("from the heart", &heart)];
    for set in 0..1_usize << SEGMENTS.len() {
        let missing: Vec<&str> = SEGMENTS.iter().enumerate().filter(|(k, _)| set >> k & 1 == 1).map(|(_, s)| *s).collect();
        let variant = if missing.is_empty() { whole.clone() } else { without(&whole, &missing).expect("a variant") };
        cases.push(circle(&format!("without {missing:?}"), &variant));
    }
    compare(&cases, &python, &script);
}

/// A random periodic signal through up to 30 points, now and then with a step, whose mean is some value.
fn random_wave(draw: &mut Draw, quantity: Quantity, mean: f64, period: f64) -> Waveform {
    let count = 3 + draw.below(28);
    let mut times: Vec<f64> = (0..count).map(|_| draw.within(0.0, period)).collect();
    times.sort_by(f64::total_cmp);
    if draw.below(2) == 0 {
        times[count / 2] = times[count / 2 - 1];
    }
    let values: Vec<f64> = (0..count).map(|_| mean * draw.within(0.4, 1.8)).collect();
    Waveform { quantity, times, values }
}

/// Networks of up to 60 nodes with dead ends, parallel vessels, injected flows, several waves of pressure and flow, and every law of walls.
/// The blood follows the flows of willis in both programs: against 40 digits those are exact to 6e-15 in such a network, where a dense
/// solution in doubles leaves a trickle between nearly equal pressures, and so its time, 8 digits.
#[test]
fn random_networks_with_random_waves_and_walls() {
    let Some((script, python)) = oracle("pulsatile.py") else { return };
    let mut draw = Draw::new(26);
    let mut cases = Vec::new();
    for round in 0..120 {
        let nodes = 6 + draw.below(55);
        let mut network = random_network(&mut draw, nodes, nodes + nodes / 2, log_radii(0.5, 3.0));
        for row in 0..network.vessel_count() {
            network.vessel_mut(row).wall = Some(Wall::Speed(draw.within(4.0, 18.0)));
        }
        let period = draw.within(0.5, 1.4);
        let harmonics = 1 + draw.below(40);
        let mut conditions = random_conditions(&mut draw, nodes);
        let mut waves = Vec::new();
        for (node, condition) in &mut conditions {
            let (quantity, mean) = match condition {
                Condition::Pressure(p) if *p > 0.0 => (Quantity::Pressure, *p),
                Condition::Flow(q) => (Quantity::Flow, *q),
                _ => continue,
            };
            // Some conditions stay as they are: a fixed pressure, or an end closed to the pulse.
            if !waves.is_empty() && draw.below(3) == 0 {
                continue;
            }
            let wave = random_wave(&mut draw, quantity, mean, period);
            let mean = coefficients(&wave, period, 1)[0].re;
            *condition = if quantity == Quantity::Pressure { Condition::Pressure(mean) } else { Condition::Flow(mean) };
            waves.push((*node, wave));
        }
        let law = match round % 6 {
            0 => WallLaw::OLUFSEN,
            1 => WallLaw::Stiffness(draw.within(50.0, 400.0)),
            2 => WallLaw::Speed(draw.within(4.0, 15.0)),
            3 => WallLaw::Elastic { young: draw.within(2e5, 2e6), thickness: Thickness::OfRadius(draw.within(0.05, 0.3)) },
            4 => WallLaw::Stated,
            _ => WallLaw::Rigid,
        };
        let friction = if draw.below(2) == 0 { Friction::Womersley } else { Friction::Parabolic };
        let wall_viscosity = if draw.below(2) == 0 { 0.0 } else { draw.within(0.0, 0.02) };
        let fluid = Fluid { density: draw.within(1000.0, 1100.0), friction, wall_viscosity, viscosity: VISCOSITY };
        let time_constant = if draw.below(4) == 0 { None } else { Some(draw.within(0.2, 1.5)) };
        let drives = drives(&waves, period, harmonics);
        let case = Case { law, fluid, time_constant, period, ..Case::new(&network, &conditions, drives) };
        let mut compared = Compared::of(format!("round {round}"), &case, &waves);
        compared.told["q"] = compared.pulse.vessels.iter().map(|vessel| json!(vessel.flow[1][0].re)).collect();
        cases.push(compared);
    }
    compare(&cases, &python, &script);
}
