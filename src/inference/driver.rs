//! The sampling run: fixed blocks over the worker threads, summed over the dyadic tree of block indices.

use rayon::prelude::*;

use super::answer::decide;
use super::forest::MAX_VESSELS;
use super::likelihood::{DyadicSum, Likelihood, Snapshot, Sums};
use super::sample::{Compiled, Sampler, Uncertain, Weight, Workspace};
use super::threshold::Keep;
use crate::error::{Error, Result};
use crate::hemodynamics::cholesky::Cholesky;
use crate::hemodynamics::poiseuille::BLOOD_VISCOSITY;
use crate::hemodynamics::steady::LANES_LIMIT;
use crate::hemodynamics::{Boundary, Circuit, StarMesh};
use crate::network::Network;
use crate::perturbation::Occlusion;
use crate::rng::BLOCK;

/// Samples that a run until stable begins and ends with.
const FIRST_STABLE: u64 = 1 << 10;
const LAST_STABLE: u64 = 1 << 20;
/// Points of the convergence record, at the most.
const SNAPSHOTS: u64 = 128;

/// The solver of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Solver {
    /// Lanes, unless their program is too long.
    #[default]
    Auto,
    /// Star-mesh elimination, eight samples at a time.
    Lanes,
    /// Sparse Cholesky factorisation.
    Cholesky,
}

/// The parameters of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Params {
    /// Occlusion probability ε in [0, 1).
    pub epsilon: f64,
    /// Samples, at least 1.
    pub samples: u64,
    /// The seed.
    pub seed: u64,
    /// Which vessels are on trial.
    pub uncertain: Uncertain,
    /// What a vessel of the forest contributes.
    pub weight: Weight,
    /// Whether A = 1 everywhere instead of the prior of each vessel.
    pub uniform_prior: bool,
    /// Blood viscosity µ, Pa s, positive.
    pub viscosity: f64,
    /// The solver.
    pub solver: Solver,
}

impl Default for Params {
    fn default() -> Self {
        Self {
            epsilon: 0.5,
            samples: 1000,
            seed: 0,
            uncertain: Uncertain::default(),
            weight: Weight::default(),
            uniform_prior: false,
            viscosity: BLOOD_VISCOSITY,
            solver: Solver::default(),
        }
    }
}

impl Params {
    /// Checks every field.
    ///
    /// # Errors
    ///
    /// Names the option, its value and the range.
    pub fn validate(&self) -> Result<()> {
        if !(0.0..1.0).contains(&self.epsilon) {
            return Err(Error::parameter("--epsilon", self.epsilon, "expected a probability, 0 <= epsilon < 1"));
        }
        if self.samples == 0 || self.samples > 1 << 50 {
            return Err(Error::parameter("--samples", self.samples, "expected a number from 1 to 2^50"));
        }
        if !(self.viscosity.is_normal() && self.viscosity > 0.0) {
            return Err(Error::parameter("--viscosity", self.viscosity * 1e3, "expected a positive number of cP"));
        }
        Ok(())
    }
}

/// Hears how far a run is and may stop it.
pub trait Progress {
    /// So many samples of the total are done; false stops the run.
    fn report(&mut self, done: u64, total: u64) -> bool;
}

impl<F: FnMut(u64, u64) -> bool> Progress for F {
    fn report(&mut self, done: u64, total: u64) -> bool {
        self(done, total)
    }
}

