//! Candidates by evidence: the bridges that may be, each with its probability.

use std::collections::BTreeMap;

use super::attach::Target;
use super::evidence::{Bridge, Extraction, Search, search};
use super::prior::{Belief, Weights, alone, believe};
use super::{Attach, Params, Place, Site, with_candidates};
use crate::error::Result;
use crate::geometry::distance;
use crate::network::{Evidence, Network};

/// Links less probable than this are left out.
const LEAST_PROBABILITY: f64 = 1e-3;
/// Bridges from one end to one fragment are nearly equal where they meet it within the largest of so many spacings, ...
const NEAR_SPACINGS: f64 = 3.0;
/// ... so many radii there, ...
const NEAR_RADII: f64 = 2.0;
/// ... and so many gaps: closer, no image tells them apart.
const NEAR_GAPS: f64 = 0.75;
/// A bridge stands for two fragments in place of a more probable one where it has so much more probability around it, ...
const MUCH_MORE: f64 = 0.25;
/// ... and itself at least so much of the other's.
const NOT_MUCH_LESS: f64 = 0.5;

/// Joins the fragments of the observed vessels by the bridges that the evidence allows.
///
/// Every candidate has its [`Evidence`], its probability is its prior, and every node knows how probably its fragment stays
/// alone. `inlets` are nodes where blood is known to enter. Rows and lengths are as [`super::build`] makes them.
///
/// # Errors
///
/// A parameter out of its range, or a node without position.
pub fn build_probable(network: &Network, inlets: &[usize], params: &Params, weights: &Weights) -> Result<Network> {
    params.validate()?;
    let extraction = Extraction::new(network, inlets)?;
    let mut bridges = search(&extraction, &Search { branches: params.k, ..Search::default() });
    bridges.retain(|b| {
        let gap = distance(extraction.position[extraction.ends[b.end].point], extraction.position[b.point]);
        let may_end = params.attach == Attach::Centerline || extraction.end_at[b.point].is_some();
        params.max_gap.is_none_or(|most| gap <= most) && may_end
    });
    let belief = believe(&extraction, &bridges, weights)?;
    let alone = alone(&extraction, &belief);
    let (mut graph, node_at) = with_candidates(network, links(&extraction, &belief), params);
    for (point, place) in extraction.place.iter().enumerate() {
        let node = match place {
            Place::Node(node) => Some(node),
            Place::Along { .. } => node_at.get(place),
        };
        if let Some(node) = node {
            graph.node_mut(*node).alone = Some(alone[extraction.fragment[point]]);
        }
    }
    Ok(graph)
}

/// The links that are probable enough, by the first of their bridges.
fn links(extraction: &Extraction, belief: &Belief) -> Vec<(Target, Option<Evidence>)> {
    let hangs = hangs(extraction, belief);
    let count = belief.link.iter().max().map_or(0, |most| most + 1);
    let mut of_link: Vec<Option<(Bridge, f64, [f64; 2])>> = vec![None; count];
    let mut order = Vec::new();
    for (row, (bridge, link)) in belief.bridges.iter().zip(&belief.link).enumerate() {
        let p = belief.marginals.bridges[row];
        match &mut of_link[*link] {
            Some((_, sum, ways)) => (*sum, ways[1]) = (*sum + p, hangs[row]),
            empty => {
                *empty = Some((*bridge, p, [hangs[row], 0.0]));
                order.push((row, *link));
            }
        }
    }
    let found = order.into_iter().filter_map(|(row, link)| of_link[link].map(|found| (row, found)));
    found
        .filter(|(_, (_, sum, _))| *sum > LEAST_PROBABILITY)
        .map(|(row, (bridge, _, hangs))| {
            (target(extraction, bridge), Some(Evidence { probability: belief.probability[row], hangs }))
        })
        .collect()
}

fn target(extraction: &Extraction, bridge: Bridge) -> Target {
    let site = |point: usize, radius: f64| Site { place: extraction.place[point], position: extraction.position[point], radius };
    let end = &extraction.ends[bridge.end];
    let there = extraction.end_at[bridge.point].map(|end| extraction.ends[end].radius);
    Target {
        from: site(end.point, end.radius),
        site: site(bridge.point, there.unwrap_or(extraction.smooth.radius[bridge.point])),
    }
}

/// Per bridge what speaks for hanging its child by it: its marginal, and for the one bridge that stands for its child and
/// parent those of the bridges nearly equal to it. A search offers several meeting points a few voxels apart, which share the
/// probability of one connection.
fn hangs(extraction: &Extraction, belief: &Belief) -> Vec<f64> {
    let own = &belief.marginals.bridges;
    let parent = |b: &Bridge| extraction.fragment[b.point];
    let mut alike: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (row, bridge) in belief.bridges.iter().enumerate() {
        alike.entry((bridge.end, parent(bridge))).or_default().push(row);
    }
    let at = |row: usize| extraction.position[belief.bridges[row].point];
    let mass = |row: usize| {
        let bridge = &belief.bridges[row];
        let gap = distance(at(row), extraction.position[extraction.ends[bridge.end].point]);
        let near = (NEAR_SPACINGS * extraction.spacing).max(NEAR_RADII * extraction.smooth.radius[bridge.point]);
        // A hair's breadth, so that no rounding decides on voxel grids.
        let near = near.max(NEAR_GAPS * gap) * (1.0 + 1e-9);
        let rows = alike[&(bridge.end, parent(bridge))].iter();
        rows.filter(|other| distance(at(**other), at(row)) <= near).map(|other| own[*other]).sum::<f64>().min(1.0)
    };
    let masses: Vec<f64> = (0..own.len()).map(mass).collect();
    let mut order: Vec<usize> = (0..own.len()).collect();
    order.sort_by(|a, b| own[*b].total_cmp(&own[*a]).then(a.cmp(b)));
    let mut best: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for row in order {
        let bridge = &belief.bridges[row];
        let stands = best.entry([extraction.ends[bridge.end].fragment, parent(bridge)]).or_insert(row);
        if masses[row] * (1.0 - MUCH_MORE) > masses[*stands] && own[row] > NOT_MUCH_LESS * own[*stands] {
            *stands = row;
        }
    }
    let mut hangs = own.clone();
    for row in best.into_values() {
        hangs[row] = masses[row];
    }
    hangs
}
