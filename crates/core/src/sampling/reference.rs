//! The method of the paper as it is written, with the rules for ties, dead ends and rounding that the fast kernels have too: slow, and what
//! they are compared with figure by figure. The oracle that shares nothing with them is `tests/inference/textbook.rs`.
//!
//! Moriconi et al. 2019, one sample after another:
//!
//! 1. Mask: Ẽ = 𝓔 ∘ (E ∘ A). Vessel e is open with probability λA_e.
//! 2. Boundary: a condition that was found holds where no candidate at its free end is a true connection.
//! 3. Flow, algorithm 1: Σ_e C_e (P_j - P_i) = s_j at every free node j, with C = 1/R of the open vessels.
//! 4. Resilience: ρ = ΔP·Q / (π r² l) of every vessel that blood flows through.
//! 5. Forest: the minimum spanning forest of 1/ρ; a coin decides between equals.
//! 6. Sum: L_e += ρ_e for every vessel e of the forest.

use std::cmp::Reverse;

use faer::sparse::{SparseColMat, Triplet};
use faer::{Col, Side, linalg::solvers::Solve};
use petgraph::{algo::min_spanning_tree, data::Element, graph::UnGraph};

use super::forest::{ExpectedForest, ForestEdge};
use super::{Method, Sums, Weight, coins::Block, ties::Ties};
use crate::error::{Error, Result};
use crate::flow::dead_ends::{DeadEnds, DeadEndsWorkspace};
use crate::flow::drops::{Drops, DropsWorkspace};
use crate::flow::{Circuit, MOST_RESILIENCE, grounded, is_diffused, pressures::Check, resilience, stranded};
use crate::{network::Network, support::simd::Lanes};

/// Conductances further apart than this leave a factorisation without a right digit behind the weakest.
const MOST_SPAN: f64 = 1e14;

/// A network to sample by the book.
#[derive(Debug)]
pub struct Reference {
    circuit: Circuit,
    /// π r² l of each vessel, m³.
    volume: Vec<f64>,
    /// Where pressures may not show what flows in wide vessels.
    drops: Option<Drops>,
    ties: Ties,
    weight: Weight,
}

impl Reference {
    /// Prepares the samples of a network.
    pub fn new(network: &Network, circuit: Circuit, weight: Weight) -> Self {
        let volume: Vec<f64> = network.vessels().map(|(_, vessel)| vessel.volume()).collect();
        let factor: Vec<f64> = volume.iter().zip(&circuit.conductance).map(|(v, c)| resilience(1.0 / c, 1.0, *v)).collect();
        let drops = Drops::may_hide(&circuit).then(|| Drops::compile(&circuit, usize::MAX)).flatten();
        Self { ties: Ties::new(&circuit, &factor), circuit, volume, drops, weight }
    }

    /// How the samples are computed.
    pub fn method(&self) -> Method {
        Method::new("reference", self.circuit.vessel_count(), None, "baseline")
    }

    /// Replaces `sums` by those of a block.
    ///
    /// # Errors
    ///
    /// The conductances lie too far apart for a factorisation in double precision.
    pub fn block(&self, block: &Block<'_>, sums: &mut Sums) -> Result<()> {
        sums.clear();
        sums.samples = block.samples as u64;
        for sample in 0..block.samples {
            let is_open = |row: usize| block.masks[row] >> sample & 1 == 1;
            let circuit = self.circuit.in_sample(is_open);
            let pressure = pressures(&circuit, is_open)?;
            let resilience = self.resiliences(is_open, &pressure);
            let present = (0..self.volume.len()).filter(|row| is_open(*row)).count().max(1);
            let global = resilience.iter().sum::<f64>() / present as f64;
            let probability = block.probability.map_or(1.0, |p| p[sample]);
            sums.network_resilience += probability * global;
            sums.perfused += if global > 0.0 { probability } else { 0.0 };
            let mut add = |vessel: usize, times: f64| sums.add(vessel, self.weight.of(resilience[vessel], global), times);
            if block.probability.is_some() {
                let mut diffused = diffused(&circuit.ends, &resilience);
                let add = |vessel: usize, share: f64| add(vessel, probability * share);
                ExpectedForest::default().grow(circuit.node_count(), &mut diffused, add);
            } else {
                let key = |vessel: usize| block.coins.key(resilience[vessel], vessel, block.coin[sample]);
                for key in spanning_forest(&diffused(&circuit.ends, &resilience), key) {
                    add(block.coins.vessel(key), 1.0);
                }
            }
            if sample == 0 {
                let stranded = stranded(&circuit, block.masks, 1);
                let residual = Check::default().residual(&circuit, circuit.if_open(block.masks), &stranded, |n| pressure[n]);
                sums.residual = residual.relative;
            }
        }
        Ok(())
    }

