//! Models for other solvers: a fork solved by hand in their units, and what they cannot hold.

use std::borrow::Cow;
use std::fs;

use serde_json::Value;
use willis::internals::formats::convert::{Target, losses};
use willis::internals::formats::{SolverSetting, write_openbf, write_svzerod};
use willis::internals::network::{Condition, Network, Node, Origin, Role, Vessel, Wall, Windkessel, fragments};
use willis::internals::phantom::{Anatomy, Recipe};
use willis::{ReadOptions, Unfed};

use crate::command::{folder, stderr, willis};
use crate::peers::python;

/// A tube of 100 mm and 2 mm with a wave speed of 8 m/s that forks into two, one behind a Windkessel and written against the flow.
fn fork() -> Network {
    let mut network = Network::new();
    for id in ["in", "fork", "wide", "thin"] {
        network.add_node(Node { id: id.to_owned(), ..Node::default() });
    }
    let vessel = |label: &str, length_mm: f64, radius_mm: f64| Vessel {
        label: label.to_owned(),
        wall: Some(Wall::Speed(8.0)),
        ..Vessel::new(length_mm / 1e3, radius_mm / 1e3, Origin::Observed)
    };
    network.add_vessel([0, 1], vessel("ICA", 100.0, 2.0));
    network.add_vessel([2, 1], vessel("M1", 40.0, 1.5));
    network.add_vessel([1, 3], vessel("A1", 40.0, 1.0));
    let state = |network: &mut Network, node: usize, role, condition| {
        (network.node_mut(node).role, network.node_mut(node).condition) = (Some(role), Some(condition));
    };
    state(&mut network, 0, Role::Inlet, Condition::Pressure(12_000.0));
    state(&mut network, 2, Role::Outlet, Condition::Resistance { resistance: 4e9, venous: 500.0 });
    state(&mut network, 3, Role::Outlet, Condition::Resistance { resistance: 8e9, venous: 0.0 });
    network.node_mut(2).windkessel = Windkessel { proximal: Some(1e9), compliance: Some(1e-10) }.stated();
    network
}

#[test]
fn svzerodsolver_gets_lumped_vessels_in_its_units() {
    let mut written = Vec::new();
    write_svzerod(&mut written, &fork(), &SolverSetting::default()).expect("a model");
    let model: Value = serde_json::from_slice(&written).expect("JSON");
    let near = |value: &Value, expected: f64| {
        let got = value.as_f64().expect("a number");
        assert!((got / expected - 1.0).abs() < 1e-12, "{got} for {expected}");
    };
    // By hand: R = 8 · 0.035 P · 10 cm/(π · 0.2⁴ cm⁴), L = 1.06 · 10/(π · 0.04), C = A l/(ρ c²) = π · 0.04 · 10/(1.06 · 800²).
    let pi = std::f64::consts::PI;
    let of = &model["vessels"][0]["zero_d_element_values"];
    near(&of["R_poiseuille"], 8.0 * 0.035 * 10.0 / (pi * 0.0016));
    near(&of["L"], 1.06 * 10.0 / (pi * 0.04));
    near(&of["C"], pi * 0.04 * 10.0 / (1.06 * 640_000.0));
    // The second vessel was written against the flow.
    assert_eq!(model["vessels"][1]["boundary_conditions"]["outlet"], "OUTLET_wide");
    assert_eq!(model["junctions"][0]["inlet_vessels"], serde_json::json!([0]));
    assert_eq!(model["junctions"][0]["outlet_vessels"], serde_json::json!([1, 2]));
    let conditions = model["boundary_conditions"].as_array().expect("conditions");
    let named = |name: &str| conditions.iter().find(|c| c["bc_name"] == name).expect("it");
    near(&named("INLET_in")["bc_values"]["P"][1], 120_000.0);
    let behind = &named("OUTLET_wide")["bc_values"];
    near(&behind["Rp"], 1e4);
    near(&behind["Rd"], 3e4);
    near(&behind["C"], 1e-5);
    near(&behind["Pd"], 5e3);
    assert_eq!(named("OUTLET_thin")["bc_type"], "RESISTANCE");
    near(&named("OUTLET_thin")["bc_values"]["R"], 8e4);
}

