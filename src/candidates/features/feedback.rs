//! Features of a bridge from a posterior: what is probable of the other bridges speaks for or against this one.
//!
//! The posterior of [`FEATURES`](super::FEATURES) alone says where blood probably enters each fragment; from there follow the
//! way it runs at every point, which meeting points are taken, and which fragments are fed. A second posterior uses that.

use std::collections::BTreeMap;

use ndarray::Array2;

use super::extraction::Extraction;
use super::smoothing::steady;
use crate::candidates::search::by_evidence::FoundBridge;
use crate::candidates::search::neighbours::PointIndex;
use crate::forest_posterior::{Forests, Marginals, rooted_in};
use crate::support::geometry::{distance, dot, sub, unit};

/// The features of a bridge from a posterior, by the names that weights have in a file. P is the probability of a bridge.
///
/// - `with_flow`: -F t·u where the parent is met on its way, else 0: t its tangent, u across the gap from the child, F the entries
///   of blood to expect behind the point less those ahead. A branch goes on with the flow.
/// - `step_with_flow`: F ln r₁/r₂ where the parent is met on its way, else 0: r₁ the parent's radius behind, r₂ ahead. A vessel is thinner
///   after a branch.
/// - `entered_there`: Σ P of the bridges by which the parent hangs elsewhere by the free end that is met; 0 on its way. An end has one
///   neighbour.
/// - `claims_on_end`: Σ P of the bridges by which other fragments than the parent hang on the child's end.
/// - `fed_otherwise`: the probability that the parent is fed, by an inlet, without the child's help. No bridge goes round.
/// - `claims_nearby`: Σ P, at most 2, of the bridges of other fragments that meet the parent near the same point on its way.
pub const FEEDBACK_FEATURES: &[&str] =
    &["with_flow", "step_with_flow", "entered_there", "claims_on_end", "fed_otherwise", "claims_nearby"];

/// Claims on a point beyond so many are all alike.
const MOST_CLAIMS: f64 = 2.0;

/// What of the feedback does not change from one posterior to the next.
pub struct Feedback<'a> {
    extraction: &'a Extraction,
    bridges: Vec<FoundBridge>,
    entries: Entries,
    claims: Claims,
    /// Per fragment whether it is taken to be fed.
    fed: Vec<bool>,
}

impl<'a> Feedback<'a> {
    /// The feedback on bridges between fragments. Where no inlet is known the longest fragment is taken to be fed.
    ///
    /// # Panics
    ///
    /// When a bridge is within a fragment.
    pub fn new(extraction: &'a Extraction, bridges: &[FoundBridge]) -> Self {
        assert!(bridges.iter().all(|bridge| !bridge.inside), "bridges between fragments");
        let fragments = &extraction.fragments;
        let longest = fragments.iter().map(|f| f.length).fold(0.0, f64::max);
        let given = fragments.iter().any(|f| f.fed);
        let fed = |length: f64| longest > 0.0 && steady(length / longest) >= 1.0;
        Self {
            extraction,
            bridges: bridges.to_vec(),
            entries: Entries::new(extraction),
            claims: Claims::new(extraction, bridges),
            fed: fragments.iter().map(|f| if given { f.fed } else { fed(f.length) }).collect(),
        }
    }

    /// The features of every bridge, shape (bridges, [`FEEDBACK_FEATURES`]).
    ///
    /// # Panics
    ///
    /// When the forests are not those of the bridges, in their order, or the marginals are of others.
    pub fn features(&self, forests: &Forests, marginals: &Marginals) -> Array2<f64> {
        assert_eq!(forests.bridges().len(), self.bridges.len(), "the forests of the same bridges");
        assert_eq!(forests.fragments(), self.fed.len(), "the forests of the same fragments");
        assert_eq!(marginals.bridges.len(), self.bridges.len(), "the marginals of the same forests");
        let e = self.extraction;
        let balance = self.entries.balance(e, &self.bridges, marginals);
        let fed = rooted_in(forests, &self.fed);
        let mut out = Array2::zeros((self.bridges.len(), FEEDBACK_FEATURES.len()));
        for (row, (bridge, mut out)) in self.bridges.iter().zip(out.rows_mut()).enumerate() {
            let sum = |rows: &[usize]| rows.iter().map(|row| marginals.bridges[*row]).sum::<f64>();
            let course = &e.course[bridge.point];
            let across = unit(sub(e.position[bridge.point], e.position[e.ends[bridge.end].point]));
            // At nodes the course is zero, and nothing is said.
            let balance = balance[e.branch[bridge.point]];
            let values = [
                -balance * dot(course.tangent, across),
                balance * course.narrowing,
                sum(&self.claims.elsewhere[row]),
                sum(&self.claims.on_child[row]),
                fed_without(forests, marginals, &fed, row),
                sum(&self.claims.beside[row]).min(MOST_CLAIMS),
            ];
            out.iter_mut().zip(values).for_each(|(out, value)| *out = value);
        }
        out
    }
}

