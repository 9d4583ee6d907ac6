//! Features of a candidate from a posterior: probable candidates nearby speak for or against this one.
//!
//! The posterior of [`FEATURES`](super::FEATURES) alone says where blood probably enters each fragment. From that follow its direction
//! at every point, which meeting points are taken, and which fragments are fed. A second posterior uses all of these.

use ndarray::Array2;

use super::extraction::{Extraction, FreeEnd};
use crate::candidates::search::{EndCandidate, PointIndex, rows_by_end};
use willis_core::forest_posterior::{Forests, Marginals, rooted_in};
use willis_core::support::geometry::{dot, sub, unit};
use willis_core::support::numbered::{counted, grouped};
use willis_core::support::ties::steady;

/// The features of a candidate from a posterior, by the names that weights have in a file. P is the probability of a candidate.
///
/// - `with_flow`: -F t·u where the parent is met between its ends, else 0: t its tangent, u across the gap from the child, F the entries
///   of blood to expect behind the point less those ahead. A branch goes on with the flow.
/// - `step_with_flow`: F ln r₁/r₂ where the parent is met between its ends, else 0: r₁ the parent's radius behind, r₂ ahead. A vessel is thinner
///   after a branch.
/// - `entered_there`: Σ P of the candidates that attach the parent elsewhere by the free end that is met; 0 between its ends. An end has one
///   neighbour.
/// - `claims_on_end`: Σ P of the candidates that attach other fragments than the parent to the child's end.
/// - `fed_otherwise`: the probability that the parent is fed, by an inlet, without the child's help. No candidate may close a circle.
/// - `claims_nearby`: Σ P, at most 2, of the candidates of other fragments that meet the parent near the same point between its ends.
pub const FEEDBACK_FEATURES: &[&str] =
    &["with_flow", "step_with_flow", "entered_there", "claims_on_end", "fed_otherwise", "claims_nearby"];

/// Competitors on a point beyond so many are all alike.
const MOST_COMPETITORS: f64 = 2.0;

/// A root is either no fragment or fed from outside: so much of its probability goes to its widest free end.
const ROOT_ENTRY: f64 = 0.5;

/// The features of every candidate between fragments, shape (candidates, [`FEEDBACK_FEATURES`]), by the forests of the same candidates, in their
/// order, and their marginals. Where no inlet is known the longest fragment is taken to be fed.
pub fn feedback_features(
    extraction: &Extraction,
    candidates: &[EndCandidate],
    forests: &Forests,
    marginals: &Marginals,
) -> Array2<f64> {
    let e = extraction;
    let given = e.fragments.iter().any(|f| f.fed);
    let is_longest = |length: f64| e.longest > 0.0 && steady(length / e.longest) >= 1.0;
    let marked: Vec<bool> = e.fragments.iter().map(|f| if given { f.fed } else { is_longest(f.length) }).collect();
    let rooted = rooted_in(forests, &marked);
    let balances = balance(e, candidates, marginals);
    let mut out = Array2::zeros((candidates.len(), FEEDBACK_FEATURES.len()));
    for (row, (candidate, competitors)) in candidates.iter().zip(competitors(e, candidates)).enumerate() {
        let sum = |rows: Vec<usize>| rows.into_iter().map(|row| marginals.edges[row]).sum::<f64>();
        let [elsewhere, on_child, nearby] = competitors.map(sum);
        let shape = &e.shape[candidate.point];
        let across = unit(sub(e.position[candidate.point], e.position[e.ends[candidate.end].point]));
        // At nodes the shape is zero, and so are the first two features.
        let balance = balances[e.branch[candidate.point]];
        let with_flow = [-balance * dot(shape.tangent, across), balance * shape.narrowing];
        let fed = fed_without(forests, marginals, &rooted, row);
        let of_others = [elsewhere, on_child, fed, nearby.min(MOST_COMPETITORS)];
        out.row_mut(row).iter_mut().zip(with_flow.into_iter().chain(of_others)).for_each(|(out, value)| *out = value);
    }
    out
}

