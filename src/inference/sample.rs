//! One sample: mask, flow, resilience, forest. A serial step over a block that allocates nothing after its first.

use super::forest::Forest;
use super::likelihood::Sums;
use crate::error::Result;
use crate::hemodynamics::Circuit;
use crate::hemodynamics::cholesky::{self, Cholesky};
use crate::hemodynamics::floating::stranded;
use crate::hemodynamics::star_mesh::{self, LANES, Lanes, StarMesh};
use crate::network::{Network, Origin};
use crate::perturbation::Occlusion;
use crate::resilience::{is_diffused, resilience_per_square_drop};
use crate::rng::BLOCK;

/// Which vessels are on trial.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Uncertain {
    /// The candidates; observed vessels are never occluded.
    #[default]
    Candidates,
    /// Every vessel, as in the paper.
    All,
}

impl Uncertain {
    /// Per vessel whether it is on trial; one marked certain never is.
    pub fn vessels(self, network: &Network) -> Vec<bool> {
        network.vessels().map(|(_, v)| !v.certain && (self == Self::All || v.origin == Origin::Candidate)).collect()
    }
}

/// What a vessel of the forest contributes to L.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weight {
    /// Its resilience ρ, as in the paper.
    #[default]
    Resilience,
    /// One.
    Count,
    /// The resilience ρ_G of the whole sample.
    Global,
}

/// The solver of a circuit, compiled.
#[derive(Debug)]
pub enum Compiled {
    /// Star-mesh elimination in lanes.
    Lanes(Box<StarMesh>),
    /// Sparse Cholesky, one sample at a time.
    Cholesky(Box<Cholesky>),
}

/// Everything about a graph that all its samples share.
#[derive(Debug)]
pub struct Sampler {
    circuit: Circuit,
    solver: Compiled,
    occlusion: Occlusion,
    /// ρ/ΔP² of each vessel.
    per_square_drop: Vec<f64>,
    weight: Weight,
    seed: u64,
}

/// The memory of one worker.
#[derive(Default)]
pub struct Workspace {
    masks: Vec<u64>,
    present: Vec<u8>,
    lanes: star_mesh::Workspace,
    cholesky: cholesky::Workspace,
    pressure: Vec<Lanes>,
    resilience: Vec<Lanes>,
    forest: Forest,
}

impl Sampler {
    /// Prepares the samples of a network.
    pub fn new(network: &Network, circuit: Circuit, solver: Compiled, occlusion: Occlusion, weight: Weight, seed: u64) -> Self {
        let vessels = network.vessels().map(|(_, v)| v).zip(&circuit.conductance);
        let per_square_drop = vessels.map(|(v, c)| resilience_per_square_drop(*c, v.radius, v.length)).collect();
        Self { circuit, solver, occlusion, per_square_drop, weight, seed }
    }

    /// The solver's name.
    pub fn solver(&self) -> &'static str {
        match self.solver {
            Compiled::Lanes(_) => "lanes",
            Compiled::Cholesky(_) => "cholesky",
        }
    }

    /// Adds the first `samples` (at most 64) samples of a block to `sums`.
    ///
    /// # Errors
    ///
    /// The Cholesky factorisation breaks down.
    pub fn block(&self, block: u64, samples: u64, work: &mut Workspace, sums: &mut Sums) -> Result<()> {
        self.occlusion.draw(self.seed, block, &mut work.masks);
        let samples = samples.min(BLOCK) as usize;
        for first in (0..samples).step_by(LANES) {
            work.present.clear();
            work.present.extend(work.masks.iter().map(|mask| (mask >> first) as u8));
            let lanes = LANES.min(samples - first);
            self.solve(lanes, work)?;
            self.resiliences(work);
            for lane in 0..lanes {
                self.accumulate(lane, work, sums);
            }
        }
        Ok(())
    }

    fn solve(&self, lanes: usize, work: &mut Workspace) -> Result<()> {
        match &self.solver {
            Compiled::Lanes(program) => {
                let stranded = stranded(&self.circuit, &work.present, lanes);
                program.solve(&work.present, &stranded, &mut work.lanes, &mut work.pressure);
            }
            Compiled::Cholesky(factor) => {
                work.pressure.resize(self.circuit.node_count(), [0.0; LANES]);
                for lane in 0..lanes {
                    let open = |vessel: usize| work.present[vessel] >> lane & 1 == 1;
                    factor.solve(open, &mut work.cholesky, |node, p| work.pressure[node][lane] = p)?;
                }
            }
        }
        Ok(())
    }

    /// ρ of every vessel in every lane; zero where it is closed or not diffused.
    fn resiliences(&self, work: &mut Workspace) {
        let level = self.circuit.level;
        work.resilience.clear();
        let vessels = self.circuit.ends.iter().zip(&self.per_square_drop).zip(&work.present);
        work.resilience.extend(vessels.map(|((ends, per_square_drop), present)| {
            let (a, b) = (work.pressure[ends[0]], work.pressure[ends[1]]);
            std::array::from_fn(|lane| {
                let drop = a[lane] - b[lane];
                let flows = present >> lane & 1 == 1 && is_diffused(drop, a[lane] + level, b[lane] + level);
                if flows { drop * drop * per_square_drop } else { 0.0 }
            })
        }));
    }

    fn accumulate(&self, lane: usize, work: &mut Workspace, sums: &mut Sums) {
        work.forest.clear();
        let (mut total, mut present) = (0.0, 0_u32);
        for (vessel, resilience) in work.resilience.iter().enumerate() {
            present += u32::from(work.present[vessel] >> lane & 1);
            if resilience[lane] > 0.0 {
                total += resilience[lane];
                work.forest.add(resilience[lane], vessel);
            }
        }
        let global = if present > 0 { total / f64::from(present) } else { 0.0 };
        sums.samples += 1;
        sums.network_resilience += global;
        work.forest.grow(self.circuit.node_count(), &self.circuit.ends, |vessel| {
            let contribution = match self.weight {
                Weight::Resilience => work.resilience[vessel][lane],
                Weight::Count => 1.0,
                Weight::Global => global,
            };
            sums.likelihood[vessel] += contribution;
            sums.square[vessel] += contribution * contribution;
            sums.count[vessel] += 1;
        });
    }
}