/// The probability that a walk from the parent dies in a fed fragment before it meets the child: f_p - f_c G_pc/G_cc with f the
/// probability that a fragment's tree is rooted in a fed one, G_pc/G_cc = 1 - P_e v_c/(w_e P(root c)).
fn fed_without(forests: &Forests, marginals: &Marginals, fed: &[f64], row: usize) -> f64 {
    let bridge = &forests.bridges()[row];
    let (child, parent) = (bridge.child, bridge.parent);
    if bridge.log_weight == f64::NEG_INFINITY {
        return fed[parent];
    }
    let odds = (forests.log_roots()[child] - bridge.log_weight).exp();
    let apart = (marginals.bridges[row] / marginals.roots[child] * odds).min(1.0);
    (fed[parent] - (1.0 - apart) * fed[child]).clamp(0.0, 1.0)
}

/// Two branches leave a vessel at places that are further apart than so many radii and spacings.
const APART_RADII: f64 = 2.0;
const APART_SPACINGS: f64 = 2.0;

/// Per bridge the rows of others.
pub struct Claims {
    /// By which the parent would hang on a third fragment by the free end that is met.
    pub elsewhere: Vec<Vec<usize>>,
    /// By which a third fragment would hang on the child's end.
    pub on_child: Vec<Vec<usize>>,
    /// By which other fragments would hang near the same point, where that is on the way of a vessel.
    pub beside: Vec<Vec<usize>>,
}

impl Claims {
    /// The competitors of each bridge.
    pub fn new(e: &Extraction, bridges: &[FoundBridge]) -> Self {
        let child = |row: usize| e.ends[bridges[row].end].fragment;
        let parent = |row: usize| e.fragment[bridges[row].point];
        let mut from = vec![Vec::new(); e.ends.len()];
        let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for (row, bridge) in bridges.iter().enumerate() {
            from[bridge.end].push(row);
            at.entry(bridge.point).or_default().push(row);
        }
        let beside = near_each(e, &at);
        let none = Vec::new();
        let of = |rows: &Vec<usize>, keep: &dyn Fn(usize) -> bool| rows.iter().copied().filter(|row| keep(*row)).collect();
        let each = |claims: &dyn Fn(usize, &FoundBridge) -> Vec<usize>| {
            bridges.iter().enumerate().map(|(row, bridge)| claims(row, bridge)).collect::<Vec<Vec<usize>>>()
        };
        Self {
            elsewhere: each(&|row, bridge| {
                of(e.end_at[bridge.point].map_or(&none, |end| &from[end]), &|other| parent(other) != child(row))
            }),
            on_child: each(&|row, bridge| {
                of(at.get(&e.ends[bridge.end].point).unwrap_or(&none), &|other| child(other) != parent(row))
            }),
            beside: each(&|row, bridge| of(beside.get(&bridge.point).unwrap_or(&none), &|other| child(other) != child(row))),
        }
    }
}

/// Per meeting point on the way of a vessel the bridges that meet its fragment there or near.
fn near_each(e: &Extraction, at: &BTreeMap<usize, Vec<usize>>) -> BTreeMap<usize, Vec<usize>> {
    let points: Vec<usize> = at.keys().copied().collect();
    let index = PointIndex::new(points.iter().map(|point| e.position[*point]).collect());
    let on_the_way = points.iter().copied().filter(|point| e.end_at[*point].is_none());
    let near = on_the_way.map(|point| {
        let apart = APART_RADII * e.smooth.radius[point] + APART_SPACINGS * e.spacing;
        let within = |other: &usize| {
            let off = distance(e.position[*other], e.position[point]);
            e.fragment[*other] == e.fragment[point] && steady(off / e.spacing) <= steady(apart / e.spacing)
        };
        let hits = index.within(e.position[point], apart * (1.0 + 1e-9)).into_iter().map(|(_, hit)| points[hit]);
        (point, hits.filter(within).flat_map(|other| at[&other].iter().copied()).collect())
    });
    near.collect()
}

