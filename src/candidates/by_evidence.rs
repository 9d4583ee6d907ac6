//! Candidates by evidence: the bridges that may be, each with its probability.

use super::features::extraction::Extraction;
use super::model::belief::{Belief, believe};
use super::model::weights::Weights;
use super::search::branches::Target;
use super::search::by_evidence::{FoundBridge, Search, search};
use super::{Anchor, Attach, CandidateOptions, NetworkPoint, with_candidates};
use crate::error::Result;
use crate::network::{Evidence, Network};
use crate::support::geometry::distance;

/// Links less probable than this are left out ...
const LEAST_PROBABLE_LINK: f64 = 1e-3;
/// ... and loops less probable than this.
const LEAST_PROBABLE_LOOP: f64 = 1e-2;

/// Joins the fragments of the observed vessels by the bridges that the evidence allows.
///
/// Every candidate has its [`Evidence`], its probability is its prior, and every node knows how probably its fragment stays
/// alone. `inlets` are nodes where blood is known to enter. Rows and lengths are as [`super::build`] makes them.
///
/// # Errors
///
/// A parameter out of its range, a node without position or with more than 1000 vessels, or points that are crowded.
pub fn build_probable(network: &Network, inlets: &[usize], params: &CandidateOptions, weights: &Weights) -> Result<Network> {
    params.validate()?;
    let extraction = Extraction::new(network, inlets)?;
    let mut bridges =
        search(&extraction, &Search { branches: params.k.unwrap_or(Search::default().branches), ..Search::default() })?;
    bridges.retain(|b| {
        let gap = distance(extraction.position[extraction.ends[b.end].point], extraction.position[b.point]);
        let may_end = params.attach == Attach::Centerline || extraction.end_at[b.point].is_some();
        params.max_gap.is_none_or(|most| gap <= most) && may_end
    });
    let belief = believe(&extraction, &bridges, weights)?;
    let mut found = links(&extraction, &belief);
    let closes = belief.closures.iter().filter(|(_, p)| *p > LEAST_PROBABLE_LOOP);
    found.extend(closes.map(|(bridge, p)| {
        let continues = [Evidence::odds(*p), 0.0];
        (target(&extraction, *bridge), Some(Evidence { probability: *p, hangs: [0.0; 2], continues }))
    }));
    let (mut graph, node_at) = with_candidates(network, found, params);
    for (point, place) in extraction.place.iter().enumerate() {
        let node = match place {
            NetworkPoint::Node(node) => Some(node),
            NetworkPoint::Along { .. } => node_at.get(place),
        };
        if let Some(node) = node {
            graph.node_mut(*node).alone = Some(belief.alone[extraction.fragment[point]]);
        }
    }
    Ok(graph)
}

/// The links that are probable enough, by the first of their bridges.
fn links(extraction: &Extraction, belief: &Belief) -> Vec<(Target, Option<Evidence>)> {
    let count = belief.link.iter().max().map_or(0, |most| most + 1);
    let mut of_link: Vec<Option<(FoundBridge, f64, Evidence)>> = vec![None; count];
    let mut order = Vec::new();
    for (row, (bridge, link)) in belief.bridges.iter().zip(&belief.link).enumerate() {
        let p = belief.marginals.bridges[row];
        let odds = Evidence::odds_of_weight(belief.forests.bridges()[row].log_weight.exp());
        match &mut of_link[*link] {
            Some((_, sum, evidence)) => {
                *sum += p;
                (evidence.hangs[1], evidence.continues[1]) = (belief.hangs[row], odds);
            }
            empty => {
                let (hangs, continues) = ([belief.hangs[row], 0.0], [odds, 0.0]);
                *empty = Some((*bridge, p, Evidence { probability: belief.probability[row], hangs, continues }));
                order.push(*link);
            }
        }
    }
    let found = order.into_iter().filter_map(|link| of_link[link]);
    found
        .filter(|(_, sum, _)| *sum > LEAST_PROBABLE_LINK)
        .map(|(bridge, _, evidence)| (target(extraction, bridge), Some(evidence)))
        .collect()
}

fn target(extraction: &Extraction, bridge: FoundBridge) -> Target {
    let anchor =
        |point: usize, radius: f64| Anchor { place: extraction.place[point], position: extraction.position[point], radius };
    let end = &extraction.ends[bridge.end];
    let there = extraction.end_at[bridge.point].map(|end| extraction.ends[end].radius);
    Target {
        from: anchor(end.point, end.radius),
        to: anchor(bridge.point, there.unwrap_or(extraction.smooth.radius[bridge.point])),
    }
}