/// The fragments as trees of nodes, and which branches are on loops.
struct FragmentTrees {
    /// The nodes, each after the one it was reached from.
    order: Vec<usize>,
    /// Per node the one it was reached from and the branch between; the other branches close loops.
    from: Vec<Option<(usize, usize)>>,
    /// Per branch whether it lies on a loop, so that it has no upstream side.
    on_loop: Vec<bool>,
}

impl FragmentTrees {
    fn new(e: &Extraction) -> Self {
        // Every fragment is gone through once, depth first.
        let nodes = e.graph.nodes();
        let (mut order, mut place, mut from) = (Vec::with_capacity(nodes), vec![usize::MAX; nodes], vec![None; nodes]);
        for start in 0..nodes {
            let mut open = vec![(start, None)];
            while let Some((node, reached_from)) = open.pop() {
                if place[node] < usize::MAX {
                    continue;
                }
                (place[node], from[node]) = (order.len(), reached_from);
                order.push(node);
                open.extend(e.graph.branches[node].iter().map(|(branch, next, _)| (*next, Some((node, *branch)))));
            }
        }
        let mut this = Self { order, from, on_loop: vec![true; e.graph.length.len()] };
        // Every branch outside of the trees closes a loop with those between its nodes, one of which is below the other.
        for (_, branch) in this.from.iter().flatten() {
            this.on_loop[*branch] = false;
        }
        let mut loops = vec![0_i64; nodes];
        for (_, [a, b]) in e.graph.ends.iter().enumerate().filter(|(branch, _)| this.on_loop[*branch]) {
            let (above, below) = if place[*a] < place[*b] { (*a, *b) } else { (*b, *a) };
            loops[above] -= 1;
            loops[below] += 1;
        }
        this.add_below(&mut loops);
        for (node, from) in this.from.iter().enumerate() {
            if let Some((_, branch)) = from {
                this.on_loop[*branch] = loops[node] > 0;
            }
        }
        this
    }

    /// Adds to each node what is below it.
    fn add_below<T: Copy + std::ops::AddAssign>(&self, values: &mut [T]) {
        for node in self.order.iter().rev() {
            if let Some((above, _)) = self.from[*node] {
                let below = values[*node];
                values[above] += below;
            }
        }
    }
}

/// F per branch: the entries to expect on the side of its first node less those on the side of its last; 0 on a loop, where
/// blood comes from both.
///
/// A free end counts with the probability that its fragment is attached by it, the inlets of a fragment share the probability
/// that it is a root, and without inlets half of that goes to the widest end, or is shared by both
/// where those of a short vessel are as wide.
fn balance(e: &Extraction, candidates: &[EndCandidate], marginals: &Marginals) -> Vec<f64> {
    let mut entries = vec![0.0; e.graph.nodes()];
    for (candidate, p) in candidates.iter().zip(&marginals.edges) {
        entries[e.ends[candidate.end].point] += p;
    }
    let inlets = counted(e.fragments.len(), e.inlets.iter().map(|inlet| e.fragment[*inlet]));
    for inlet in &e.inlets {
        entries[*inlet] += marginals.roots[e.fragment[*inlet]] / inlets[e.fragment[*inlet]] as f64;
    }
    let most = |end: &FreeEnd| e.fragments[end.fragment].widest_end.unwrap_or(f64::INFINITY);
    let widest = e.ends.iter().filter(|end| steady(end.radius / most(end)) >= 1.0).map(|end| (end.fragment, end.point));
    let widest = grouped(e.fragments.len(), widest);
    for (fragment, ends) in widest.iter().enumerate().filter(|(fragment, _)| inlets[*fragment] == 0) {
        for end in ends {
            entries[*end] += ROOT_ENTRY * marginals.roots[fragment] / ends.len() as f64;
        }
    }
    let mut total = vec![0.0; e.fragments.len()];
    entries.iter().zip(&e.fragment).for_each(|(entry, fragment)| total[*fragment] += entry);
    let trees = FragmentTrees::new(e);
    trees.add_below(&mut entries);
    // Lone nodes are branches too.
    let mut balance = vec![0.0; e.lines.len()];
    for (node, from) in trees.from.iter().enumerate() {
        if let Some((above, branch)) = from.filter(|(_, branch)| !trees.on_loop[*branch]) {
            let down = total[e.fragment[node]] - 2.0 * entries[node];
            balance[branch] = if e.graph.ends[branch][0] == above { down } else { -down };
        }
    }
    balance
}