#[test]
fn openbf_gets_tubes_in_si() {
    let mut written = Vec::new();
    write_openbf(&mut written, &fork(), &SolverSetting::default()).expect("a model");
    let text = String::from_utf8(written).expect("UTF-8");
    let vessels: Vec<&str> = text.split("  - label: ").skip(1).collect();
    assert_eq!(vessels.len(), 3);
    assert!(vessels[0].starts_with("\"0-ICA\"\n    sn: 1\n    tn: 2\n    L: 0.1\n    R0: 0.002\n"), "{text}");
    assert!(vessels[0].contains("inlet: P\n    inlet file: inlet-1.dat\n    inlet number: 1"), "{text}");
    assert!(
        vessels[1].contains("sn: 2\n    tn: 3")
            && vessels[1].contains("outlet: wk3\n    R1: 1000000000.0\n    R2: 3000000000.0\n"),
        "{text}"
    );
    assert!(vessels[1].ends_with("Cc: 1.0e-10\n") && !text.contains("Pout"), "{text}");
    let said = losses(&fork(), &Target::new("a.yaml".as_ref(), None).expect("a target"));
    assert!(said.contains(&"the venous pressure of 1 outlet, which is 0 in openBF".to_owned()), "{said:?}");
    // c0² = (2/3) (E h/r)/ρ.
    let number = |key: &str| -> f64 {
        let rest = &vessels[0][vessels[0].find(key).expect("a key") + key.len()..];
        rest.lines().next().expect("a line").trim().parse().expect("a number")
    };
    let speed = (2.0 / 3.0 * number("E:") * number("h0:") / 0.002 / 1060.0).sqrt();
    assert!((speed - 8.0).abs() < 1e-12, "{speed}");
    // By Kirchhoff: the pressure at the fork of 8 µ l/(π r⁴) and 4e9, 8e9 Pa s/m³, then the mean over 100, 40 and 40 mm.
    let tube = |length: f64, radius: f64| 8.0 * 0.0035 * length / (std::f64::consts::PI * radius.powi(4));
    let [carotid, wide, thin] = [tube(0.1, 2e-3), tube(0.04, 1.5e-3), tube(0.04, 1e-3)];
    let fork = (12_000.0 / carotid + 500.0 / (wide + 4e9)) / (1.0 / carotid + 1.0 / (wide + 4e9) + 1.0 / (thin + 8e9));
    let ends = [(12_000.0, 0.1), (fork - (fork - 500.0) * wide / (wide + 4e9), 0.04), (fork - fork * thin / (thin + 8e9), 0.04)];
    let mean = ends.iter().map(|(end, length)| f64::midpoint(fork, *end) * length).sum::<f64>() / 0.18;
    assert!((number("Pext:") / mean - 1.0).abs() < 1e-9, "{text}, {mean}");
    assert_eq!(text.matches(&format!("Pext: {}\n", number("Pext:"))).count(), 3, "one pressure: junctions do not look at it");
    let mut open = self::fork();
    open.node_mut(3).condition = Some(Condition::Pressure(0.0));
    let mut written = Vec::new();
    write_openbf(&mut written, &open, &SolverSetting::default()).expect("a model");
    // The end keeps the pressure that the vessel has at R0.
    assert_eq!(String::from_utf8(written).expect("UTF-8").matches("Pext: 0.0\n").count(), 3);
}

#[test]
fn what_they_cannot_hold_is_refused() {
    let said =
        |network: &Network| write_svzerod(&mut Vec::new(), network, &SolverSetting::default()).expect_err("refused").to_string();
    let mut inner = fork();
    inner.node_mut(1).condition = Some(Condition::Pressure(1.0));
    assert!(said(&inner).contains("node fork is not at a free end"));
    let mut held = fork();
    held.node_mut(3).condition = Some(Condition::Pressure(-3.0));
    let why = write_openbf(&mut Vec::new(), &held, &SolverSetting::default()).expect_err("refused").to_string();
    assert!(why.contains("node thin is an outlet of fixed pressure or flow"), "{why}");
    let mut apart = fork();
    let [a, b] = ["a", "b"].map(|id| apart.add_node(Node { id: id.to_owned(), ..Node::default() }));
    apart.add_vessel([a, b], Vessel::new(0.01, 1e-3, Origin::Observed));
    let why = write_openbf(&mut Vec::new(), &apart, &SolverSetting::default()).expect_err("refused").to_string();
    assert!(why.contains("no inlet leads to"), "{why}");
    let mut closed = fork();
    closed.node_mut(0).condition = None;
    assert!(said(&closed).contains("no node states an inlet"));
    // Nor is an inlet on no vessel one of them: a model without any vessel was written.
    let mut alone = closed;
    let condition = Some(Condition::Pressure(12_000.0));
    alone.add_node(Node { id: "alone".to_owned(), condition, ..Node::default() });
    assert!(said(&alone).contains("no node states an inlet of a vessel"));
    let target = Target::new("a.json".as_ref(), Some("svzerod")).expect("a target");
    assert_eq!(target.network(&alone).expect("a network").0.vessel_count(), 3);
}

