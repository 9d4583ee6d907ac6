//! The sampling run: fixed blocks over the worker threads, summed over the dyadic tree of block indices.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

use super::answer::decide;
use super::forest::MAX_VESSELS;
use super::likelihood::{DyadicSum, Likelihood, Snapshot, Sums};
use super::params::Params;
use super::sampler::{Method, Sampler, Workspace};
use super::threshold::Keep;
use crate::error::{Error, Result};
use crate::hemodynamics::Boundary;
use crate::network::Network;
use crate::rng::BLOCK;

/// Samples that a run until stable begins and ends with.
const FIRST_STABLE: u64 = 1 << 10;
const LAST_STABLE: u64 = 1 << 20;
/// Blocks between two reports of a worker.
const REPORT_EVERY: u64 = 16;
/// Points of the convergence record, at the most.
const SNAPSHOTS: u64 = 128;

/// Hears how far a run is and may stop it.
pub trait Progress: Send {
    /// So many samples of the total are done; false stops the run.
    fn report(&mut self, done: u64, total: u64) -> bool;
}

impl<F: FnMut(u64, u64) -> bool + Send> Progress for F {
    fn report(&mut self, done: u64, total: u64) -> bool {
        self(done, total)
    }
}

/// Samples an over-connected graph and returns what the samples say, with how they were computed.
///
/// # Errors
///
/// A parameter or vessel out of its range, a breakdown of the Cholesky solver, or a stop by `progress`.
pub fn infer(
    network: &Network,
    boundary: &Boundary,
    params: &Params,
    progress: &mut impl Progress,
) -> Result<(Likelihood, Method)> {
    params.validate()?;
    if network.vessel_count() >= MAX_VESSELS {
        return Err(Error::parameter("vessels", network.vessel_count(), format!("expected fewer than {MAX_VESSELS}")));
    }
    let sampler = Sampler::new(network, boundary, params)?;
    let uncertain = params.uncertain.vessels(network);
    let (sums, trace) = run(&sampler, network.vessel_count(), sampler.samples(params.samples), &uncertain, progress)?;
    let method = sampler.method();
    let likelihood =
        if params.exact { Likelihood::exact(sums, uncertain, params.samples) } else { Likelihood::new(sums, uncertain, trace) };
    Ok((likelihood, method))
}

/// Doubles the samples, from 1,024 up to 2²⁰, until no vessel on trial is undecided under `rule`; under the median where the
/// evidence decides, which no samples change.
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
) -> Result<(Likelihood, Method)> {
    let mut params = Params { samples: FIRST_STABLE, ..params.clone() };
    let rule = if rule.asks_evidence() { Keep::Median } else { rule };
    loop {
        let (result, method) = infer(network, boundary, &params, progress)?;
        if params.samples >= LAST_STABLE || decide(rule, network, &result)?.undecided.is_empty() {
            return Ok((result, method));
        }
        params.samples *= 2;
    }
}

/// Workspaces that no task holds at the moment.
type Spare = Mutex<Vec<(Workspace, Vec<Sums>)>>;

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
    let spare = Spare::default();
    let stop = AtomicBool::new(false);
    let heard = Mutex::new((0, progress));
    let one_task = |at: u64| -> Result<Vec<(u64, Sums)>> {
        let (first, last) = (at * task, blocks.min((at + 1) * task));
        let (mut work, mut pool) = locked(&spare).pop().unwrap_or_else(|| (sampler.workspace(), Vec::new()));
        let (mut parts, mut fresh) = (DyadicSum::default(), 0);
        for block in first..last {
            if stop.load(Ordering::Relaxed) {
                return Ok(Vec::new());
            }
            let mut sums = pool.pop().unwrap_or_else(|| Sums::zero(vessels));
            sampler.block(block, samples - block * BLOCK, &mut work, &mut sums)?;
            fresh += sums.samples;
            parts.push(1, sums, &mut pool);
            if (block + 1) % REPORT_EVERY == 0 || block + 1 == last {
                let (done, progress) = &mut *locked(&heard);
                *done += std::mem::take(&mut fresh);
                if !progress.report(*done, samples) {
                    stop.store(true, Ordering::Relaxed);
                }
            }
        }
        locked(&spare).push((work, pool));
        Ok(parts.into_nodes())
    };
    let tasks: Vec<Result<Vec<(u64, Sums)>>> = (0..blocks.div_ceil(task)).into_par_iter().map(one_task).collect();
    let done = locked(&heard).0;
    if done < samples && stop.load(Ordering::Relaxed) {
        return Err(Error::Stopped { done, total: samples });
    }
    let (mut sum, mut trace, mut pool) = (DyadicSum::default(), Vec::new(), Vec::new());
    for nodes in tasks {
        for (blocks, sums) in nodes? {
            sum.push(blocks, sums, &mut pool);
        }
        if let Some(total) = sum.total() {
            let likelihood = total.likelihood.iter().zip(uncertain).filter(|(_, u)| **u).map(|(l, _)| *l);
            trace.push(Snapshot { samples: total.samples, likelihood: likelihood.collect() });
        }
    }
    Ok((sum.total().unwrap_or_default(), trace))
}

/// The content of a lock; a panic elsewhere leaves it usable, for it is only memory and a count.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
