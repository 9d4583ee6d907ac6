//! The ways between what lies at the two ends of a segment: along centerlines, and over the gaps that candidates cross.

use super::joins::probability_with;
use super::nodes::Nodes;
use super::states::{LABELS, label_of};
use crate::circle_of_willis::{Artery, RING};
use willis_core::network::paths::{ShortestPaths, lengths_at};
use willis_core::network::walks::Walk;
use willis_core::support::geometry::distance;

/// What a millimetre of centerline costs, and what one more costs where it is named as nothing that lies there.
const STEP: f64 = 0.05;
const ELSEWHERE: f64 = 0.5;
/// Twice the negative logarithm of a probability is a cost; no probability counts as smaller than these: of a name, of a candidate.
const LEAST_NAME: f64 = 1e-3;
const LEAST_CANDIDATE: f64 = 1e-4;

/// The cheapest way between the ends of a segment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Way {
    /// Its cost.
    pub cost: f64,
    /// The cost of the cheapest way along centerlines alone.
    pub observed: f64,
    /// The gaps on it, mm.
    pub gap: f64,
    /// The gaps on it in diameters of its vessels.
    pub diameters: f64,
    /// The expected length (mm) on it that has the segment's name.
    pub named: f64,
}

/// The ways of the segments of [`RING`], from the probabilities of the labels (nodes x labels) and the factors that names give to the odds of
/// the bridges.
pub fn ways(nodes: &Nodes, labels: &[[f64; LABELS]], bridge_factor: &[f64]) -> [Way; 7] {
    let mut paths = ShortestPaths::new(nodes.len() + 1);
    RING.map(|segment| way(nodes, labels, bridge_factor, segment, &mut paths))
}

/// The arteries at either end of a segment.
fn ends(segment: Artery) -> [Vec<Artery>; 2] {
    let [mut from, mut to] = segment.joins();
    match segment {
        Artery::A1(side) => {
            from.push(Artery::M1(side));
            to.push(Artery::AComm);
        }
        Artery::P1(side) => to.push(Artery::PComm(side)),
        _ => {}
    }
    [from, to]
}

fn way(nodes: &Nodes, labels: &[[f64; LABELS]], bridge_factor: &[f64], segment: Artery, paths: &mut ShortestPaths) -> Way {
    let own = label_of(segment);
    let of = |arteries: Vec<Artery>| -> Vec<f64> {
        let arteries: Vec<usize> = arteries.into_iter().map(label_of).collect();
        labels.iter().map(|p| arteries.iter().map(|artery| p[*artery]).sum()).collect()
    };
    let [from, to] = ends(segment).map(of);
    let belongs: Vec<f64> = (0..nodes.len()).map(|n| (from[n] + to[n] + labels[n][own]).min(1.0)).collect();
    let elsewhere = |[a, b]: [usize; 2], length: f64| ELSEWHERE * length * (1.0 - 0.5 * (belongs[a] + belongs[b]));
    let improbable = |p: f64, least: f64| -2.0 * p.max(least).ln();
    let start = nodes.len();
    let links = nodes.links.iter().map(|[a, b]| {
        let length = distance(nodes.at[*a], nodes.at[*b]);
        ([*a, *b], STEP * length + elsewhere([*a, *b], length))
    });
    let bridges = nodes.bridges.iter().zip(bridge_factor).map(|(bridge, factor)| {
        let probability = probability_with(bridge.probability, *factor);
        (bridge.nodes, improbable(probability, LEAST_CANDIDATE) + elsewhere(bridge.nodes, bridge.gap))
    });
    // Edges: links, then bridges; the last ones lead from the start to every node as far as it is what lies at the first end.
    let edges: Vec<([usize; 2], f64)> = links.chain(bridges).collect();
    let arrival: Vec<f64> = to.iter().map(|p| improbable(p.min(1.0), LEAST_NAME)).collect();
    let mut by = |edges: &[([usize; 2], f64)]| {
        let mut at = lengths_at(start + 1, edges.iter().enumerate().map(|(number, (ends, cost))| (number, *ends, *cost)));
        at[start] = from.iter().enumerate().map(|(n, p)| (usize::MAX, n, improbable(p.min(1.0), LEAST_NAME))).collect();
        cheapest(paths, start, &at, &arrival)
    };
    let (observed, _) = by(&edges[..nodes.links.len()]);
    let (cost, end) = by(&edges);
    let Walk { nodes: mut along, edges: used } = paths.path_to(end);
    along.retain(|n| *n != start);
    let bridges = used.iter().filter_map(|edge| edge.checked_sub(nodes.links.len())).filter_map(|row| nodes.bridges.get(row));
    let gap: f64 = bridges.map(|bridge| bridge.gap).sum();
    let mut radii: Vec<f64> = along.iter().map(|n| nodes.log_radius[*n]).collect();
    radii.sort_by(f64::total_cmp);
    let middle = 0.5 * (radii[(radii.len() - 1) / 2] + radii[radii.len() / 2]);
    Way {
        cost,
        observed,
        gap,
        diameters: gap / (2.0 * middle.exp()),
        named: along.iter().map(|n| labels[*n][own] * nodes.weight[*n]).sum(),
    }
}

/// The least cost of a way from the start that ends at any node, with the cost of ending there; and that node.
fn cheapest(paths: &mut ShortestPaths, start: usize, edges: &[Vec<(usize, usize, f64)>], arrival: &[f64]) -> (f64, usize) {
    let mut best = (f64::INFINITY, 0);
    paths.search(
        &[start],
        f64::INFINITY,
        |node| edges[node].iter().copied(),
        |costs, node| {
            if node != start && costs[node] + arrival[node] < best.0 {
                best = (costs[node] + arrival[node], node);
            }
            costs[node] < best.0
        },
    );
    best
}