/// A fork at which five vessels meet, one of them a ring, and a part that no blood enters.
fn crowded() -> Network {
    let mut network = fork();
    let side = network.add_node(Node { id: "side".to_owned(), ..Node::default() });
    network.add_vessel([1, side], Vessel::new(0.03, 0.8e-3, Origin::Observed));
    let ring = Vessel { resistance: Some(6e8), ..Vessel::new(0.02, 0.5e-3, Origin::Observed) };
    network.add_vessel([1, 1], ring);
    let [a, b] = ["a", "b"].map(|id| network.add_node(Node { id: id.to_owned(), ..Node::default() }));
    network.add_vessel([a, b], Vessel::new(0.01, 1e-3, Origin::Observed));
    network
}

/// What solvers in time cannot do with is left out or divided, with a line for each, and the rest is as it was.
#[test]
fn a_repaired_network_reaches_a_solver() {
    let whole = crowded();
    let target = |name: &str, unfed: Option<Unfed>| Target::new(name.as_ref(), None).expect("a target").with_unfed(unfed);
    let svzerod = Target::new("a.json".as_ref(), Some("svzerod")).expect("a target");
    let (made, notes) = svzerod.network(&whole).expect("a network");
    assert_eq!(
        notes,
        [
            "1 vessel in parts that no blood enters, left out (`unfed=keep` writes them)",
            "1 vessel from a node to itself, divided in two"
        ]
    );
    let halves: Vec<&Vessel> = made.vessels().map(|(_, vessel)| vessel).filter(|v| v.radius == 0.5e-3).collect();
    assert_eq!(halves.iter().map(|v| (v.length, v.resistance)).collect::<Vec<_>>(), [(0.01, Some(3e8)); 2]);
    assert_eq!((made.node_count(), made.vessel_count()), (6, 6));
    write_svzerod(&mut Vec::new(), &made, &SolverSetting::default()).expect("a model");
    // Six vessels meet at the fork: the widest two stay there, beside a link as wide as the widest of 2 mm.
    let (made, notes) = target("a.yaml", None).network(&whole).expect("a network");
    assert_eq!(notes[2], "1 node of more than 3 vessels divided, by 3 vessels one radius long");
    let degree = made.degrees(|_| true);
    assert!(degree.iter().all(|degree| (1..=3).contains(degree)), "{degree:?}");
    let links: Vec<f64> = made.vessels().filter(|(_, v)| v.length == v.radius).map(|(_, v)| v.radius).collect();
    assert_eq!((made.vessel_count(), links), (9, vec![2e-3; 3]));
    let at_fork: Vec<&str> =
        made.vessels().filter(|(ends, v)| ends.contains(&1) && v.length != v.radius).map(|(_, v)| v.label.as_str()).collect();
    assert_eq!(at_fork, ["ICA", "M1"]);
    assert_eq!(fragments(&made, |_, _| true).count, 1);
    write_openbf(&mut Vec::new(), &made, &SolverSetting::default()).expect("a model");
    // As it is said.
    let kept = target("a.yaml", Some(Unfed::Keep)).network(&whole).expect("a network").0;
    let why = write_openbf(&mut Vec::new(), &kept, &SolverSetting::default()).expect_err("refused").to_string();
    assert!(why.contains("no inlet leads to"), "{why}");
    assert!(matches!(target("a.graphml", None).network(&whole).expect("a network").0, Cow::Borrowed(_)));
    assert_eq!(target("a.graphml", Some(Unfed::Drop)).network(&whole).expect("a network").0.vessel_count(), 5);
    let mut closed = whole.clone();
    closed.node_mut(0).condition = None;
    let why = target("a.graphml", Some(Unfed::Drop)).network(&closed).expect_err("no inlet").to_string();
    assert!(why.contains("unfed drop: needs a node that states where blood enters"), "{why}");
}

