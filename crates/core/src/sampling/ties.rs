//! Ties between vessels in series. Where nothing branches off between two vessels they carry one flow, and with equal radii they have one
//! resilience. Rounding separates them, differently in every solver; here they are made equal to the last bit. A terminal that holds branches off.

use std::{collections::BTreeMap, ops::Range};

use crate::{flow::Circuit, support::simd::Lanes};

/// Nodes at which two vessels may tie, in depth-first order. A vessel here is a row of the circuit, which may be a chain.
#[derive(Debug)]
pub struct Ties {
    nodes: Vec<TieNode>,
}

/// A node with vessels that are alike.
#[derive(Debug)]
struct TieNode {
    /// Its vessels, by factor, and last the row of its terminal, if it has one.
    vessels: Vec<u32>,
    /// Where those of one factor lie among them, if there are several.
    alike: Vec<Range<usize>>,
}

/// Two vessels that tie, and the samples of a group in which they do, as bits.
#[derive(Debug, Clone, Copy)]
pub struct Tie {
    vessels: [u32; 2],
    lanes: u64,
}

impl Ties {
    /// The ties of a circuit; `factor` is ρ over the square of the flow of each vessel.
    pub fn new(circuit: &Circuit, factor: &[f64]) -> Self {
        let nodes = circuit.node_count();
        let mut around = vec![Vec::new(); nodes];
        for (vessel, ends) in circuit.ends.iter().enumerate().take(factor.len()).filter(|(_, [a, b])| a != b) {
            for end in ends {
                around[*end].push(vessel as u32);
            }
        }
        let terminals: BTreeMap<usize, u32> =
            (factor.len()..circuit.row_count()).map(|row| (circuit.ends[row][0], row as u32)).collect();
        let mut ties = Self { nodes: Vec::new() };
        let (mut seen, mut stack) = (vec![false; nodes], Vec::new());
        for root in 0..nodes {
            stack.push(root);
            while let Some(node) = stack.pop() {
                if std::mem::replace(&mut seen[node], true) {
                    continue;
                }
                for vessel in around[node].iter().rev() {
                    let [a, b] = circuit.ends[*vessel as usize];
                    stack.extend(Some(if a == node { b } else { a }).filter(|other| !seen[*other]));
                }
                if circuit.is_inner(node) {
                    let mut vessels = std::mem::take(&mut around[node]);
                    vessels.extend(terminals.get(&node));
                    ties.nodes.extend(TieNode::of(vessels, factor));
                }
            }
        }
        ties
    }

    /// Whether no vessel can tie.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Gives all vessels of a series that tie the largest resilience among them, in each sample of a group. `flowing` has the samples in which
    /// each vessel has any and each terminal holds, as bits; `ties` is memory.
    pub fn equalise<const B: usize>(&self, resilience: &mut [Lanes<B>], flowing: &[u64], ties: &mut Vec<Tie>) {
        ties.clear();
        for TieNode { vessels, alike } in &self.nodes {
            // The samples in which one vessel at least flows, two, and more.
            let (mut one, mut two, mut more) = (0, 0, 0);
            for vessel in vessels {
                let flows = flowing[*vessel as usize];
                more |= two & flows;
                two |= one & flows;
                one |= flows;
            }
            let in_series = two & !more;
            if in_series == 0 {
                continue;
            }
            for alike in alike {
                for a in alike.clone() {
                    let mut lanes = in_series & flowing[vessels[a] as usize];
                    let mut b = a + 1;
                    while lanes != 0 && b < alike.end {
                        let both = lanes & flowing[vessels[b] as usize];
                        if both != 0 {
                            ties.push(Tie { vessels: [vessels[a], vessels[b]], lanes: both });
                            lanes &= !both;
                        }
                        b += 1;
                    }
                }
            }
        }
        let mut level = |tie: &Tie| {
            let [a, b] = tie.vessels.map(|vessel| vessel as usize);
            let mut lanes = tie.lanes;
            while lanes != 0 {
                let lane = lanes.trailing_zeros() as usize;
                let most = resilience[a][lane].max(resilience[b][lane]);
                resilience[a][lane] = most;
                resilience[b][lane] = most;
                lanes &= lanes - 1;
            }
        };
        // Along a branch of the depth-first order the largest is carried up to its top, and from there down again.
        for _ in 0..2 {
            ties.iter().rev().for_each(&mut level);
            ties.iter().for_each(&mut level);
        }
    }
}

impl TieNode {
    /// A node with these vessels; `None` where no two of them are alike.
    fn of(mut vessels: Vec<u32>, factor: &[f64]) -> Option<Self> {
        let factor = |row: &u32| factor.get(*row as usize).copied().unwrap_or(f64::NAN);
        vessels.sort_unstable_by(|a, b| factor(a).total_cmp(&factor(b)));
        let (mut alike, mut first) = (Vec::new(), 0);
        for group in vessels.chunk_by(|a, b| same(factor(a), factor(b))) {
            let last = first + group.len();
            if group.len() > 1 {
                alike.push(first..last);
            }
            first = last;
        }
        (!alike.is_empty()).then_some(Self { vessels, alike })
    }
}

/// Whether two factors are equal up to the rounding of radii, such as that of the mean of two equal ones.
pub fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-12 * a.max(b)
}
