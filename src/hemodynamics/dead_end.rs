//! Dead ends: parts that a single junction, or a single pressure, cuts off from everything that drives flow. Nothing flows
//! there, a structural fact; an elimination that subtracts leaves rounding that could pass for flow.

use super::circuit::Circuit;

/// Pressures closer than this share of each other are one level.
const SAME: f64 = 1e-12;

/// The nodes of a circuit, one per pressure level of its conditions, and the root behind them all.
#[derive(Debug)]
pub struct DeadEnds {
    /// Per node where its entries in `links` begin; one more at the end.
    start: Vec<usize>,
    /// Other node and vessel; `usize::MAX` for the links to levels and root, which are always open.
    links: Vec<(usize, usize)>,
    /// Nodes of the circuit.
    nodes: usize,
    levels: Vec<f64>,
}

/// The memory of one worker.
#[derive(Debug, Default)]
pub struct Workspace {
    order: Vec<usize>,
    parent: Vec<usize>,
    entered: Vec<usize>,
    low: Vec<usize>,
    next: Vec<usize>,
    stack: Vec<usize>,
    dead: Vec<bool>,
}

impl DeadEnds {
    /// Lists the links of a circuit.
    pub fn new(circuit: &Circuit) -> Self {
        let nodes = circuit.node_count();
        let level =
            |n: usize| circuit.fixed[n].or_else(|| (circuit.shunt[n] > 0.0).then(|| circuit.source[n] / circuit.shunt[n]));
        let mut levels: Vec<f64> = (0..nodes).filter_map(level).collect();
        levels.sort_by(f64::total_cmp);
        levels.dedup_by(|b, a| *b - *a <= SAME * b.abs());
        let root = nodes + levels.len();
        let mut pairs: Vec<[usize; 3]> = Vec::new();
        for (vessel, [a, b]) in circuit.ends.iter().enumerate().filter(|(_, e)| e[0] != e[1]) {
            pairs.push([*a, *b, vessel]);
        }
        for node in 0..nodes {
            if let Some(p) = level(node) {
                pairs.push([node, nodes + levels.partition_point(|l| *l <= p) - 1, usize::MAX]);
            } else if circuit.source[node] != 0.0 {
                pairs.push([node, root, usize::MAX]);
            }
        }
        pairs.extend((nodes..root).map(|l| [l, root, usize::MAX]));
        let mut lists = vec![Vec::new(); root + 1];
        for [a, b, vessel] in pairs {
            lists[a].push((b, vessel));
            lists[b].push((a, vessel));
        }
        let mut start = vec![0];
        start.extend(lists.iter().scan(0, |sum, l| {
            *sum += l.len();
            Some(*sum)
        }));
        Self { start, links: lists.concat(), nodes, levels }
    }

    /// Gives every node in a dead end the pressure of the junction or condition that it hangs on.
    pub fn level(&self, open: impl Fn(usize) -> bool, work: &mut Workspace, pressure: &mut [f64], fixed: &[Option<f64>]) {
        let all = self.start.len() - 1;
        let root = all - 1;
        for list in [&mut work.parent, &mut work.entered, &mut work.low] {
            list.clear();
            list.resize(all, usize::MAX);
        }
        work.next.clear();
        work.next.extend_from_slice(&self.start[..all]);
        work.order.clear();
        work.stack.clear();
        work.stack.push(root);
        (work.entered[root], work.low[root]) = (0, 0);
        work.order.push(root);
        while let Some(node) = work.stack.last().copied() {
            if work.next[node] == self.start[node + 1] {
                work.stack.pop();
                if node != root {
                    let up = work.parent[node];
                    work.low[up] = work.low[up].min(work.low[node]);
                }
                continue;
            }
            let (other, vessel) = self.links[work.next[node]];
            work.next[node] += 1;
            if vessel != usize::MAX && !open(vessel) {
                continue;
            }
            if work.entered[other] == usize::MAX {
                work.entered[other] = work.order.len();
                work.low[other] = work.order.len();
                work.parent[other] = node;
                work.order.push(other);
                work.stack.push(other);
            } else {
                work.low[node] = work.low[node].min(work.entered[other]);
            }
        }
        work.dead.clear();
        work.dead.resize(all, false);
        for node in work.order.iter().skip(1).copied() {
            let up = work.parent[node];
            if up == root || node >= self.nodes {
                continue;
            }
            if work.dead[up] || work.low[node] >= work.entered[up] {
                work.dead[node] = true;
                pressure[node] = fixed[node].unwrap_or(if up < self.nodes { pressure[up] } else { self.levels[up - self.nodes] });
            }
        }
    }
}
