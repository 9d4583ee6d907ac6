//! Steady flow against svZeroDSolver (SimVascular): its cases with an analytic solution, and the cycle means of its pulsatile solutions
//! of three networks traced in patients. Its figures come in one consistent system of units and are taken as if they were SI.

use std::path::PathBuf;

use crate::networks::{VISCOSITY, boundary};
use crate::vessels::{network, tube};
use serde_json::Value;
use willis::internals::flow::Tube;
use willis::internals::flow::state::State;
use willis::internals::network::{Condition, Network, Vessel};

/// Largest error of a steady case, relative. svZeroDSolver iterates to 1e-9 in absolute terms, on figures of 1 to 10,000.
const STEADY: f64 = 1e-9;

fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/svzerod-verification"));
    if !folder.is_dir() {
        println!("skipped: {} is not there", folder.display());
        return None;
    }
    Some(folder)
}

/// One of its models: vessels by name, in the order of the file.
struct Model {
    names: Vec<String>,
    /// Node at the inlet and at the outlet.
    ends: Vec<[usize; 2]>,
    resistance: Vec<f64>,
    /// S of the term S·|Q|·Q that a stenosis adds to the drop.
    stenosis: Vec<f64>,
    nodes: usize,
    conditions: Vec<(usize, Condition)>,
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("{key} of {value}"))
}

fn rows<'a>(value: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> {
    value[key].as_array().into_iter().flatten()
}

fn reals(value: &Value, key: &str) -> Vec<f64> {
    rows(value, key).map(|x| x.as_f64().unwrap()).collect()
}

/// The mean over the cycle by the trapezoid rule.
fn mean(values: &Value, key: &str) -> f64 {
    let (x, t) = (reals(values, key), reals(values, "t"));
    let area: f64 = x.windows(2).zip(t.windows(2)).map(|(x, t)| f64::midpoint(x[0], x[1]) * (t[1] - t[0])).sum();
    area / (t[t.len() - 1] - t[0])
}

/// What holds at an end on average: a capacitance carries no mean flow, so the two resistances of an RCR are in series.
fn condition(of: &Value) -> Condition {
    let values = &of["bc_values"];
    let resistance = |resistance| Condition::Resistance { resistance, venous: number(values, "Pd") };
    match of["bc_type"].as_str() {
        Some("FLOW") => Condition::Flow(mean(values, "Q")),
        Some("PRESSURE") => Condition::Pressure(mean(values, "P")),
        Some("RESISTANCE") => resistance(number(values, "R")),
        Some("RCR") => resistance(number(values, "Rp") + number(values, "Rd")),
        other => panic!("a boundary condition {other:?}"),
    }
}

impl Model {
    fn read(path: PathBuf) -> Self {
        let json: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        let vessels: Vec<&Value> = rows(&json, "vessels").collect();
        let row = |id: &Value| vessels.iter().position(|v| v["vessel_id"] == *id).unwrap();
        let mut model = Self {
            names: vessels.iter().map(|v| v["vessel_name"].as_str().unwrap().to_owned()).collect(),
            ends: vec![[usize::MAX; 2]; vessels.len()],
            resistance: vessels.iter().map(|v| number(&v["zero_d_element_values"], "R_poiseuille")).collect(),
            stenosis: vessels
                .iter()
                .map(|v| v["zero_d_element_values"]["stenosis_coefficient"].as_f64().unwrap_or(0.0))
                .collect(),
            nodes: 0,
            conditions: Vec::new(),
        };
        for junction in rows(&json, "junctions") {
            let middle = model.node();
            rows(junction, "inlet_vessels").for_each(|id| model.ends[row(id)][1] = middle);
            let within = reals(&junction["junction_values"], "R_poiseuille");
            for (branch, id) in rows(junction, "outlet_vessels").enumerate() {
                // A resistance within the junction lies between its middle and the branch.
                let start = match within.get(branch) {
                    Some(r) if *r != 0.0 => {
                        let end = model.node();
                        model.names.push(String::new());
                        model.ends.push([middle, end]);
                        model.resistance.push(*r);
                        model.stenosis.push(0.0);
                        end
                    }
                    _ => middle,
                };
                model.ends[row(id)][0] = start;
            }
        }
        for (row, vessel) in vessels.iter().enumerate() {
            for (end, key) in ["inlet", "outlet"].into_iter().enumerate() {
                if let Some(name) = vessel["boundary_conditions"].get(key) {
                    let node = model.node();
                    model.ends[row][end] = node;
                    let stated = rows(&json, "boundary_conditions").find(|bc| bc["bc_name"] == *name).unwrap();
                    model.conditions.push((node, condition(stated)));
                }
            }
        }
        model
    }

