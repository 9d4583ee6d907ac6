//! Where blood probably enters each fragment, and to which side of each point most of it does.

use super::super::extraction::Extraction;
use super::super::search::FoundBridge;
use super::super::steady::steady;
use crate::posterior::Marginals;

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
