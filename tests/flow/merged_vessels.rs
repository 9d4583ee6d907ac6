//! Vessels in a row that are merged to one. Truth: the flow in the network as it was, and a case by hand.

use std::borrow::Cow;

use willis::internals::flow::floating_components::fed;
use willis::internals::network::{Network, Node, Origin, PathPoint, Role, Vessel, Wall, cycles, merge};
use willis::internals::simulation::simulate;

use crate::draw::Draw;
use crate::networks::{VISCOSITY, boundary, log_radii, random_conditions, random_network};
use crate::vessels::{network, tube};

/// A vessel from a place along x (mm) to another, with a point midway.
fn along(from: f64, to: f64, radius_mm: f64) -> Vessel {
    let point = |x: f64| PathPoint { position: [x / 1e3, 0.0, 0.0], radius: radius_mm / 1e3, id: None };
    Vessel { path: vec![point(from), point(0.5 * (from + to)), point(to)], ..tube((to - from).abs(), radius_mm) }
}

/// Every vessel in up to four pieces, each with a radius and a direction of its own; the nodes between are new.
fn in_pieces(whole: &Network, draw: &mut Draw) -> Network {
    let mut made = network(0, []);
    for node in whole.nodes() {
        // A name keeps the nodes that were there, whatever meets in them.
        made.add_node(Node { label: format!("junction {}", node.id), ..node.clone() });
    }
    for ([a, b], _) in whole.vessels() {
        let count = 1 + draw.below(4);
        let mut last = a;
        for piece in 0..count {
            let next =
                if piece + 1 == count { b } else { made.add_node(Node { id: made.node_count().to_string(), ..Node::default() }) };
            let length = draw.within(2.0, 20.0);
            let mut vessel = along(0.0, length, draw.within(0.2, 3.0));
            vessel.path.iter_mut().for_each(|point| point.position[1] = draw.within(-0.1, 0.1));
            let ends = if draw.below(2) == 0 {
                [last, next]
            } else {
                vessel.path.reverse();
                [next, last]
            };
            made.add_vessel(ends, vessel);
            last = next;
        }
    }
    made
}

/// What is done to a network.
type Change = dyn Fn(&mut Network);

#[test]
fn flow_through_merged_vessels_is_that_of_their_parts() {
    for seed in 0..40 {
        let mut draw = Draw::new(seed);
        let whole = random_network(&mut draw, 12, 18, log_radii(0.2, 3.0));
        let cut = in_pieces(&whole, &mut draw);
        let merged = merge(Cow::Borrowed(&cut), |_| true);
        assert_eq!((merged.network.node_count(), merged.network.vessel_count()), (12, 18), "seed {seed}");
        let conditions = random_conditions(&mut draw, 12);
        let of =
            |network: &Network| simulate(network, &boundary(network, &conditions), VISCOSITY, &[]).map(|found| found.unperturbed);
        let (Ok(before), Ok(after)) = (of(&cut), of(&merged.network)) else { continue };
        let largest = before.vessels.iter().map(|v| v.flow.abs()).fold(0.0, f64::max);
        for (row, parts) in merged.parts.iter().enumerate() {
            let [start, end] = merged.network.ends(row).map(|node| merged.nodes[node]);
            let mut at = start;
            for part in parts {
                let [a, b] = cut.ends(*part);
                let (sign, next) = if a == at { (1.0, b) } else { (-1.0, a) };
                let (got, expected) = (after.vessels[row].flow, sign * before.vessels[*part].flow);
                assert!((got - expected).abs() < 1e-9 * largest, "seed {seed}: {got} for {expected}");
                at = next;
            }
            assert_eq!(at, end);
            let length: f64 = parts.iter().map(|part| cut.vessel(*part).length).sum();
            assert!((merged.network.vessel(row).length / length - 1.0).abs() < 1e-12);
            // Each part has three points, and two that meet share one.
            assert_eq!(merged.network.vessel(row).path.len(), 2 * parts.len() + 1);
        }
        for (node, was) in merged.nodes.iter().enumerate() {
            let [got, expected] = [after.pressure[node], before.pressure[*was]].map(|pressure| pressure.unwrap_or(f64::NAN));
            assert!(
                got.is_nan() && expected.is_nan() || (got - expected).abs() <= 1e-9 * expected.abs().max(1.0),
                "{got} for {expected}"
            );
        }
    }
}

