//! Dead ends: parts that a single junction, or a single pressure, separates from everything that drives flow. Nothing flows there. They are
//! found by structure, because a solver that subtracts leaves rounding there that could pass for flow.

use super::Circuit;
use crate::support::grouped;

/// The nodes of a circuit, one per pressure level of its conditions, and the root behind them all.
#[derive(Debug, Clone)]
pub struct DeadEnds {
    /// Per node where its entries in `links` begin; one more at the end.
    start: Vec<u32>,
    /// Other node and vessel; [`ALWAYS`] for the links to levels and root, which are always open.
    links: Vec<(u32, u32)>,
    /// Nodes of the circuit.
    nodes: usize,
    levels: Vec<f64>,
}

/// The memory of one worker.
#[derive(Debug, Clone, Default)]
pub struct DeadEndsWorkspace {
    order: Vec<u32>,
    parent: Vec<u32>,
    entered: Vec<u32>,
    low: Vec<u32>,
    next: Vec<u32>,
    dead: Vec<bool>,
}

/// In the place of a vessel: what no sample closes.
const ALWAYS: u32 = u32::MAX;
/// Not reached yet.
const NEVER: u32 = u32::MAX;

impl DeadEnds {
    /// Lists the links of a circuit.
    pub fn new(circuit: &Circuit) -> Self {
        let nodes = circuit.node_count();
        let levels = circuit.levels();
        let root = nodes + levels.len();
        let vessels = circuit.ends.iter().zip(0..).filter(|(ends, _)| ends[0] != ends[1]);
        let mut pairs: Vec<([usize; 2], u32)> = vessels.map(|(ends, vessel)| (*ends, vessel)).collect();
        for node in 0..nodes {
            if let Some(p) = circuit.ground(node) {
                pairs.push(([node, nodes + levels.partition_point(|l| *l <= p) - 1], ALWAYS));
            } else if circuit.source[node] != 0.0 {
                pairs.push(([node, root], ALWAYS));
            }
        }
        pairs.extend((nodes..root).map(|l| ([l, root], ALWAYS)));
        let links = pairs.into_iter().flat_map(|([a, b], vessel)| [(a, (b as u32, vessel)), (b, (a as u32, vessel))]);
        let lists = grouped(root + 1, links);
        let mut start = vec![0];
        for list in &lists {
            start.push(start[start.len() - 1] + list.len() as u32);
        }
        Self { start, links: lists.concat(), nodes, levels }
    }

    /// Gives every node in a dead end the pressure of the junction or condition where the dead end begins.
    pub fn level(&self, open: impl Fn(usize) -> bool, work: &mut DeadEndsWorkspace, pressure: &mut [f64], fixed: &[Option<f64>]) {
        let all = self.start.len() - 1;
        let root = all - 1;
        for list in [&mut work.parent, &mut work.entered, &mut work.low] {
            list.clear();
            list.resize(all, NEVER);
        }
        work.next.clear();
        work.next.extend_from_slice(&self.start[..all]);
        work.order.clear();
        (work.entered[root], work.low[root]) = (0, 0);
        work.order.push(root as u32);
        let mut node = root;
        loop {
            if work.next[node] == self.start[node + 1] {
                if node == root {
                    break;
                }
                let up = work.parent[node] as usize;
                work.low[up] = work.low[up].min(work.low[node]);
                node = up;
                continue;
            }
            let (other, vessel) = self.links[work.next[node] as usize];
            work.next[node] += 1;
            if vessel != ALWAYS && !open(vessel as usize) {
                continue;
            }
            let at = other as usize;
            if work.entered[at] == NEVER {
                work.entered[at] = work.order.len() as u32;
                work.low[at] = work.order.len() as u32;
                work.parent[at] = node as u32;
                work.order.push(other);
                node = at;
            } else {
                work.low[node] = work.low[node].min(work.entered[at]);
            }
        }
        work.dead.clear();
        work.dead.resize(all, false);
        for node in work.order.iter().skip(1).map(|node| *node as usize) {
            let up = work.parent[node] as usize;
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
