//! The part of a network that may be the circle: all of a small one, of a whole brain what lies on the atlas.

use super::atlas::{Atlas, all_states, arteries};
use super::emission::Pose;
use super::nodes::Nodes;
use super::pose::{Pulls, Scored, Search};
use willis_core::support::geometry::{distance, dot, sub};
use willis_core::support::statistics::weighted_quantile;

/// Networks of more length (mm) than this are whole brains: a circle with all that its image shows has some 300 to 700.
const WHOLE_BRAIN: f64 = 1500.0;
/// Vessels in this share of the length are thick.
const THICK: f64 = 0.90;
/// The circle lies within this distance (mm) of the middle of the thick vessels.
const REACH: f64 = 45.0;
/// Of these, vessels above this share of the length serve the search of the pose.
const SEARCHED: f64 = 0.55;
/// Pieces of less length (mm) do not serve it.
const LEAST_SEARCHED: f64 = 8.0;
/// What lies within so many standard deviations of a state is named, in pieces of at least so much (mm).
const ON_ATLAS: f64 = 2.5;
const LEAST_NAMED: f64 = 6.0;

/// What is to be named.
pub struct Core {
    /// Its nodes.
    pub nodes: Nodes,
    /// The median log radius where it is not that of these nodes.
    pub median_log_radius: Option<f64>,
}

/// What lies on the atlas at a pose, in pieces that are long enough.
fn on_the_atlas(nodes: &Nodes, atlas: &Atlas, pose: &Pose) -> Nodes {
    let lies_there = |n: usize| {
        let at = pose.apply(nodes.at[n]);
        arteries().any(|state| {
            let d = sub(at, atlas.data.pieces[state].mean);
            dot(d, super::symmetric_times(&atlas.position[state].0, d)) < ON_ATLAS * ON_ATLAS
        })
    };
    nodes.part(lies_there, LEAST_NAMED)
}

/// The core of a network whose pose is known.
pub fn at(nodes: Nodes, atlas: &Atlas, pose: &Pose) -> Option<Core> {
    if nodes.length() <= WHOLE_BRAIN {
        return Some(Core { nodes, median_log_radius: None });
    }
    let named = on_the_atlas(&nodes, atlas, pose);
    let median = named.median_log_radius(|_| 1.0);
    (!named.is_empty()).then_some(Core { nodes: named, median_log_radius: Some(median) })
}

/// The core of a network and its poses, the best first.
pub fn find(nodes: Nodes, atlas: &Atlas) -> Option<(Core, Vec<Scored>)> {
    if nodes.length() <= WHOLE_BRAIN {
        let poses = search(&nodes, atlas);
        return (!poses.is_empty()).then_some((Core { nodes, median_log_radius: None }, poses));
    }
    let radius = branch_radii(&nodes);
    let length_below = |counts: &dyn Fn(usize) -> bool, share: f64| {
        let those = (0..nodes.len()).filter(|n| counts(*n)).map(|n| (radius[n], nodes.weight[n]));
        weighted_quantile(those, share).unwrap_or(f64::INFINITY)
    };
    let thick = length_below(&|_| true, THICK);
    let of_thick: Vec<usize> = (0..nodes.len()).filter(|n| radius[*n] >= thick).collect();
    let middle = [0, 1, 2].map(|k| {
        let mut x: Vec<f64> = of_thick.iter().map(|n| nodes.at[*n][k]).collect();
        x.sort_by(f64::total_cmp);
        x.get(x.len() / 2).copied().unwrap_or_default()
    });
    let near = |n: usize| distance(nodes.at[n], middle) < REACH;
    let least = length_below(&near, SEARCHED);
    let searched = nodes.part(|n| near(n) && radius[n] >= least, LEAST_SEARCHED);
    if searched.is_empty() {
        return None;
    }
    let median = searched.median_log_radius(|_| 1.0);
    let mut pose = search(&searched, atlas).first()?.pose;
    let named = on_the_atlas(&nodes, atlas, &pose);
    if named.is_empty() {
        return None;
    }
    let weight = vec![1.0; named.len()];
    let search = Search::new(&named, atlas, &weight, &named.spanning_bridges(|_| true), median);
    let all: Vec<usize> = (0..named.len()).collect();
    let pulls = Pulls::of(atlas, &all_states(), &atlas.position);
    for _ in 0..3 {
        pose = search.named_step(&all, &pose, &pulls, &atlas.position);
    }
    Some((Core { nodes: named, median_log_radius: Some(median) }, vec![Scored { pose, score: 0.0 }]))
}

fn search(nodes: &Nodes, atlas: &Atlas) -> Vec<Scored> {
    let (weight, median) = (vec![1.0; nodes.len()], nodes.median_log_radius(|_| 1.0));
    Search::new(nodes, atlas, &weight, &nodes.spanning_bridges(|_| true), median).everywhere()
}

/// Per node the mean radius of its branch, mm.
fn branch_radii(nodes: &Nodes) -> Vec<f64> {
    let (mut sum, mut length) = (vec![0.0; nodes.branches], vec![1e-9; nodes.branches]);
    for n in 0..nodes.len() {
        sum[nodes.branch[n]] += nodes.log_radius[n].exp() * nodes.weight[n];
        length[nodes.branch[n]] += nodes.weight[n];
    }
    nodes.branch.iter().map(|b| sum[*b] / length[*b]).collect()
}