    /// ρ = ΔP·Q / (π r² l), Q = C ΔP, of every vessel; zero where no blood flows. Vessels in series share one flow: those that tie by their
    /// radii tie exactly.
    fn resiliences(&self, open: impl Fn(usize) -> bool, pressure: &[f64]) -> Vec<f64> {
        let Circuit { ends, conductance, level, .. } = &self.circuit;
        let of_drop = |row: usize, drop: f64| resilience(drop, conductance[row] * drop, self.volume[row]).min(MOST_RESILIENCE);
        let of_vessel = |vessel: usize| {
            let [a, b] = ends[vessel].map(|node| pressure[node]);
            let flows = open(vessel) && is_diffused(a - b, a + level, b + level);
            Lanes([if flows { of_drop(vessel, a - b) } else { 0.0 }])
        };
        let mut rho: Vec<Lanes<1>> = (0..self.volume.len()).map(of_vessel).collect();
        if let Some(drops) = &self.drops {
            let few = |vessel: &usize| {
                let [a, b] = ends[*vessel].map(|node| pressure[node]);
                Drops::has_few_digits(a - b, a + level, b + level)
            };
            let mut work = DropsWorkspace::default();
            drops.solve(&open, &mut work);
            let drop = |vessel: usize| drops.drop(vessel, &work).filter(|_| open(vessel));
            if (0..rho.len()).filter(few).any(|vessel| drop(vessel).is_some()) {
                rho = (0..rho.len()).map(|vessel| Lanes([drop(vessel).map_or(0.0, |drop| of_drop(vessel, drop))])).collect();
            }
        }
        let terminals = (rho.len()..self.circuit.row_count()).map(|row| u64::from(open(row)));
        let flowing: Vec<u64> = rho.iter().map(|rho| u64::from(rho[0] > 0.0)).chain(terminals).collect();
        self.ties.equalise(&mut rho, &flowing, &mut Vec::new());
        rho.into_iter().map(|rho| rho[0]).collect()
    }
}

/// Kirchhoff's current law for the `open` vessels of a circuit, solved by sparse Cholesky factorisation: the pressure of every node, Pa
/// above the circuit's level; zero in floating components, where it is undefined.
///
/// # Errors
///
/// The conductances lie too far apart for a factorisation in double precision.
pub fn pressures(circuit: &Circuit, open: impl Fn(usize) -> bool) -> Result<Vec<f64>> {
    let vessels = || circuit.ends.iter().enumerate().filter(|(vessel, [a, b])| a != b && open(*vessel));
    let conductances = || vessels().map(|(vessel, _)| circuit.conductance[vessel]);
    if conductances().fold(0.0, f64::max) > MOST_SPAN * conductances().fold(f64::INFINITY, f64::min) {
        return Err(Error::Breakdown);
    }
    // One unknown for each node that a condition grounds, by itself or through open vessels, and whose pressure is not fixed.
    let grounded = grounded(circuit, &open);
    let nodes = 0..circuit.node_count();
    let free: Vec<usize> = nodes.clone().filter(|node| grounded[*node] && circuit.fixed[*node].is_none()).collect();
    let unknown = |node: usize| free.binary_search(&node).ok();
    let mut matrix: Vec<_> = free.iter().enumerate().map(|(i, node)| Triplet::new(i, i, circuit.shunt[*node])).collect();
    let mut right = Col::from_fn(free.len(), |i| circuit.source[free[i]]);
    for (vessel, [a, b]) in vessels() {
        let c = circuit.conductance[vessel];
        for (here, there) in [(*a, *b), (*b, *a)] {
            let Some(i) = unknown(here) else { continue };
            matrix.push(Triplet::new(i, i, c));
            match unknown(there) {
                Some(j) => matrix.push(Triplet::new(i, j, -c)),
                None => right[i] += c * circuit.fixed[there].unwrap_or(0.0),
            }
        }
    }
    let mut pressure: Vec<f64> = circuit.fixed.iter().map(|fixed| fixed.unwrap_or(0.0)).collect();
    if !free.is_empty() {
        let matrix = SparseColMat::<usize, f64>::try_new_from_triplets(free.len(), free.len(), &matrix);
        let factor = matrix.ok().and_then(|matrix| matrix.sp_cholesky(Side::Lower).ok()).ok_or(Error::Breakdown)?;
        let solved = factor.solve(right);
        free.iter().enumerate().for_each(|(i, node)| pressure[*node] = solved[i]);
    }
    // Nothing flows in a dead end; a factorisation leaves rounding there that could pass for flow.
    DeadEnds::new(circuit).level(&open, &mut DeadEndsWorkspace::default(), &mut pressure, &circuit.fixed);
    Ok(pressure)
}

/// The vessels with ρ > 0.
fn diffused(ends: &[[usize; 2]], resilience: &[f64]) -> Vec<ForestEdge> {
    let all = ends.iter().zip(resilience).enumerate().filter(|(_, (_, rho))| **rho > 0.0);
    all.map(|(row, (ends, rho))| ForestEdge { resilience: *rho, row, ends: *ends, weakest: 1 }).collect()
}

/// The keys of the minimum spanning forest of 1/ρ: keys are in the order of ρ.
fn spanning_forest(diffused: &[ForestEdge], key: impl Fn(usize) -> u64) -> Vec<u64> {
    let edges = diffused.iter().map(|vessel| {
        let [a, b] = vessel.ends.map(|node| node as u32);
        (a, b, Reverse(key(vessel.row)))
    });
    let graph = UnGraph::<(), Reverse<u64>>::from_edges(edges);
    let key = |element| if let Element::Edge { weight: Reverse(key), .. } = element { Some(key) } else { None };
    min_spanning_tree(&graph).filter_map(key).collect()
}
