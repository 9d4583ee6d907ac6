//! How a candidate compares with the others that want the same places: by cost before any model, by probability after the first pass.

use std::collections::{BTreeMap, BTreeSet};

use ndarray::Array2;

use super::course::EndCourse;
use crate::candidates::features::Extraction;
use crate::candidates::pairs::{Pairs, unordered};
use crate::candidates::search::point_index::PointIndex;
use crate::candidates::search::{EndCandidate, rows_by_end};
use willis_core::support::geometry::{dot, norm_squared, sub};
use willis_core::support::statistics::sigmoid;
use willis_core::support::ties::steady;

/// Bound of a margin of costs.
const MOST_MARGIN: f64 = 2.0;
/// Candidates to one vessel between its ends are rivals within so many spacings and a radius.
const SITE_SPACINGS: f64 = 2.5;
/// Other free ends count as nearer ones up to this share of the gap, and within a cone of at least this cosine.
const NEARER: f64 = 0.98;
const CONE_COS: f64 = 0.7;

/// Other candidates for the same places, compared by cost.
#[derive(Debug, Clone, Copy, Default)]
pub struct Rivals {
    /// Branches that cost less from the child.
    pub rank: usize,
    /// Cost less that of the best other branch, in [-2, 2].
    pub margin: f64,
    /// Whether both free ends prefer each other's branch.
    pub mutual: bool,
    /// Fragments with a cheaper candidate to the same place.
    pub site_rank: usize,
    /// Cost less that of the best of them, in [-2, 2].
    pub site_margin: f64,
    /// Cheaper pairs of points between the same two fragments.
    pub pair_rank: usize,
    /// Free ends of other fragments that are nearer and no further off the course.
    pub in_cone: usize,
}

fn site(e: &Extraction, point: usize) -> f64 {
    SITE_SPACINGS * e.spacing + e.radius_at(point)
}

/// Compares the candidates of one search by their costs.
pub fn rivals(e: &Extraction, courses: &[EndCourse], candidates: &[EndCandidate], costs: &[f64]) -> Vec<Rivals> {
    let costs: Vec<f64> = costs.iter().map(|c| steady(*c)).collect();
    let mut out = vec![Rivals::default(); candidates.len()];
    let of_end = rows_by_end(e, candidates);
    // Per free end the branches that are cheapest from it.
    let mut preferred: Vec<Option<usize>> = vec![None; e.ends.len()];
    for (end, rows) in of_end.iter().enumerate() {
        let mut best: BTreeMap<usize, f64> = BTreeMap::new();
        for row in rows {
            let least = best.entry(e.branch[candidates[*row].point]).or_insert(f64::INFINITY);
            *least = least.min(costs[*row]);
        }
        let mut in_order: Vec<(f64, usize)> = best.iter().map(|(branch, cost)| (*cost, *branch)).collect();
        in_order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        preferred[end] = in_order.first().map(|(_, branch)| *branch);
        for row in rows {
            let own = best[&e.branch[candidates[*row].point]];
            let rank = in_order.iter().take_while(|(cost, _)| *cost < own).count();
            let other = if rank > 0 { Some(in_order[0].0) } else { in_order.get(1).map(|(cost, _)| *cost) };
            out[*row].rank = rank;
            out[*row].margin = (costs[*row] - other.unwrap_or(own + MOST_MARGIN)).clamp(-MOST_MARGIN, MOST_MARGIN);
        }
    }
    let sites = PointIndex::new(candidates.iter().map(|c| e.position[c.point]).collect());
    let mut by_fragments: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    for (row, c) in candidates.iter().enumerate() {
        by_fragments.entry(unordered(c.fragments(e))).or_default().push(row);
        let own_branch = e.ends[c.end].branch;
        let there = e.end_at[c.point].and_then(|end| preferred[end]);
        out[row].mutual = there == Some(own_branch) && preferred[c.end] == Some(e.branch[c.point]);
        let near = sites.around(e.position[c.point], site(e, c.point)).into_iter().map(|(_, other)| other);
        let [child, parent] = c.fragments(e);
        let rivals: Vec<usize> =
            near.filter(|o| e.fragment[candidates[*o].point] == parent && e.ends[candidates[*o].end].fragment != child).collect();
        let cheaper = rivals.iter().filter(|o| costs[**o] < costs[row]).map(|o| e.ends[candidates[*o].end].fragment);
        out[row].site_rank = cheaper.collect::<BTreeSet<usize>>().len();
        let best = rivals.iter().map(|o| costs[*o]).fold(f64::INFINITY, f64::min);
        out[row].site_margin = (costs[row] - best).clamp(-MOST_MARGIN, MOST_MARGIN);
        out[row].in_cone = in_cone(e, &courses[c.end], c);
    }
    let pairs = Pairs::new(e, candidates);
    for rows in by_fragments.values() {
        let mut cheapest: BTreeMap<usize, f64> = BTreeMap::new();
        for row in rows {
            let least = cheapest.entry(pairs.of[*row]).or_insert(f64::INFINITY);
            *least = least.min(costs[*row]);
        }
        for row in rows {
            out[*row].pair_rank = cheapest.iter().filter(|(pair, cost)| **pair != pairs.of[*row] && **cost < costs[*row]).count();
        }
    }
    out
}

