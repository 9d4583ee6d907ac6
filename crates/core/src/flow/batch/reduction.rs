//! Reduces a large circuit to what samples can change. Dead ends, certain chains, and certain trees that end at one pressure are solved
//! once, exactly.
//!
//! A tree whose ends have one pressure P₀ acts as a conductance to P₀ at its root in the core, and every drop in it is a fixed share of
//! P - P₀ there. Shares are products and quotients of positive numbers: nothing cancels.

use crate::flow::circuit::{Circuit, same_pressure};
use crate::flow::peeling::{Peeled, peel};
use crate::{network::walks::other, support::grouped};

/// A reduced circuit.
#[derive(Debug)]
pub struct Reduction {
    /// The core: its nodes are renumbered, its rows are the chains, and the trees at a node are part of its terminal conductance.
    pub circuit: Circuit,
    /// Per row of the core its vessels in series, by row of the circuit; one, or certain ones. The terminals come last.
    pub chains: Vec<Vec<usize>>,
    /// The trees that begin at the core, one for each node and end pressure.
    pub trees: Vec<HangingTree>,
}

/// Certain vessels that branch from a node of the core and end at one pressure.
#[derive(Debug, Clone, PartialEq)]
pub struct HangingTree {
    /// The node of the core.
    pub node: usize,
    /// P₀, Pa above the circuit's level.
    pub end: f64,
    /// Per vessel its row and flow over P - P₀, m³/(Pa s).
    pub vessels: Vec<(usize, f64)>,
}

impl Reduction {
    /// Reduces a circuit whose `certain` vessels are open in every sample.
    pub fn of(circuit: &Circuit, certain: &[bool]) -> Self {
        let certain = &circuit.certain_rows(certain);
        let Peeled { mut circuit, stand_in } = peel(circuit, certain);
        let members = grouped(stand_in.len(), stand_in.iter().enumerate().filter_map(|(row, first)| Some(((*first)?, row))));
        let trees = remove_trees(&mut circuit, certain, &members);
        finish(&circuit, members, trees)
    }
}

/// How a node is grounded.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Ground {
    Nothing,
    /// All at one pressure.
    At(f64),
    /// At several, or flow is injected.
    Mixed,
}

impl Ground {
    fn of(circuit: &Circuit, node: usize) -> Self {
        match circuit.ground(node) {
            Some(pressure) => Self::At(pressure),
            None if circuit.is_inner(node) => Self::Nothing,
            None => Self::Mixed,
        }
    }

    fn and(self, pressure: f64) -> Self {
        match self {
            Self::Nothing => Self::At(pressure),
            Self::At(other) if same_pressure(other, pressure) => self,
            _ => Self::Mixed,
        }
    }
}

/// A leaf that was removed, which was joined to another node by one chain.
struct Leaf {
    node: usize,
    on: usize,
    chain: usize,
    end: f64,
    /// The share of P - P₀ at `on` that falls along the chain.
    share: f64,
}

/// Removes trees leaf by leaf: their chains become self-loops, and what they conduct is added to the node that they were joined to. Returns
/// the trees.
fn remove_trees(circuit: &mut Circuit, certain: &[bool], members: &[Vec<usize>]) -> Vec<HangingTree> {
    let nodes = circuit.node_count();
    let around = circuit.rows_at_nodes();
    let mut left: Vec<usize> = around.iter().map(Vec::len).collect();
    let mut ground: Vec<Ground> = (0..nodes).map(|node| Ground::of(circuit, node)).collect();
    let mut leaves: Vec<usize> = (0..nodes).rev().filter(|node| left[*node] == 1).collect();
    let mut removed: Vec<Leaf> = Vec::new();
    while let Some(node) = leaves.pop() {
        let Ground::At(end) = ground[node] else { continue };
        let Some(chain) = around[node].iter().copied().find(|l| circuit.ends[*l][0] != circuit.ends[*l][1]) else { continue };
        if !certain[chain] {
            continue;
        }
        let on = other(circuit.ends[chain], node);
        let conductance = circuit.conductance[chain];
        let (share, through) = if circuit.fixed[node].is_some() {
            (1.0, conductance)
        } else {
            let shunt = circuit.shunt[node];
            (shunt / (conductance + shunt), shunt * (conductance / (conductance + shunt)))
        };
        removed.push(Leaf { node, on, chain, end, share });
        circuit.ends[chain] = [node; 2];
        left[node] = 0;
        left[on] -= 1;
        if circuit.fixed[on].is_none() {
            ground[on] = ground[on].and(end);
            circuit.shunt[on] += through;
            circuit.source[on] += through * end;
        }
        if left[on] == 1 {
            leaves.push(on);
        }
    }
    // From the core outwards: where a node's tree is rooted, and the share of P - P₀ there that is left at the node.
    let mut root: Vec<(usize, f64)> = (0..nodes).map(|node| (node, 1.0)).collect();
    let mut trees: std::collections::BTreeMap<(usize, u64), HangingTree> = std::collections::BTreeMap::new();
    for Leaf { node, on, chain, end, share } in removed.into_iter().rev() {
        let (at, rest) = root[on];
        let tree = trees.entry((at, end.to_bits())).or_insert_with(|| HangingTree { node: at, end, vessels: Vec::new() });
        let flow = circuit.conductance[chain] * (share * rest);
        tree.vessels.extend(members[chain].iter().map(|row| (*row, flow)));
        // What hangs on a fixed pressure goes by that.
        if circuit.fixed[node].is_none() {
            root[node] = (at, rest * (circuit.conductance[chain] / (circuit.conductance[chain] + circuit.shunt[node])));
        }
    }
    trees.into_values().collect()
}

/// Numbers the core: nodes with a chain or a tree, in order; chains by their last vessel, whose row decides between equals.
fn finish(circuit: &Circuit, members: Vec<Vec<usize>>, mut trees: Vec<HangingTree>) -> Reduction {
    let mut row_of = vec![usize::MAX; circuit.node_count()];
    let rows: Vec<usize> = (0..circuit.row_count()).filter(|row| circuit.ends[*row][0] != circuit.ends[*row][1]).collect();
    rows.iter().flat_map(|row| circuit.ends[*row]).chain(trees.iter().map(|tree| tree.node)).for_each(|node| row_of[node] = 0);
    let nodes: Vec<usize> = (0..row_of.len()).filter(|node| row_of[*node] == 0).collect();
    nodes.iter().enumerate().for_each(|(at, node)| row_of[*node] = at);
    for tree in &mut trees {
        tree.node = row_of[tree.node];
    }
    let fixes = rows.iter().filter_map(|row| circuit.fixes.get(row.checked_sub(circuit.vessel_count())?).copied());
    let of = |values: &[f64]| nodes.iter().map(|node| values[*node]).collect();
    let core = Circuit {
        ends: rows.iter().map(|row| circuit.ends[*row].map(|node| row_of[node])).collect(),
        conductance: rows.iter().map(|row| circuit.conductance[*row]).collect(),
        fixed: nodes.iter().map(|node| circuit.fixed[*node]).collect(),
        shunt: of(&circuit.shunt),
        source: of(&circuit.source),
        level: circuit.level,
        fixes: fixes.collect(),
    };
    let mut members = members;
    let chains = rows.iter().map(|row| std::mem::take(&mut members[*row])).collect();
    Reduction { circuit: core, chains, trees }
}