/// 10 mm of 1 mm and 30 mm of 2 mm resist as 10/1⁴ + 30/2⁴ = 11.875: so does a tube of 40 mm with r⁴ = 40/11.875 mm⁴.
#[test]
fn two_parts_by_hand() {
    let row = |change: &dyn Fn(&mut Network)| {
        let mut row = network(3, [([0, 1], along(0.0, 10.0, 1.0)), ([2, 1], along(40.0, 10.0, 2.0))]);
        change(&mut row);
        merge(Cow::Owned(row), |_| true)
    };
    let merged = row(&|_| {});
    let vessel = merged.network.vessel(0);
    assert_eq!((merged.network.ends(0), &merged.nodes[..], &merged.parts[..]), ([0, 1], &[0, 2][..], &[vec![0, 1]][..]));
    assert!((vessel.length - 0.04).abs() < 1e-15);
    assert!((vessel.radius - 1e-3 * (40.0 / 11.875_f64).powf(0.25)).abs() < 1e-12);
    assert_eq!(vessel.path.iter().map(|p| (p.position[0] * 1e3).round()).collect::<Vec<_>>(), [0.0, 5.0, 10.0, 25.0, 40.0]);
    let both = row(&|n| (0..2).for_each(|v| n.vessel_mut(v).resistance = Some(2.0 + v as f64)));
    assert_eq!(both.network.vessel(0).resistance, Some(5.0));
    // What a person or a file says of a node or of one of the two keeps them apart.
    let apart: [(&str, &Change); 9] = [
        ("a resistance", &|n| n.vessel_mut(0).resistance = Some(2.0)),
        ("a label", &|n| n.vessel_mut(0).label = "M1".to_owned()),
        ("a candidate", &|n| n.vessel_mut(1).origin = Origin::Candidate),
        ("a wall", &|n| n.vessel_mut(1).wall = Some(Wall::Speed(5.0))),
        ("a prior", &|n| n.vessel_mut(1).prior = 0.5),
        ("a name", &|n| n.node_mut(1).label = "BA tip".to_owned()),
        ("a role", &|n| n.node_mut(1).role = Some(Role::Outlet)),
        ("the border", &|n| n.node_mut(1).at_border = true),
        ("no course", &|n| n.vessel_mut(0).path.clear()),
    ];
    for (what, change) in apart {
        assert_eq!(row(change).network.vessel_count(), 2, "{what}");
    }
    assert_eq!(
        merge(Cow::Owned(network(3, [([0, 1], along(0.0, 10.0, 1.0)), ([1, 2], along(10.0, 40.0, 2.0))])), |_| false).parts.len(),
        2
    );
}

/// A ring, alone or on a stem, keeps the nodes without which a vessel would run from a node to itself.
#[test]
fn no_vessel_comes_to_run_from_a_node_to_itself() {
    let piece = || along(0.0, 10.0, 1.0);
    let ring = |first: usize| [[first, first + 1], [first + 1, first + 2], [first + 2, first + 3], [first + 3, first]];
    let edges = ring(0).into_iter().chain(ring(4)).chain([[4, 8]]);
    let rings = network(9, edges.map(|ends| (ends, piece())));
    let merged = merge(Cow::Owned(rings), |_| true).network;
    assert!(merged.vessels().all(|([a, b], _)| a != b));
    assert_eq!((merged.vessel_count(), cycles(&merged)), (5, 2));
    assert_eq!(fed(&merged, |node| node == 0).iter().filter(|fed| **fed).count(), 2);
}
