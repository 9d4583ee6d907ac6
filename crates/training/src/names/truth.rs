//! The true state of every node of a labelled case: its artery, and how far along it from the artery's reference end.

use std::collections::BTreeMap;

use willis_core::network::Network;
use willis_core::network::paths::ShortestPaths;
use willis_core::support::geometry::{Point, distance};
use willis_models::circle_of_willis::{Artery, BodySide, Direction};
use willis_models::naming::Nodes;
use willis_models::naming::states::{ArteryLabel, AtlasState, NOWHERE, OTHER, artery_of, begins, begins_at, state_at};

/// The nodes of a case with what they are.
#[derive(Debug, Clone)]
pub struct LabelledNodes {
    /// The nodes.
    pub nodes: Nodes,
    /// The label of each.
    pub label: Vec<ArteryLabel>,
    /// The state of each.
    pub state: Vec<AtlasState>,
}

/// The nodes of a graph with the labels of the points that they lie nearest to.
pub fn label_nodes(graph: &Network, labels: &BTreeMap<u64, ArteryLabel>) -> LabelledNodes {
    let nodes = Nodes::of(graph);
    let label: Vec<ArteryLabel> = nodes.id.iter().map(|id| id.and_then(|id| labels.get(&id)).copied().unwrap_or(OTHER)).collect();
    let state = true_states(&nodes, &label);
    LabelledNodes { nodes, label, state }
}

/// The states of nodes whose labels are known.
fn true_states(nodes: &Nodes, label: &[ArteryLabel]) -> Vec<AtlasState> {
    let mut state = vec![NOWHERE; nodes.len()];
    let mut paths = ShortestPaths::new(nodes.len());
    for artery in 0..OTHER {
        let own: Vec<usize> = (0..nodes.len()).filter(|n| label[*n] == artery).collect();
        if own.is_empty() {
            continue;
        }
        let is_reference = |n: &usize| nodes.neighbours[*n].iter().any(|z| label[*z] != artery && begins_at(artery, label[*z]));
        let mut sources: Vec<usize> = own.iter().copied().filter(is_reference).collect();
        if sources.is_empty() {
            let highest =
                |best: usize, n: &usize| if height(nodes.at[*n], artery) > height(nodes.at[best], artery) { *n } else { best };
            sources.push(own.iter().fold(own[0], highest));
        }
        let edges = |n: usize| {
            let next = nodes.neighbours[n].iter().filter(|z| label[**z] == artery);
            next.map(|z| (0, *z, distance(nodes.at[n], nodes.at[*z]))).collect::<Vec<_>>()
        };
        paths.search(&sources, f64::INFINITY, edges, |_, _| true);
        let along = paths.lengths();
        for n in &own {
            let far = if along[*n].is_finite() {
                along[*n]
            } else {
                // A second part of the artery, behind a gap.
                let reached = own.iter().filter(|q| along[**q].is_finite());
                reached
                    .map(|q| (distance(nodes.at[*q], nodes.at[*n]), *q))
                    .min_by(|a, b| a.0.total_cmp(&b.0))
                    .map_or(0.0, |(d, q)| along[q] + d)
            };
            state[*n] = state_at(artery, far);
        }
    }
    state
}

/// How far a position lies in the direction in which the reference end of an artery is expected.
fn height(at: Point, artery: ArteryLabel) -> f64 {
    let medial = if artery_of(artery).and_then(Artery::side) == Some(BodySide::Right) { -at[0] } else { at[0] };
    match begins(artery) {
        Direction::Up => at[2],
        Direction::Down => -at[2],
        Direction::Front => at[1],
        Direction::Medial => medial,
        Direction::Lateral => -medial,
    }
}