/// Samples an over-connected graph and returns what the samples say, with the name of the solver used.
///
/// # Errors
///
/// A parameter or vessel out of its range, a breakdown of the Cholesky solver, or a stop by `progress`.
pub fn infer(
    network: &Network,
    boundary: &Boundary,
    params: &Params,
    progress: &mut impl Progress,
) -> Result<(Likelihood, &'static str)> {
    params.validate()?;
    if network.vessel_count() >= MAX_VESSELS {
        return Err(Error::parameter("vessels", network.vessel_count(), format!("expected fewer than {MAX_VESSELS}")));
    }
    let circuit = Circuit::new(network, boundary, params.viscosity)?;
    let solver = compile(&circuit, params.solver)?;
    let uncertain = params.uncertain.vessels(network);
    let keep = network.vessels().zip(&uncertain).map(|((_, vessel), uncertain)| {
        let prior = if params.uniform_prior { 1.0 } else { vessel.prior };
        if *uncertain { (1.0 - params.epsilon) * prior } else { 1.0 }
    });
    let sampler = Sampler::new(network, circuit, solver, Occlusion::new(keep), params.weight, params.seed);
    let (sums, trace) = run(&sampler, network.vessel_count(), params.samples, &uncertain, progress)?;
    Ok((Likelihood::new(sums, uncertain, trace), sampler.solver()))
}

/// Doubles the samples, from 1,024 up to 2²⁰, until no vessel on trial is undecided under `rule`.
///
/// The result is that of [`infer`] with the number of samples reached.
///
/// # Errors
///
/// As [`infer`].
pub fn infer_until_stable(
    network: &Network,
    boundary: &Boundary,
    params: &Params,
    rule: Keep,
    progress: &mut impl Progress,
) -> Result<(Likelihood, &'static str)> {
    let mut params = Params { samples: FIRST_STABLE, ..params.clone() };
    loop {
        let (result, solver) = infer(network, boundary, &params, progress)?;
        if params.samples >= LAST_STABLE || decide(rule, &result).undecided.is_empty() {
            return Ok((result, solver));
        }
        params.samples *= 2;
    }
}

/// Compiles a circuit for the solver asked for.
fn compile(circuit: &Circuit, solver: Solver) -> Result<Compiled> {
    let limit = if solver == Solver::Lanes { usize::MAX } else { LANES_LIMIT };
    let lanes = if solver == Solver::Cholesky { None } else { StarMesh::compile(circuit, limit) };
    match lanes {
        Some(program) => Ok(Compiled::Lanes(Box::new(program))),
        None => Cholesky::compile(circuit).map(|c| Compiled::Cholesky(Box::new(c))).ok_or(Error::Breakdown),
    }
}

fn run(
    sampler: &Sampler,
    vessels: usize,
    samples: u64,
    uncertain: &[bool],
    progress: &mut impl Progress,
) -> Result<(Sums, Vec<Snapshot>)> {
    let blocks = samples.div_ceil(BLOCK);
    // A task is an aligned power of two of blocks, so that it is a node of the dyadic tree.
    let task = (blocks / SNAPSHOTS).max(1).next_power_of_two();
    let wave = 4 * rayon::current_num_threads() as u64;
    let (mut sum, mut trace) = (DyadicSum::default(), Vec::new());
    let tasks = blocks.div_ceil(task);
    for first in (0..tasks).step_by(wave as usize) {
        let done: Vec<Result<Vec<(u64, Sums)>>> = (first..tasks.min(first + wave))
            .into_par_iter()
            .map_init(Workspace::default, |work, at| {
                let mut parts = DyadicSum::default();
                for block in at * task..blocks.min((at + 1) * task) {
                    let mut sums = Sums::zero(vessels);
                    sampler.block(block, samples - block * BLOCK, work, &mut sums)?;
                    parts.push(1, sums);
                }
                Ok(parts.into_nodes())
            })
            .collect();
        for nodes in done {
            for (blocks, sums) in nodes? {
                sum.push(blocks, sums);
            }
            if let Some(total) = sum.total() {
                let likelihood = total.likelihood.iter().zip(uncertain).filter(|(_, u)| **u).map(|(l, _)| *l);
                trace.push(Snapshot { samples: total.samples, likelihood: likelihood.collect() });
            }
        }
        let done = samples.min((first + wave) * task * BLOCK);
        if !progress.report(done, samples) && done < samples {
            return Err(Error::Stopped { done, total: samples });
        }
    }
    Ok((sum.total().unwrap_or_default(), trace))
}
