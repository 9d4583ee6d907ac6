//! The vessels of a network with their names, divided where the name changes along them.

use std::collections::BTreeSet;
use std::ops::Range;

use super::Names;
use super::atlas::{ArteryLabel, OTHER, most_probable, name_of};
use super::nodes::is_traced;
use willis_core::network::path_places::PathPlace;
use willis_core::network::walks::{edges_at, other};
use willis_core::network::{Network, Node, Origin, RadiusRule, Vessel, units::metres};
use willis_core::support::{
    arc_lengths::{arc_lengths, in_direction, place_at},
    numbered::grouped,
};

/// A contact from this probability on is a connection.
const CONNECTED: f64 = 0.5;

/// A piece of a vessel: its nodes, and the probability of its name.
type NamedPiece = ([usize; 2], Vessel, Option<f64>);

/// A run of one name along a vessel: how far (m along it), the name, and its mean probability.
struct NameRun {
    until: f64,
    label: ArteryLabel,
    probability: f64,
}

/// The traced vessels of a graph with their names, the connections that an earlier run kept, or probable contacts, and the probability of each
/// name; vessels without one have an empty label and none. The first nodes are the input's `own`, as it states them; of the others those are gone
/// at which only a candidate had divided a vessel. Vessels that are divided or put together again have radii by the `rule`.
pub fn labelled_network(graph: &Network, own: &[Node], names: &Names, rule: RadiusRule) -> (Network, Vec<Option<f64>>) {
    let places = names.nodes.place.iter().enumerate();
    let by_vessel = grouped(graph.vessel_count(), places.map(|(n, place)| (place.vessel, n)));
    let traced = is_traced(graph);
    let mut nodes: Vec<Node> = own.iter().chain(graph.nodes().skip(own.len())).cloned().collect();
    let mut taken: BTreeSet<String> = nodes.iter().map(|node| node.id.clone()).collect();
    let mut pieces: Vec<Option<NamedPiece>> = Vec::new();
    for (row, (ends, vessel)) in graph.vessels().enumerate() {
        let is_probable = || vessel.evidence().is_some_and(|evidence| evidence.probability >= CONNECTED);
        let connects = vessel.kept == Some(true) || vessel.origin == Origin::Contact && is_probable();
        if !traced[row] && !connects {
            continue;
        }
        let runs = runs_of(&by_vessel[row], names);
        let path = graph.path_of(row);
        let arc = arc_lengths(path.iter().map(|point| point.position));
        let whole = arc[arc.len() - 1];
        if runs.len() < 2 || whole <= 0.0 {
            pieces.push(Some(named(ends, vessel.clone(), runs.first())));
            continue;
        }
        let changes = runs[..runs.len() - 1].iter().map(|run| place_at(&arc, run.until));
        let changes = changes.map(|(point, share)| PathPlace { point, share });
        let parts = vessel.parts(ends, &path, changes, rule, |_, at| {
            let mut id = format!("{}~{}", graph.node(ends[0]).id, nodes.len());
            while !taken.insert(id.clone()) {
                id.push('~');
            }
            nodes.push(Node::at(id, at));
            nodes.len() - 1
        });
        pieces.extend(parts.into_iter().zip(&runs).map(|((ends, part), run)| Some(named(ends, part, Some(run)))));
    }
    merge(&mut pieces, &nodes, own.len()..graph.node_count(), rule);
    let mut out = Network::new();
    out.frame = graph.frame;
    let mut row = vec![usize::MAX; nodes.len()];
    let mut probability = Vec::new();
    let used: BTreeSet<usize> = pieces.iter().flatten().flat_map(|(ends, ..)| *ends).collect();
    for (n, node) in nodes.into_iter().enumerate().filter(|(n, _)| *n < own.len() || used.contains(n)) {
        row[n] = out.add_node(node);
    }
    for (ends, vessel, p) in pieces.into_iter().flatten() {
        out.add_vessel(ends.map(|end| row[end]), vessel);
        probability.push(p);
    }
    (out, probability)
}

/// The runs of names along a vessel, from the nodes that lie on it.
fn runs_of(own: &[usize], names: &Names) -> Vec<NameRun> {
    let along = |n: usize| names.nodes.place[n].along;
    let label = |n: usize| most_probable(&names.labels[n]);
    let mut order: Vec<usize> = own.to_vec();
    order.sort_by(|a, b| along(*a).total_cmp(&along(*b)));
    let runs: Vec<&[usize]> = order.chunk_by(|a, b| label(*a) == label(*b)).collect();
    let run = |(at, run): (usize, &&[usize])| {
        let (label, last) = (label(run[0]), metres(along(run[run.len() - 1])));
        let sum: f64 = run.iter().map(|n| names.labels[*n][label]).sum();
        let until = runs.get(at + 1).map_or(f64::INFINITY, |next| 0.5 * (last + metres(along(next[0]))));
        NameRun { until, label, probability: sum / run.len() as f64 }
    };
    runs.iter().enumerate().map(run).collect()
}

/// A vessel with the name of a run; without one it has none.
fn named(ends: [usize; 2], vessel: Vessel, run: Option<&NameRun>) -> NamedPiece {
    let run = run.filter(|run| run.label != OTHER);
    let label = run.map_or_else(String::new, |run| name_of(run.label));
    (ends, Vessel { label, origin: Origin::Observed, evidence: None, ..vessel }, run.map(|run| run.probability))
}

/// Joins pieces of one name at the nodes where only a candidate had divided their vessel.
fn merge(pieces: &mut [Option<NamedPiece>], nodes: &[Node], divided: Range<usize>, rule: RadiusRule) {
    let ends = |(row, piece): (usize, &Option<NamedPiece>)| piece.as_ref().map(|(ends, ..)| (row, *ends));
    let mut at = edges_at(nodes.len(), pieces.iter().enumerate().filter_map(ends));
    let positions = |ends: [usize; 2]| ends.map(|end| nodes[end].position.unwrap_or_default());
    for node in divided {
        let [first, second] = at[node][..] else { continue };
        if first == second {
            continue;
        }
        let (Some((ends_a, a, p)), Some((ends_b, b, q))) = (pieces[first].clone(), pieces[second].clone()) else { continue };
        if a.label != b.label {
            continue;
        }
        let [from, to] = [ends_a, ends_b].map(|ends| other(ends, node));
        let mut path = in_direction(a.path_between(positions(ends_a)), ends_a[1] == node);
        path.extend(in_direction(b.path_between(positions(ends_b)), ends_b[1] != node).into_iter().skip(1));
        path.dedup_by_key(|point| point.position);
        let length = a.length + b.length;
        let probability = p.zip(q).map(|(p, q)| (p * a.length + q * b.length) / length.max(1e-12));
        let resistance = a.resistance.zip(b.resistance).map(|(a, b)| a + b);
        let vessel = Vessel { length, radius: rule.radius(&path), resistance, path, ..a };
        pieces[first] = Some(([from, to], vessel, probability));
        pieces[second] = None;
        at[to].iter_mut().filter(|row| **row == second).for_each(|row| *row = first);
        at[node].clear();
    }
}