/// A fragment that hangs on nothing is either none or fed from outside: it enters so much by its widest free end.
const ROOT_ENTRY: f64 = 0.5;

/// The fragments as trees of nodes, and what is on a loop.
pub struct Entries {
    /// The nodes, each after the one it was reached from.
    order: Vec<usize>,
    /// Per node the one it was reached from and the branch between; the other branches close loops.
    from: Vec<Option<(usize, usize)>>,
    /// Per branch whether it lies on a loop, so that no side of it can be told.
    on_loop: Vec<bool>,
    /// Per fragment its widest free ends, more than one when both ends of a short vessel are as wide.
    widest: Vec<Vec<usize>>,
}

impl Entries {
    /// Goes through every fragment once, depth first.
    pub fn new(e: &Extraction) -> Self {
        let nodes = e.roads.nodes();
        let (mut order, mut place, mut from) = (Vec::with_capacity(nodes), vec![usize::MAX; nodes], vec![None; nodes]);
        for start in 0..nodes {
            let mut open = vec![(start, None)];
            while let Some((node, reached_from)) = open.pop() {
                if place[node] < usize::MAX {
                    continue;
                }
                (place[node], from[node]) = (order.len(), reached_from);
                order.push(node);
                open.extend(e.roads.around(node).iter().map(|(branch, next)| (*next, Some((node, *branch)))));
            }
        }
        let mut widest = vec![Vec::new(); e.fragments.len()];
        for end in &e.ends {
            let most = e.fragments[end.fragment].widest_end.unwrap_or(f64::INFINITY);
            if steady(end.radius / most) >= 1.0 {
                widest[end.fragment].push(end.point);
            }
        }
        let mut this = Self { order, from, on_loop: vec![false; e.roads.length.len()], widest };
        this.find_loops(e, &place);
        this
    }

    /// Every branch outside of the trees closes a loop with those between its nodes, one of which is below the other.
    fn find_loops(&mut self, e: &Extraction, place: &[usize]) {
        let mut closes = vec![true; self.on_loop.len()];
        self.from.iter().flatten().for_each(|(_, branch)| closes[*branch] = false);
        let mut loops = vec![0_i64; self.order.len()];
        for (branch, [a, b]) in e.roads.ends.iter().enumerate().filter(|(branch, _)| closes[*branch]) {
            self.on_loop[branch] = true;
            let (above, below) = if place[*a] < place[*b] { (*a, *b) } else { (*b, *a) };
            loops[above] -= 1;
            loops[below] += 1;
        }
        self.add_below(&mut loops);
        for (node, from) in self.from.iter().enumerate() {
            if let Some((_, branch)) = from {
                self.on_loop[*branch] = loops[node] > 0;
            }
        }
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

    /// F per branch: the entries to expect on the side of its first node less those on the side of its last; 0 on a loop, where
    /// blood comes from both.
    ///
    /// A free end counts with the probability that its fragment hangs by it, the inlets of a fragment share the probability
    /// that it is a root, and without inlets half of that goes to the widest end.
    pub fn balance(&self, e: &Extraction, bridges: &[FoundBridge], marginals: &Marginals) -> Vec<f64> {
        let mut entries = vec![0.0; self.order.len()];
        for (bridge, p) in bridges.iter().zip(&marginals.bridges) {
            entries[e.ends[bridge.end].point] += p;
        }
        let mut inlets = vec![0.0; e.fragments.len()];
        e.inlets.iter().for_each(|inlet| inlets[e.fragment[*inlet]] += 1.0);
        for inlet in &e.inlets {
            entries[*inlet] += marginals.roots[e.fragment[*inlet]] / inlets[e.fragment[*inlet]];
        }
        for (fragment, ends) in self.widest.iter().enumerate().filter(|(fragment, _)| inlets[*fragment] == 0.0) {
            for end in ends {
                entries[*end] += ROOT_ENTRY * marginals.roots[fragment] / ends.len() as f64;
            }
        }
        let mut total = vec![0.0; e.fragments.len()];
        entries.iter().zip(&e.fragment).for_each(|(entry, fragment)| total[*fragment] += entry);
        self.add_below(&mut entries);
        // Lone nodes are branches too.
        let mut balance = vec![0.0; e.lines.len()];
        for (node, from) in self.from.iter().enumerate() {
            if let Some((above, branch)) = from.filter(|(_, branch)| !self.on_loop[*branch]) {
                let down = total[e.fragment[node]] - 2.0 * entries[node];
                balance[branch] = if e.roads.ends[branch][0] == above { down } else { -down };
            }
        }
        balance
    }
}