    fn node(&mut self) -> usize {
        self.nodes += 1;
        self.nodes - 1
    }

    /// Solved by willis with these resistances stated.
    fn solve(&self, resistance: &[f64]) -> State {
        let vessel = |r: &f64| Vessel { resistance: Some(*r), ..tube(10.0, 1.0) };
        let network: Network = network(self.nodes, self.ends.iter().copied().zip(resistance.iter().map(vessel)));
        let tubes: Vec<Tube> = network.vessels().map(|(_, vessel)| Tube::of(vessel, VISCOSITY)).collect();
        State::solve(&network, &boundary(&network, &self.conditions), &tubes, VISCOSITY).unwrap()
    }

    /// Pressures at the two ends of a vessel.
    fn pressures(&self, state: &State, row: usize) -> [f64; 2] {
        self.ends[row].map(|node| state.pressure[node].unwrap())
    }
}

/// Its steady solution: name, then flow and pressure at the inlet and the outlet, for every vessel and time.
fn solution(path: PathBuf) -> Vec<(String, [f64; 4])> {
    let json: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let columns = ["flow_in", "flow_out", "pressure_in", "pressure_out"];
    let row = |key: &String| columns.map(|column| number(&json[column], key));
    json["name"].as_object().unwrap().iter().map(|(key, name)| (name.as_str().unwrap().to_owned(), row(key))).collect()
}

/// The solutions are by hand in each case's description.
#[test]
fn its_linear_steady_cases_are_reproduced() {
    let Some(folder) = folder() else { return };
    let cases = ["R_R", "R_steadyPressure", "bifurcationR_R1", "bifurcationR_R2", "blood_vessel_junction", "confluenceR_R"];
    let mut worst = 0.0_f64;
    for case in cases {
        let model = Model::read(folder.join(format!("steadyFlow_{case}.json")));
        let state = model.solve(&model.resistance);
        for (name, expected) in solution(folder.join(format!("result_steadyFlow_{case}.json"))) {
            let row = model.names.iter().position(|n| *n == name).unwrap();
            let [a, b] = model.pressures(&state, row);
            let flow = state.vessels[row].flow;
            for (got, expected) in [flow, flow, a, b].into_iter().zip(expected) {
                worst = worst.max((got / expected - 1.0).abs());
                assert!((got / expected - 1.0).abs() < STEADY, "{case}, {name}: {got} for {expected}");
            }
        }
    }
    println!("largest relative error {worst:e}");
}

/// Its drop over a stenosis is Q (R + S |Q|). willis has the linear part and no other: the drop falls short by S Q².
#[test]
fn the_quadratic_term_of_a_stenosis_is_not_modelled() {
    let Some(folder) = folder() else { return };
    let model = Model::read(folder.join("steadyFlow_stenosis_R.json"));
    let state = model.solve(&model.resistance);
    let (flow, drop) = (state.vessels[0].flow, state.vessels[0].drop);
    for (_, [q, _, a, b]) in solution(folder.join("result_steadyFlow_stenosis_R.json")) {
        let [_, outlet] = model.pressures(&state, 0);
        assert!((flow / q - 1.0).abs() < STEADY && (outlet / b - 1.0).abs() < STEADY, "{flow} for {q}, {outlet} for {b}");
        assert!((drop / (q * model.resistance[0]) - 1.0).abs() < STEADY, "{drop}");
        assert!(((a - b - drop) / (model.stenosis[0] * q * q) - 1.0).abs() < STEADY, "{}", a - b - drop);
    }
}