/// A part that leads nowhere goes round: from each of its nodes a vessel leads on. Where all ends are inlets, one of them is where blood leaves,
/// which openBF cannot have.
#[test]
fn every_node_between_vessels_has_one_that_comes_and_one_that_goes() {
    let mut fed = fork();
    for node in [2, 3] {
        (fed.node_mut(node).role, fed.node_mut(node).condition) = (Some(Role::Inlet), Some(Condition::Pressure(11_000.0)));
    }
    let why = write_openbf(&mut Vec::new(), &fed, &SolverSetting::default()).expect_err("refused").to_string();
    assert!(why.contains("node wide is an outlet of fixed pressure or flow"), "{why}");
    let mut network = fork();
    let nodes = ["stick", "a", "b"].map(|id| network.add_node(Node { id: id.to_owned(), ..Node::default() }));
    for ends in [[1, nodes[0]], [nodes[0], nodes[1]], [nodes[0], nodes[2]], [nodes[1], nodes[2]]] {
        network.add_vessel(ends, Vessel::new(0.01, 1e-3, Origin::Observed));
    }
    for (network, count) in [(network, 4), (fed, 1)] {
        let mut written = Vec::new();
        write_svzerod(&mut written, &network, &SolverSetting::default()).expect("a model");
        let model: Value = serde_json::from_slice(&written).expect("JSON");
        let junctions = model["junctions"].as_array().expect("junctions");
        assert_eq!(junctions.len(), count);
        for junction in junctions {
            for side in ["inlet_vessels", "outlet_vessels"] {
                assert!(!junction[side].as_array().expect("rows").is_empty(), "{junction}");
            }
        }
    }
}

/// Reads a file of each version of openBF as its reader does: every section and key that it demands, by name and type, what its formulas make of
/// them, and what its solver demands of the network. Keys: INSIGNEO/openBF, src/initialise.jl of 1.5.1 (`checkSections`, `checkVessel`,
/// `addOutlet`), and src/{simulation,network,vessel}.jl and docs/src/man/config.md of 2.
const OPENBF: &str = r#"
import sys, yaml
from math import pi, sqrt
for path in sys.argv[1:]:
    data = yaml.safe_load(open(path))
    number = lambda x: isinstance(x, float) and x == x
    # 1.5.1
    assert isinstance(data["project name"], str) and {"network", "blood", "solver"} <= data.keys()
    blood, solver, network = data["blood"], data["solver"], data["network"]
    assert number(blood["mu"]) and number(blood["rho"])
    assert number(solver["Ccfl"]) and 0 < solver["Ccfl"] <= 1 and isinstance(solver["cycles"], int) and number(solver["convergence tolerance"])
    # 2
    assert isinstance(data["project_name"], str) and data["inlet_file"].endswith(".dat") and set(data["write_results"]) <= {"P", "Q", "u", "A"}
    assert number(solver["convergence_tolerance"]) and isinstance(solver["jump"], int)
    into, out, inlets = {}, {}, []
    for v in network:
        assert isinstance(v["label"], str) and v["label"] and "/" not in v["label"], v
        assert isinstance(v["sn"], int) and isinstance(v["tn"], int) and v["sn"] != v["tn"] and min(v["sn"], v["tn"]) > 0
        assert all(number(v[key]) and v[key] > 0 for key in ("L", "E", "R0", "h0")), v
        out.setdefault(v["sn"], []).append(v); into.setdefault(v["tn"], []).append(v)
        if "inlet" in v:
            assert v["inlet"] in ("Q", "P") and v["inlet file"] == f"inlet-{v['inlet number']}.dat"
            inlets.append(v["inlet number"])
        if v.get("outlet") == "wk3":
            # Both divide by R1, R2 and Cc.
            assert all(number(v[key]) and v[key] > 0 for key in ("R1", "R2", "Cc")), v
        elif "outlet" in v:
            assert v["outlet"] == "reflection" and v["Rt"] in (1.0, -1.0), v
        # beta = sqrt(pi/A0) h0 E/0.75, gamma = beta/(3 rho R0 sqrt(pi)), c0 = sqrt(3/2 gamma sqrt(A0)), as both compute them.
        area = pi * v["R0"] ** 2
        # Both take 2 (gamma_profile + 2) pi mu for the friction; 1.5.1 has 9 where none is stated, 2 has 2. Poiseuille's is 8 pi mu.
        assert 2 * (v.get("gamma_profile", 9) + 2) == 8 and v["Pext"] == network[0]["Pext"], v
        gamma = sqrt(pi / area) * v["h0"] * v["E"] / 0.75 / (3 * blood["rho"] * v["R0"] * sqrt(pi))
        speed = sqrt(1.5 * gamma * sqrt(area))
        assert 1 < speed < 60, (speed, v)
        if v.get("outlet") == "wk3":
            matched = blood["rho"] * speed / area
            print(path.rsplit("/", 1)[1], repr(v["R1"] / matched), repr(v["R1"] + v["R2"]), repr(v["Cc"]))
    assert sorted(inlets) == list(range(1, len(inlets) + 1)) and inlets, inlets
    # The inlet of version 2 begins at node 1; nothing else does where there is one inlet.
    assert len(out[1]) == 1 and 1 not in into and out[1][0]["inlet number"] == 1
    for node in into.keys() | out.keys():
        ends, begins = into.get(node, []), out.get(node, [])
        if not ends:
            assert len(begins) == 1 and "inlet" in begins[0], node
        elif not begins:
            assert len(ends) == 1 and "outlet" in ends[0], node
        else:
            assert len(ends) + len(begins) <= 3, node
    assert set(into) | set(out) == set(range(1, len(set(into) | set(out)) + 1))
