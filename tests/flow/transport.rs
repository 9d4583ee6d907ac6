//! Transport: an independent program's values on the circles that ship, and identities on random networks.

use serde_json::Value;
use willis::internals::flow::Boundary;
use willis::internals::network::units::{milliseconds, ml_per_min};
use willis::internals::network::{Condition, Network};
use willis::internals::simulation::simulate;
use willis::internals::simulation::transport::{Blood, Transport, Transports, transport};
use willis::{Change, FlowOptions, ReadOptions};

use crate::draw::Draw;
use crate::networks::{VISCOSITY, boundary, log_radii, random_conditions, random_network};
use crate::vessels::{network, tube};

fn close(got: f64, expected: f64, within: f64, what: &str) {
    assert!((got - expected).abs() <= within * expected.abs().max(1.0), "{what}: {got} for {expected}");
}

/// The transport of a network as it is.
fn follow(network: &Network, boundary: &Boundary) -> (Transport, f64) {
    let result = simulate(network, boundary, VISCOSITY, &[]).expect("a flow");
    let transport = Transports::of(network, boundary, &result).unperturbed;
    let diffused = result.unperturbed.vessels.iter().enumerate().filter(|(_, vessel)| vessel.diffused);
    (transport, diffused.map(|(row, _)| network.vessel(row).volume()).sum())
}

/// A vessel from a node to itself is there once, two beside each other are two.
#[test]
fn the_vessels_of_a_node_are_those_that_end_there() {
    let network = network(3, [[0, 1], [1, 0], [1, 1], [1, 2]].map(|ends| (ends, tube(5.0, 1.0))));
    assert_eq!([0, 1, 2].map(|node| network.vessels_of(node).count()), [2, 4, 1]);
}

#[test]
fn the_circles_of_an_independent_program() {
    let reference = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/pulsatile/transport-circles.json");
    let Ok(text) = std::fs::read_to_string(reference) else {
        println!("skipped: {reference} is not there");
        return;
    };
    let circles: Value = serde_json::from_str(&text).expect("JSON");
    for (name, circle) in circles.as_object().expect("circles") {
        let path = format!("{}/data/circle-of-willis/{name}.graphml", env!("CARGO_MANIFEST_DIR"));
        let input = willis::read(path.as_ref(), &ReadOptions::default()).expect("a circle");
        let options = FlowOptions { transport: true, ..FlowOptions::default() };
        let run = willis::simulate(&input, &[], &options).expect("a flow");
        let found = &run.transports.as_ref().expect("it was asked for").unperturbed;
        let node_of = |id: &str| (0..input.network.node_count()).find(|node| input.network.node(*node).id == id).expect("a node");
        for (id, inflow) in circle["inlets"].as_object().expect("inlets") {
            let at = found.sources.binary_search(&node_of(id)).expect("a source");
            close(ml_per_min(found.inflow[at]), inflow.as_f64().expect("a flow"), 1e-9, name);
        }
        for (id, outlet) in circle["outlets"].as_object().expect("outlets") {
            let blood = found.nodes[node_of(id)].as_ref().expect("blood");
            let number = |key: &str| outlet[key].as_f64().expect("a number");
            close(ml_per_min(blood.through), number("flow_mL_per_min"), 1e-9, name);
            close(milliseconds(blood.mean), number("mean_ms"), 1e-9, name);
            // The square root of a variance that is zero but for rounding.
            close(milliseconds(blood.variance.sqrt()), number("sd_ms"), 1e-9, name);
            close(milliseconds(blood.first), number("first_ms"), 1e-9, name);
            for (at, source) in found.sources.iter().enumerate() {
                let inlet = &input.network.node(*source).id;
                close(blood.supply[at], outlet["supply"][inlet].as_f64().expect("a share"), 1e-9, name);
                if let Some(mean) = outlet["mean_ms_of"][inlet].as_f64() {
                    close(milliseconds(blood.mean_of_source[at]), mean, 1e-9, name);
                }
            }
        }
    }
}

#[test]
fn what_enters_leaves_and_stays_as_long_as_there_is_room() {
    let mut draw = Draw::new(7);
    for round in 0..60 {
        let nodes = 5 + draw.below(40);
        let network = random_network(&mut draw, nodes, nodes + nodes / 2, log_radii(0.3, 2.0));
        let conditions = random_conditions(&mut draw, nodes);
        let boundary = boundary(&network, &conditions);
        let Ok(result) = simulate(&network, &boundary, VISCOSITY, &[]) else { continue };
        let (found, volume) = follow(&network, &boundary);
        let what = format!("round {round}");
        // The flow of a potential has no cycle: all that moves is followed.
        for (row, vessel) in result.unperturbed.vessels.iter().enumerate() {
            let has_ends = network.ends(row)[0] != network.ends(row)[1];
            let blood = found.vessels[row].and_then(|(up, _)| found.nodes[up].as_ref());
            assert_eq!(blood.is_some(), vessel.diffused && has_ends, "{what}: vessel {row}");
        }
        for blood in found.nodes.iter().flatten() {
            close(blood.supply.iter().sum(), 1.0, 1e-12, &what);
            let by_source = blood.supply.iter().zip(&blood.mean_of_source).filter(|(share, _)| **share > 0.0);
            close(by_source.map(|(share, mean)| share * mean).sum(), blood.mean, 1e-9, &what);
            assert!(blood.first <= blood.mean * (1.0 + 1e-12) && blood.variance >= 0.0, "{what}");
        }
        let scale: f64 = found.inflow.iter().sum();
        let leaving = |of: &dyn Fn(&Blood) -> f64| -> f64 {
            found.exits.iter().map(|(node, flow)| flow * found.nodes[*node].as_ref().map_or(0.0, of)).sum()
        };
        for (at, inflow) in found.inflow.iter().enumerate() {
            close(leaving(&|blood| blood.supply[at]) / scale, inflow / scale, 1e-9, &what);
        }
        close(leaving(&|blood| blood.mean) / volume, 1.0, 1e-6, &what);
    }
}