/// Free ends of other fragments that are nearer than the candidate's point and no further off the child's course.
fn in_cone(e: &Extraction, course: &EndCourse, c: &EndCandidate) -> usize {
    let end = &e.ends[c.end];
    let across = sub(e.position[c.point], e.position[end.point]);
    let gap = norm_squared(across).sqrt();
    let along = course.directions[1];
    let least = steady((dot(across, along) / gap.max(f64::MIN_POSITIVE)).max(CONE_COS));
    let near = e.index.around(e.position[end.point], NEARER * gap).into_iter();
    near.filter(|(away, point)| {
        let to = sub(e.position[*point], e.position[end.point]);
        e.end_at[*point].is_some() && e.fragment[*point] != end.fragment && *away > 0.0 && steady(dot(to, along) / away) > least
    })
    .count()
}

/// How many features the second pass has of the first: the mean score of both directions and the own one; of the others at the child, and
/// of those at the parent, the best, the sum of probabilities and the margin; the sums of both fragments, the best way by a third fragment, and
/// the best and the sum of the other pairs of these two.
pub const SECOND_FEATURES: usize = 13;

/// A score where there is no other candidate, and the bound of all features.
const NO_SCORE: f64 = -8.0;
const MOST: f64 = 12.0;
const MOST_SUM: f64 = 3.0;
/// Pairs of fragments less probable than this lead nowhere.
const LEAST_STEP: f64 = 0.02;
const LEAST_TWO_STEPS: f64 = 1e-3;

/// The features of the second pass that come from the scores (log-odds) of the first: a row a candidate, a column one of [`SECOND_FEATURES`].
pub fn second_features(e: &Extraction, candidates: &[EndCandidate], pairs: &Pairs, scores: &[f64]) -> Array2<f64> {
    let score = pairs.mean(scores);
    let p: Vec<f64> = score.iter().map(|s| sigmoid(*s)).collect();
    let firsts: Vec<&EndCandidate> = pairs.first.iter().map(|row| &candidates[*row]).collect();
    let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let mut between: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
    let mut of_fragment = vec![0.0; e.fragments.len()];
    let mut steps: Vec<BTreeMap<usize, f64>> = vec![BTreeMap::new(); e.fragments.len()];
    for (pair, c) in firsts.iter().enumerate() {
        pairs.points[pair].iter().for_each(|point| at.entry(*point).or_default().push(pair));
        let [a, b] = c.fragments(e);
        between.entry(unordered([a, b])).or_default().push(pair);
        of_fragment[a] += p[pair];
        of_fragment[b] += p[pair];
        if a != b && p[pair] > LEAST_STEP {
            for (from, to) in [(a, b), (b, a)] {
                let most = steps[from].entry(to).or_insert(0.0);
                *most = most.max(p[pair]);
            }
        }
    }
    let sites = PointIndex::new(firsts.iter().map(|c| e.position[c.point]).collect());
    let best_and_sum = |rivals: &[usize]| {
        let best = rivals.iter().map(|pair| score[*pair]).fold(NO_SCORE, f64::max);
        (best, rivals.iter().map(|pair| p[*pair]).sum::<f64>().min(MOST_SUM))
    };
    let mut out = Array2::zeros((candidates.len(), SECOND_FEATURES));
    for (row, c) in candidates.iter().enumerate() {
        let (pair, child) = (pairs.of[row], e.ends[c.end].point);
        let other_place = |pair: &usize, from: usize| {
            let [a, b] = pairs.points[*pair];
            if a == from { b } else { a }
        };
        let elsewhere = |from: usize, to: usize| -> Vec<usize> {
            at[&from].iter().copied().filter(|pair| e.branch[other_place(pair, from)] != e.branch[to]).collect()
        };
        let at_child = best_and_sum(&elsewhere(child, c.point));
        let [own, parent] = c.fragments(e);
        let at_parent = if e.end_at[c.point].is_some() {
            best_and_sum(&elsewhere(c.point, child))
        } else {
            let near = sites.within(e.position[c.point], site(e, c.point)).into_iter().map(|(_, pair)| pair);
            let rivals = near.filter(|o| e.fragment[firsts[*o].point] == parent && e.ends[firsts[*o].end].point != child);
            best_and_sum(&rivals.collect::<Vec<usize>>())
        };
        let (few, many) = if steps[own].len() < steps[parent].len() { (own, parent) } else { (parent, own) };
        let two = |(via, p): (&usize, &f64)| steps[many].get(via).map(|q| p * q);
        let two_steps = if own == parent { 0.0 } else { steps[few].iter().filter_map(two).fold(0.0, f64::max) };
        let same = &between[&unordered([own, parent])];
        let others = same.iter().filter(|o| **o != pair);
        let features: [f64; SECOND_FEATURES] = [
            score[pair],
            scores[row],
            at_child.0,
            at_child.1,
            score[pair] - at_child.0,
            at_parent.0,
            at_parent.1,
            score[pair] - at_parent.0,
            of_fragment[own] - p[pair],
            of_fragment[parent] - p[pair],
            (two_steps + LEAST_TWO_STEPS).ln(),
            others.clone().map(|o| score[*o]).fold(NO_SCORE, f64::max),
            others.map(|o| p[*o]).sum(),
        ];
        for (column, x) in features.into_iter().enumerate() {
            out[[row, column]] = x.clamp(-MOST, MOST);
        }
    }
    out
}