"#;

/// The circles that ship, and the whole tree from the heart, which has one inlet.
#[test]
fn openbf_finds_every_key_that_it_demands() {
    let folder = tempfile::tempdir().expect("a folder");
    let heart = Anatomy::CircleOfWillis.network(&Recipe::default()).expect("a phantom");
    let crowded = Target::new("a.yaml".as_ref(), None).expect("a target").network(&crowded()).expect("a network").0.into_owned();
    let mut networks = vec![("heart".to_owned(), heart), ("crowded".to_owned(), crowded)];
    for file in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/data/circle-of-willis")).expect("the circles") {
        let path = file.expect("a file").path();
        let network = willis::read(&path, &ReadOptions::default()).expect("a circle").network;
        networks.push((path.file_stem().expect("a name").to_string_lossy().into_owned(), network));
    }
    let mut paths = Vec::new();
    for (name, network) in &networks {
        let path = folder.path().join(format!("{name}.yaml"));
        write_openbf(&mut std::fs::File::create(&path).expect("a file"), network, &SolverSetting::default()).expect("a model");
        paths.push(path);
    }
    let arguments: Vec<&std::path::Path> = paths.iter().map(std::path::PathBuf::as_path).collect();
    let Some(said) = python(OPENBF, &arguments) else { return };
    // 11 outlets from the heart, 2 of the fork, 6 of each circle; R1 is matched, the sum is the table's, and RC is 0.69 s.
    assert_eq!(said.lines().count(), 11 + 2 + 11 * 6);
    for line in said.lines().filter(|line| !line.starts_with("crowded")) {
        let figures: Vec<f64> = line.split(' ').skip(1).map(|x| x.parse().expect("a number")).collect();
        assert!((figures[0] - 1.0).abs() < 1e-12, "{line}");
        assert!((figures[1] * figures[2] - 0.69).abs() < 1e-12, "{line}");
    }
}