/// The cycle means of a vessel in its pulsatile solution.
struct Means {
    flow: f64,
    /// Mean of |Q|·Q.
    square: f64,
    pressure: [f64; 2],
}

fn means(folder: &std::path::Path, model: &Model, of: &str) -> Vec<Means> {
    let table = std::fs::read_to_string(folder.join("vmr_cycle_mean_reference.csv")).unwrap();
    let header: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let row = |name: &String| {
        let line = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let line = line.into_iter().find(|cells| cells[0] == of && cells[1] == name).unwrap();
        let cell = |name: &str| line[header.iter().position(|h| *h == name).unwrap()].parse::<f64>().unwrap();
        Means {
            flow: cell("mean_Q_in_mL_s"),
            square: cell("mean_absQQ_in"),
            pressure: [cell("mean_P_in_dyn_cm2"), cell("mean_P_out_dyn_cm2")],
        }
    };
    model.names.iter().map(row).collect()
}

/// A patient's network with the cycle means of its pulsatile solution, in dyn/cm² and mL/s.
struct Patient {
    of: &'static str,
    model: Model,
    means: Vec<Means>,
}

impl Patient {
    fn all() -> Vec<Self> {
        let Some(folder) = folder() else { return Vec::new() };
        let patient = |of| {
            let model = Model::read(folder.join(format!("vmr_{of}_network.json")));
            let means = means(&folder, &model, of);
            Self { of, model, means }
        };
        ["0080_0001", "0104_0001", "0140_2001"].map(patient).into()
    }

    fn most(&self, figure: impl Fn(usize) -> f64) -> f64 {
        (0..self.means.len()).map(|row| figure(row).abs()).fold(0.0, f64::max)
    }

    fn drop(&self, row: usize) -> f64 {
        self.means[row].pressure[0] - self.means[row].pressure[1]
    }

    /// The part of the mean drop that goes as the square of the flow.
    fn quadratic(&self, row: usize) -> f64 {
        self.model.stenosis[row] * self.means[row].square
    }

    /// What the mean drop of a vessel has beyond R·Q and the quadratic part: inertia, storage, convergence.
    fn residual(&self, row: usize) -> f64 {
        self.drop(row) - self.model.resistance[row] * self.means[row].flow - self.quadratic(row)
    }

    /// At each outlet: the mean pressure above the distal one, and what of it is not R·Q, since capacitors still charge.
    fn terminals(&self) -> Vec<[f64; 2]> {
        let conditions = self.model.conditions.iter();
        let terminal = conditions.filter_map(|(node, condition)| match condition {
            Condition::Resistance { resistance, venous } => Some((node, resistance, venous)),
            _ => None,
        });
        let figures = terminal.map(|(node, resistance, venous)| {
            let row = self.model.ends.iter().position(|ends| ends[1] == *node).unwrap();
            let drop = self.means[row].pressure[1] - venous;
            [drop, drop - resistance * self.means[row].flow]
        });
        figures.collect()
    }

    /// The largest sum of |quadratic part| on the way from the inlet to any vessel's end.
    fn quadratic_on_the_way(&self) -> f64 {
        self.most(|row| {
            let (mut sum, mut at) = (0.0, Some(row));
            while let Some(row) = at {
                sum += self.quadratic(row).abs();
                at = self.model.ends.iter().position(|ends| ends[1] == self.model.ends[row][0]);
            }
            sum
        })
    }

