//! Peeling removes dead ends and merges chains of certain vessels, once and exactly, before any sample.
//!
//! A vessel that ends at a free node without a terminal or another vessel carries no flow in any sample. Certain vessels in series carry one
//! flow: they become one resistance, so vessels of equal radii have equal resilience to the last bit.

use super::Circuit;
use crate::network::walks::other;

/// A circuit with its dead ends and certain chains taken out.
#[derive(Debug, Clone)]
pub struct Peeled {
    /// The same rows of nodes and vessels. The first vessel of a chain stands for all of it, between its ends and with its conductance
    /// 1 / Σ R; the others, and dead ends, are self-loops; nodes inside are fixed at zero.
    pub circuit: Circuit,
    /// Per row the one that stands for its chain, its own for most; `None` for dead ends, which never carry flow.
    pub stand_in: Vec<Option<usize>>,
}

struct ChainLink {
    ends: [usize; 2],
    resistance: f64,
    members: Vec<usize>,
    certain: bool,
}

/// Peels a circuit whose `certain` rows are open in every sample.
pub fn peel(circuit: &Circuit, certain: &[bool]) -> Peeled {
    let mut around = circuit.rows_at_nodes();
    let link = |(row, ends): (usize, &[usize; 2])| {
        let resistance = 1.0 / circuit.conductance[row];
        (ends[0] != ends[1]).then(|| ChainLink { ends: *ends, resistance, members: vec![row], certain: certain[row] })
    };
    let mut links: Vec<Option<ChainLink>> = circuit.ends.iter().enumerate().map(link).collect();
    let inner = |node: usize| circuit.is_inner(node);
    let mut gone = vec![false; circuit.node_count()];
    let mut open: Vec<usize> = (0..circuit.node_count()).rev().filter(|n| inner(*n)).collect();
    while let Some(node) = open.pop() {
        if gone[node] {
            continue;
        }
        match around[node][..] {
            [] => gone[node] = true,
            [only] => {
                gone[node] = true;
                let far = links[only].take().map_or(node, |link| other(link.ends, node));
                around[far].retain(|l| *l != only);
                open.extend(Some(far).filter(|n| inner(*n)));
            }
            [a, b] if [a, b].iter().all(|l| links[*l].as_ref().is_some_and(|link| link.certain)) => {
                let (Some(first), Some(second)) = (links[a].take(), links[b].take()) else { continue };
                gone[node] = true;
                let ends = [other(first.ends, node), other(second.ends, node)];
                around[ends[1]].retain(|l| *l != b);
                if ends[0] == ends[1] {
                    // A ring at one node: no pressure difference drives it.
                    around[ends[0]].retain(|l| *l != a);
                } else {
                    around[ends[1]].push(a);
                    let members = [first.members, second.members].concat();
                    links[a] = Some(ChainLink { ends, resistance: first.resistance + second.resistance, members, certain: true });
                }
                open.extend(ends.into_iter().filter(|n| inner(*n)));
            }
            _ => {}
        }
    }
    let mut peeled = Peeled { circuit: circuit.clone(), stand_in: vec![None; circuit.row_count()] };
    for [a, b] in &mut peeled.circuit.ends {
        *b = *a;
    }
    for link in links.iter().flatten() {
        let first = link.members.iter().copied().min().unwrap_or_default();
        peeled.circuit.ends[first] = link.ends;
        if link.members.len() > 1 {
            peeled.circuit.conductance[first] = 1.0 / link.resistance;
        }
        for member in &link.members {
            peeled.stand_in[*member] = Some(first);
        }
    }
    for (node, _) in gone.iter().enumerate().filter(|(_, gone)| **gone) {
        peeled.circuit.fixed[node] = Some(0.0);
    }
    peeled
}