#[test]
fn against_the_stream_sources_and_exits_change_places() {
    let mut draw = Draw::new(3);
    for _ in 0..20 {
        let network = random_network(&mut draw, 12, 18, log_radii(0.3, 2.0));
        let pressures: Vec<(usize, f64)> = [0, 3, 6, 9].map(|node| (node, draw.within(20.0, 100.0))).to_vec();
        let at = |of: &dyn Fn(f64) -> f64| -> Vec<(usize, Condition)> {
            pressures.iter().map(|(node, p)| (*node, Condition::Pressure(of(*p) * 133.0))).collect()
        };
        let (there, _) = follow(&network, &boundary(&network, &at(&|p| p)));
        let (back, _) = follow(&network, &boundary(&network, &at(&|p| 120.0 - p)));
        let exits: Vec<usize> = back.exits.iter().map(|(node, _)| *node).collect();
        assert_eq!(there.sources, exits);
        for (a, (_, b)) in there.inflow.iter().zip(&back.exits) {
            close(a / b, 1.0, 1e-9, "inflow");
        }
        for (a, b) in there.vessels.iter().zip(&back.vessels) {
            assert_eq!(a.is_some(), b.is_some());
            if let (Some((up, time)), Some((down, again))) = (a, b) {
                assert!(up != down);
                close(time / again, 1.0, 1e-6, "transit");
            }
        }
    }
}

#[test]
fn longer_takes_longer_and_closed_takes_nothing() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/data/circle-of-willis/complete.graphml");
    let input = willis::read(path.as_ref(), &ReadOptions::default()).expect("a circle");
    let options = FlowOptions { transport: true, ..FlowOptions::default() };
    let run = willis::simulate(&input, &[("L-ICA I", Change::Tortuosity(2.0)), ("R-PComm", Change::Occlusion)], &options)
        .expect("a flow");
    let found = run.transports.as_ref().expect("it was asked for");
    let row =
        |label: &str| (0..input.network.vessel_count()).find(|row| input.network.vessel(*row).label == label).expect("a vessel");
    let after = found.perturbed.as_ref().expect("changes");
    let (carotid, volume) = (row("L-ICA I"), input.network.vessel(row("L-ICA I")).volume());
    let flow = run.result.perturbed.as_ref().expect("changes").vessels[carotid].flow;
    close(after.vessels[carotid].expect("flow").1, 2.0 * volume / flow.abs(), 1e-12, "twice the volume");
    assert!(after.vessels[row("R-PComm")].is_none() && found.unperturbed.vessels[row("R-PComm")].is_some());
}

fn equal(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * b.abs().max(1.0)
}

#[test]
fn a_mixing_junction_by_hand() {
    // 3 of source A (volume 6: 2 s) and 1 of source B (volume 5: 5 s) meet and go on through a volume of 8 (2 s).
    let found = transport(&[[0, 2], [1, 2], [3, 2]], &[3.0, 1.0, -4.0], &[6.0, 5.0, 8.0], &[true, true, false, true]);
    let end = found.nodes[3].as_ref().expect("blood comes");
    assert_eq!((&found.sources, &found.exits), (&vec![0, 1], &vec![(3, 4.0)]));
    assert!(equal(end.supply[0], 0.75) && equal(end.supply[1], 0.25));
    assert!(equal(end.mean, (3.0 * 2.0 + 5.0) / 4.0 + 2.0) && equal(end.first, 4.0));
    assert!(equal(end.variance, (3.0 * 4.0 + 25.0) / 4.0 - (11.0_f64 / 4.0).powi(2)));
    assert!(equal(end.mean_of_source[0], 4.0) && equal(end.mean_of_source[1], 7.0));
    assert_eq!(end.territory(), (0, 0.75));
}

#[test]
fn a_chain_is_volume_over_flow() {
    let found = transport(&[[0, 1], [1, 2], [2, 3]], &[2.0; 3], &[1.0, 5.0, 3.0], &[true, false, false, true]);
    let end = found.nodes[3].as_ref().expect("blood comes");
    assert!(equal(end.mean, 4.5) && equal(end.first, 4.5) && equal(end.variance, 0.0));
}

#[test]
fn what_enters_on_the_way_is_young() {
    // One source feeds another's node: half of what leaves there has just entered.
    let found = transport(&[[0, 1], [1, 2]], &[1.0, 2.0], &[3.0, 4.0], &[true, true, true]);
    let (middle, end) = (found.nodes[1].as_ref().expect("blood"), found.nodes[2].as_ref().expect("blood"));
    assert!(equal(middle.mean, 1.5) && equal(middle.first, 0.0) && equal(middle.variance, 2.25));
    assert!(equal(end.mean, 3.5) && equal(end.mean_of_source[0], 5.0) && equal(end.mean_of_source[1], 2.0));
}

#[test]
fn where_nothing_flows_there_is_no_blood() {
    let found = transport(&[[0, 1], [1, 2], [3, 3]], &[1.0, 0.0, 5.0], &[1.0; 3], &[true, true, true, false]);
    assert!(found.nodes[2].is_none() && found.nodes[3].is_none() && found.vessels[1].is_none() && found.vessels[2].is_none());
}