/// The probability that a walk from the parent dies in a fed fragment before it meets the child: f_p - f_c G_pc/G_cc with f the
/// probability that a fragment's tree is rooted in a fed one, G_pc/G_cc = 1 - P_e v_c/(w_e P(root c)).
fn fed_without(forests: &Forests, marginals: &Marginals, fed: &[f64], row: usize) -> f64 {
    let candidate = &forests.edges()[row];
    let (child, parent) = (candidate.child, candidate.parent);
    let odds = (forests.log_roots()[child] - candidate.log_weight).exp();
    // Of an impossible edge 0 · ∞ is no number, of which `min` makes 1: separated for sure.
    let separated = (marginals.edges[row] / marginals.roots[child] * odds).min(1.0);
    (fed[parent] - (1.0 - separated) * fed[child]).clamp(0.0, 1.0)
}

/// Two branches leave a vessel at places that are further from one another than so many radii and spacings.
const SEPARATION_RADII: f64 = 2.0;
const SEPARATION_SPACINGS: f64 = 2.0;

/// Rows of other candidates: those that attach the parent to a third fragment by the free end that is met; those that attach a third fragment to
/// the child's end; and those that attach other fragments near the same point, where that is between the ends of a vessel.
type Competitors = [Vec<usize>; 3];

/// The competitors of each candidate.
fn competitors(e: &Extraction, candidates: &[EndCandidate]) -> Vec<Competitors> {
    let child = |row: usize| e.ends[candidates[row].end].fragment;
    let parent = |row: usize| e.fragment[candidates[row].point];
    let from = rows_by_end(e, candidates);
    let at = grouped(e.position.len(), candidates.iter().enumerate().map(|(row, candidate)| (candidate.point, row)));
    // Per meeting point between the ends of a vessel the candidates that meet its fragment there or near.
    let points: Vec<usize> = (0..at.len()).filter(|point| !at[*point].is_empty()).collect();
    let index = PointIndex::new(points.iter().map(|point| e.position[*point]).collect());
    let between_ends = points.iter().copied().filter(|point| e.end_at[*point].is_none());
    let nearby = between_ends.map(|point| {
        let separation = SEPARATION_RADII * e.smooth.radius[point] + SEPARATION_SPACINGS * e.spacing;
        let near = steady(separation / e.spacing);
        let within = |other: &usize| e.fragment[*other] == e.fragment[point] && e.spacings(*other, point) <= near;
        let hits = index.within(e.position[point], separation * (1.0 + 1e-9)).into_iter().map(|(_, hit)| points[hit]);
        (point, hits.filter(within).flat_map(|other| at[other].iter().copied()).collect())
    });
    let nearby: std::collections::BTreeMap<usize, Vec<usize>> = nearby.collect();
    let of = |rows: Option<&Vec<usize>>, keep: &dyn Fn(usize) -> bool| {
        rows.into_iter().flatten().copied().filter(|row| keep(*row)).collect::<Vec<usize>>()
    };
    let of_candidate = |(row, candidate): (usize, &EndCandidate)| {
        let by_end = e.end_at[candidate.point].map(|end| &from[end]);
        [
            of(by_end, &|other| parent(other) != child(row)),
            of(Some(&at[e.ends[candidate.end].point]), &|other| child(other) != parent(row)),
            of(nearby.get(&candidate.point), &|other| child(other) != child(row)),
        ]
    };
    candidates.iter().enumerate().map(of_candidate).collect()
}