    fn worst_pressure(&self, state: &State) -> f64 {
        self.most(|row| {
            let got = self.model.pressures(state, row);
            (got[0] - self.means[row].pressure[0]).abs().max((got[1] - self.means[row].pressure[1]).abs())
        })
    }

    fn worst_flow(&self, state: &State) -> f64 {
        self.most(|row| state.vessels[row].flow / self.means[row].flow - 1.0)
    }
}

/// To what share Kirchhoff's current law holds for the reference's mean flows.
const MEANS: f64 = 2e-5;

/// With every vessel's secant resistance R + S·mean(|Q|Q)/mean Q stated, means obey a linear network. What the means themselves
/// leave over bounds the error: a source of e Pa in one vessel moves no pressure by more than e, and all terminals together none by
/// more than the largest of theirs. Flows are the terminals' drops over their resistances.
#[test]
fn mean_pressures_of_patients_with_secant_resistances() {
    for patient in Patient::all() {
        let secant = |row: usize| patient.model.resistance[row] + patient.quadratic(row) / patient.means[row].flow;
        let state = patient.model.solve(&(0..patient.means.len()).map(secant).collect::<Vec<_>>());
        let terminals = patient.terminals();
        let level = patient.most(|row| patient.means[row].pressure[0]);
        let charging = terminals.iter().map(|[_, e]| e.abs()).fold(0.0, f64::max);
        let bound = charging + (0..patient.means.len()).map(|row| patient.residual(row).abs()).sum::<f64>() + MEANS * level;
        let share = bound / terminals.iter().map(|[drop, _]| *drop).fold(f64::INFINITY, f64::min);
        let (pressure, flow) = (patient.worst_pressure(&state), patient.worst_flow(&state));
        let largest = patient.most(|row| patient.drop(row));
        let drop = patient.most(|row| state.vessels[row].drop - patient.drop(row)) / largest;
        let own = patient.most(|row| patient.residual(row)) / largest;
        println!("{}: pressure {pressure:.3} of {level:.0}, bound {bound:.3}", patient.of);
        println!("  flow {flow:.2e}, bound {share:.2e}; drop {drop:.2e} of the largest, the means' own {own:.2e}");
        assert!(pressure <= bound && flow <= share, "{}", patient.of);
        assert!(drop <= own + flow, "{}", patient.of);
    }
}

/// With R alone, as willis has it, the quadratic parts are missing: from a vessel's own drop all of its own, 19 to 50 % of the
/// largest drop; from a pressure no more than those on the way to it. Terminals resist so much more that flows hardly move.
#[test]
fn mean_pressures_of_patients_with_the_linear_part_alone() {
    for patient in Patient::all() {
        let state = patient.model.solve(&patient.model.resistance);
        let terminals = patient.terminals();
        let charging = terminals.iter().map(|[_, e]| e.abs()).fold(0.0, f64::max);
        let (pressure, flow) = (patient.worst_pressure(&state), patient.worst_flow(&state));
        let bound = charging + patient.quadratic_on_the_way();
        let share = bound / terminals.iter().map(|[drop, _]| *drop).fold(f64::INFINITY, f64::min);
        let largest = patient.most(|row| patient.drop(row));
        let missing = patient.most(|row| state.vessels[row].drop - patient.drop(row)) / largest;
        let linear = patient.most(|row| state.vessels[row].drop - patient.drop(row) + patient.quadratic(row)) / largest;
        let own = patient.most(|row| patient.residual(row)) / largest;
        println!("{}: pressure {pressure:.1}, bound {bound:.1}; flow {flow:.2e}, bound {share:.2e}", patient.of);
        println!("  drop {missing:.3} of the largest missing, {linear:.2e} of its linear part");
        assert!(pressure <= bound && flow <= share, "{}", patient.of);
        assert!((0.18..0.5).contains(&missing) && linear <= own + flow, "{}", patient.of);
    }
}