/// A carotid under a square pulse, as the options of a simulation say: the inlet file has its mean and its extremes, the blood is what was stated, and outlets
/// have the time constant. Without the options a model is as before.
#[test]
fn conditions_of_a_simulation_go_into_models() {
    let here = folder();
    fs::write(here.path().join("wave.csv"), "time_s,flow_mL_per_min\n0,120\n0.4,120\n0.4,360\n0.8,360\n0.8,120\n")
        .expect("written");
    let edges = "node_a,node_b,label,length_mm,radius_mm\n0,1,ICA,100,2\n1,2,M1,50,1.5\n1,3,A1,50,1\n";
    fs::write(here.path().join("edges.csv"), edges).expect("written");
    fs::write(here.path().join("nodes.csv"), "node,id,x_mm,y_mm,z_mm\n0,in,0,0,0\n1,fork,0,0,100\n2,m,50,0,100\n3,a,0,50,100\n")
        .expect("written");
    let convert = |more: &[&str]| willis(here.path(), &[&["convert", "edges.csv"], more].concat());
    let conditions = ["--inlet", "in", "--outlet", "m=20mmHg.s/mL", "--outlet", "a=40mmHg.s/mL"];
    let pulse =
        ["--pulse", "wave.csv", "--viscosity", "4cP", "--density", "1050kg/m3", "--wall", "pwv=8m/s", "--harmonics", "200"];
    let made = convert(&[&["model.yaml"], &conditions[..], &pulse[..]].concat());
    assert!(made.status.success(), "{}", stderr(&made));
    let text = fs::read_to_string(here.path().join("model.yaml")).expect("a model");
    for part in ["rho: 1050.0", "mu: 0.004", "inlet: Q", "inlet file: inlet-1.dat"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let rows: Vec<Vec<f64>> = fs::read_to_string(here.path().join("inlet-1.dat"))
        .expect("an inlet")
        .lines()
        .map(|line| line.split(' ').map(|x| x.parse().expect("a number")).collect())
        .collect();
    assert!((rows[0][0], rows[rows.len() - 1][0]) == (0.0, 0.8) && rows[0][1] == rows[rows.len() - 1][1]);
    let mean = rows[1..].iter().map(|row| row[1]).sum::<f64>() / (rows.len() - 1) as f64;
    let of = |ml_per_min: f64| ml_per_min * 1e-6 / 60.0;
    assert!((mean / of(240.0) - 1.0).abs() < 1e-9, "{mean}");
    // Within a part of the square, far from its steps, harmonics ring by little.
    let near = |time: f64| rows.iter().find(|row| row[0] >= time).expect("a row")[1];
    assert!((near(0.2) / of(120.0) - 1.0).abs() < 0.01 && (near(0.6) / of(360.0) - 1.0).abs() < 0.01);
    let made = convert(&[&["model.json", "--to", "svzerod"], &conditions[..], &pulse[..]].concat());
    assert!(made.status.success(), "{}", stderr(&made));
    let model: Value = serde_json::from_slice(&fs::read(here.path().join("model.json")).expect("a model")).expect("JSON");
    let of_name = |name: &str| {
        let all = model["boundary_conditions"].as_array().expect("a list");
        all.iter().find(|of| of["bc_name"] == name).unwrap_or_else(|| panic!("{name} in {all:?}"))
    };
    assert_eq!((of_name("INLET_in")["bc_type"].as_str(), of_name("OUTLET_m")["bc_type"].as_str()), (Some("FLOW"), Some("RCR")));
    let values = |name: &str, key: &str| of_name(name)["bc_values"][key].as_f64().expect(key);
    // R1 is ρ c/A, and RC is .69 s; in dyn, cm and s.
    let area = std::f64::consts::PI * 0.15 * 0.15;
    assert!((values("OUTLET_m", "Rp") / (1.05 * 800.0 / area) - 1.0).abs() < 1e-9);
    let whole = values("OUTLET_m", "Rp") + values("OUTLET_m", "Rd");
    assert!((whole / (20.0 * 1_333.223_684) - 1.0).abs() < 1e-6 && (whole * values("OUTLET_m", "C") - 0.69).abs() < 1e-9);
    let poiseuille = 8.0 * 0.04 * 5.0 / (std::f64::consts::PI * 0.15_f64.powi(4));
    let m1 = &model["vessels"][1]["zero_d_element_values"];
    assert!((m1["R_poiseuille"].as_f64().expect("a number") / poiseuille - 1.0).abs() < 1e-9, "{m1}");
    assert!((m1["L"].as_f64().expect("a number") / (1.05 * 5.0 / area) - 1.0).abs() < 1e-9, "{m1}");
    for (words, why) in [
        (&["out.vtp", "--pulse"][..], "go with --to svzerod or --to openbf"),
        (&["out.yaml", "--wall", "rigid"], "--wall"),
        (&["out.yaml", "--pulse", "--wall", "rigid"], "--wall rigid: expected walls that give"),
        (&["model.yaml", "--inlet", "in"], "model.yaml"),
    ] {
        let refused = convert(words);
        assert!(refused.status.code() == Some(2) && stderr(&refused).contains(why), "{}", stderr(&refused));
    }
}
