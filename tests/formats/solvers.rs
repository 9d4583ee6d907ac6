//! Models for other solvers: a fork solved by hand in their units, and what they cannot hold.

use serde_json::Value;
use willis::internals::io::{write_openbf, write_svzerod};
use willis::internals::network::{Condition, Network, Node, Origin, Role, Vessel, Wall, Windkessel};

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
    network.node_mut(2).windkessel = Windkessel { proximal: Some(1e9), compliance: Some(1e-10) };
    network
}

#[test]
fn svzerodsolver_gets_lumped_vessels_in_its_units() {
    let mut written = Vec::new();
    write_svzerod(&mut written, &fork()).expect("a model");
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
    write_openbf(&mut written, &fork()).expect("a model");
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
    assert!(vessels[1].contains("Cc: 1e-10\n    Pout: 500.0"), "{text}");
    // c0² = (2/3) (E h/r)/ρ.
    let number = |key: &str| -> f64 {
        let rest = &vessels[0][vessels[0].find(key).expect("a key") + key.len()..];
        rest.lines().next().expect("a line").trim().parse().expect("a number")
    };
    let speed = (2.0 / 3.0 * number("E:") * number("h0:") / 0.002 / 1060.0).sqrt();
    assert!((speed - 8.0).abs() < 1e-12, "{speed}");
}

#[test]
fn what_they_cannot_hold_is_refused() {
    let said = |network: &Network| write_svzerod(&mut Vec::new(), network).expect_err("refused").to_string();
    let mut inner = fork();
    inner.node_mut(1).condition = Some(Condition::Pressure(1.0));
    assert!(said(&inner).contains("node fork is not at a free end"));
    let mut closed = fork();
    closed.node_mut(0).condition = None;
    assert!(said(&closed).contains("no node states an inlet"));
}
