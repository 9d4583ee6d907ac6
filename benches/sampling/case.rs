//! A graph to sample, with the pieces of the loop laid out one by one.

use std::path::Path;

use willis::internals::flow::batch::conductances::MaskedRows;
use willis::internals::flow::boundary_conditions::stated;
use willis::internals::flow::peeling::{Peeled, peel};
use willis::internals::flow::resilience::{is_diffused, resilience_per_square_drop};
use willis::internals::flow::{BatchSolver, Boundary, Circuit, FoundOutlets};
use willis::internals::formats::{Content, ReadOptions, read};
use willis::internals::network::Network;
use willis::internals::perturbation::Occlusion;
use willis::internals::sampling::{Coins, SamplingOptions, Solver, Uncertain};
use willis::internals::support::simd::Scalar;

use crate::Result;

/// Occlusion probability of all benchmarks.
const EPSILON: f64 = 0.3;

/// A graph and its conditions.
pub struct Case {
    pub network: Network,
    pub boundary: Boundary,
}

/// What the stages are compiled from.
pub struct Pieces {
    pub circuit: Circuit,
    pub occlusion: Occlusion,
    /// Per vessel its ends where it can carry flow.
    pub in_forest: Vec<Option<[usize; 2]>>,
    /// Per vessel ρ over the square of its pressure drop.
    pub factor: Vec<f64>,
}

/// Every vessel uncertain, no prior.
pub fn params(solver: Solver, samples: u64) -> SamplingOptions {
    SamplingOptions { epsilon: EPSILON, uncertain: Uncertain::All, samples, solver, ..SamplingOptions::default() }
}

impl Case {
    pub fn read(path: &str) -> Result<Self> {
        match read(Path::new(path), &ReadOptions::default())?.content {
            Content::Graph(network) => Self::new(network),
            Content::Centerlines(_) | Content::Vessels(_) => Err(format!("{path}: expected a graph").into()),
        }
    }

    pub fn new(network: Network) -> Result<Self> {
        let boundary = Boundary::resolve(&network, &stated(&network), FoundOutlets::Ground)?;
        Ok(Self { network, boundary })
    }

    pub fn pieces(&self) -> Result<Pieces> {
        let viscosity = params(Solver::Lanes, 1).viscosity;
        let vessels = self.network.vessel_count();
        let Peeled { circuit, stand_in } = peel(&Circuit::new(&self.network, &self.boundary, viscosity)?, &vec![false; vessels]);
        let ends = (0..vessels).map(|row| self.network.ends(row));
        let factor = self.network.vessels().zip(&stand_in).map(|((_, vessel), first)| {
            first.map_or(0.0, |first| resilience_per_square_drop(circuit.conductance[first], vessel.volume()))
        });
        Ok(Pieces {
            occlusion: Occlusion::new(self.network.vessels().map(|(_, vessel)| (1.0 - EPSILON) * vessel.prior)),
            in_forest: ends.zip(&stand_in).map(|(ends, first)| first.map(|_| ends)).collect(),
            factor: factor.collect(),
            circuit,
        })
    }
}

impl Pieces {
    /// The forest keys of the first `samples` samples, vessel by vessel; zero where a vessel is not diffused.
    pub fn keys(&self, solver: &BatchSolver, samples: usize) -> Vec<Vec<u64>> {
        let coins = Coins::new(self.factor.len(), 0);
        let coin = coins.of_block(0);
        let (mut masks, mut work) = (Vec::new(), solver.workspace::<1>());
        let sample = |sample: usize| {
            if sample.is_multiple_of(64) {
                self.occlusion.draw(0, sample as u64 / 64, &mut masks);
            }
            let rows = MaskedRows { conductance: &self.circuit.conductance, masks: &masks, first: sample % 64 };
            solver.solve(Scalar::new(), &rows, sample % 64, &[], &mut work);
            let resilience = |vessel: usize| {
                let [a, b] = self.circuit.ends[vessel].map(|node| work.pressure()[solver.slot(node)][0]);
                let open = masks[vessel] >> (sample % 64) & 1 == 1;
                let flows = open && is_diffused(a - b, a + self.circuit.level, b + self.circuit.level);
                if flows { (a - b) * (a - b) * self.factor[vessel] } else { 0.0 }
            };
            let keys = (0..self.factor.len()).map(|vessel| match resilience(vessel) {
                rho if rho > 0.0 => coins.key(rho, vessel, coin[sample % coin.len()]),
                _ => 0,
            });
            keys.collect()
        };
        (0..samples).map(sample).collect()
    }
}
