//! The sampling run: worker threads compute fixed blocks of samples, which are summed over the dyadic tree of block indices.
//!
//! A worker finds block by block which vessels are open, then flow, resilience and forest by the plan. For these it allocates nothing
//! after its first block; only an enumeration of equal vessels does.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::choose_solver::{FULL_GRAPH_LANES, REDUCED_GRAPH_LANES};
use super::coins::{Block, MAX_VESSELS};
use super::{Coins, DyadicSums, Likelihood, Method, PartialRun, SamplingOptions, Solver, Sums, options::Patterns};
use super::{reference::Reference, sampled_graph::SampledGraph};
use crate::error::{Error, Result, require};
use crate::flow::{Boundary, Circuit, Tube};
use crate::{network::Network, support::random::BLOCK};

/// The fewest samples of a run until stable.
pub const FIRST_STABLE: u64 = 1 << 10;
/// The most samples of a run until stable.
const LAST_STABLE: u64 = 1 << 20;
/// The most blocks that a worker sums up by itself before it adds them to what all workers share.
const UNIT: u64 = 16;
/// The least time between two reports of a worker that has not finished its blocks.
const REPORT_AFTER: Duration = Duration::from_millis(50);
/// The most sums whose memory a worker keeps to use again.
const SPARE: usize = 6;

/// Hears how far a run has come, and may stop it.
pub trait Progress: Send {
    /// `done` of `total` samples are finished; false stops the run.
    fn report(&mut self, _done: u64, _total: u64) -> bool {
        true
    }

    /// More of the run is finished. A later [`Sampling::sample`] can continue from this part.
    fn finished(&mut self, _part: &PartialRun) {}
}

impl<F: FnMut(u64, u64) -> bool + Send> Progress for F {
    fn report(&mut self, done: u64, total: u64) -> bool {
        self(done, total)
    }
}

/// Samples an over-connected graph. Returns the likelihoods, and how they were computed.
///
/// # Errors
///
/// A parameter or vessel out of its range, a breakdown of the solver, or a stop by `progress`.
pub fn infer(
    network: &Network,
    boundary: &Boundary,
    params: &SamplingOptions,
    progress: &mut (impl Progress + ?Sized),
) -> Result<(Likelihood, Method)> {
    let sampling = Sampling::new(network, boundary, params)?;
    let mut part = sampling.part();
    sampling.sample(&mut part, progress)?;
    Ok((sampling.likelihood(&part), sampling.method()))
}

/// A run that is prepared, and can be stopped and resumed.
#[derive(Debug)]
pub struct Sampling {
    patterns: Patterns,
    coins: Coins,
    plan: SamplingPlan,
    uncertain: Vec<bool>,
    /// The vessels that are closed in every sample.
    never: Vec<usize>,
    samples: u64,
    /// In an enumeration, the number of samples that L is scaled to.
    scaled_to: Option<u64>,
}

impl Sampling {
    /// Prepares a run.
    ///
    /// # Errors
    ///
    /// A parameter or vessel out of its range, such as one whose conductance or resilience no double can hold; a mesh beyond what indices
    /// can count.
    pub fn new(network: &Network, boundary: &Boundary, params: &SamplingOptions) -> Result<Self> {
        params.validate()?;
        let vessels = network.vessel_count();
        require(vessels < MAX_VESSELS, "vessels", vessels, format!("expected fewer than {MAX_VESSELS}"))?;
        let keep = params.keep_probabilities(network);
        let certain: Vec<bool> = keep.iter().map(|p| *p >= 1.0).collect();
        let provisional = params.provisional(network, boundary);
        let circuit = Circuit::with(network, boundary, &provisional, &Tube::at_rest(network, params.viscosity))?;
        // What is asked for, or what is predicted to be the fastest.
        let plan = if params.solver == Solver::Reference {
            SamplingPlan::Reference(Box::new(Reference::new(network, circuit, params.weight)))
        } else {
            let full = SampledGraph::full(network, &circuit, &certain, params)?;
            let reduced = || SampledGraph::reduced(network, &circuit, &certain, params);
            SamplingPlan::Graph(Box::new(full.map_or_else(reduced, Ok)?))
        };
        let (patterns, coins) = (Patterns::new(network, &provisional, params)?, Coins::new(network.vessel_count(), params.seed));
        let (samples, uncertain) = (patterns.samples(params.samples), params.uncertain.vessels(network));
        let never = (0..vessels).filter(|row| keep[*row] <= 0.0).collect();
        Ok(Self { patterns, coins, plan, uncertain, never, samples, scaled_to: params.exact.then_some(params.samples) })
    }

    /// How the samples are computed.
    pub fn method(&self) -> Method {
        match &self.plan {
            SamplingPlan::Graph(graph) => graph.method(),
            SamplingPlan::Reference(reference) => reference.method(),
        }
    }

    /// A worker.
    pub fn workspace(&self) -> SamplingWorkspace<'_> {
        SamplingWorkspace {
            sampling: self,
            masks: Vec::new(),
            probability: [0.0; BLOCK as usize],
            sums_of: match &self.plan {
                SamplingPlan::Graph(graph) if graph.is_reduced => side_by_side::<REDUCED_GRAPH_LANES>(graph),
                SamplingPlan::Graph(graph) => side_by_side::<FULL_GRAPH_LANES>(graph),
                SamplingPlan::Reference(reference) => Box::new(|block, sums| reference.block(&block, sums)),
            },
        }
    }

    /// Samples of the whole run.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// The part of the run before any block is finished.
    pub fn part(&self) -> PartialRun {
        PartialRun::new(self.uncertain.clone(), self.samples)
    }

    /// Computes the blocks that `part` does not have yet, and adds them to it.
    ///
    /// # Errors
    ///
    /// A breakdown of the solver, or a stop by `progress`; `part` then has what was finished.
    pub fn sample<P: Progress + ?Sized>(&self, part: &mut PartialRun, progress: &mut P) -> Result<()> {
        let (total, done) = (part.samples(), part.done());
        // The blocks of a unit, a power of two. Units are given out in rising order, so that finished ones soon join their neighbours.
        let unit = part.step().min(UNIT);
        let units = part.sums().gaps(0..part.blocks()).into_iter().flat_map(move |gap| {
            let numbers = gap.start / unit..gap.end.div_ceil(unit);
            numbers.map(move |number| gap.start.max(number * unit)..gap.end.min((number + 1) * unit))
        });
        let (stop, units) = (AtomicBool::new(false), Mutex::new(units));
        let shared = Mutex::new(SharedRun { part, done, progress });
        let report = |shared: &mut SharedRun<'_, P>, fresh: u64| {
            shared.done += fresh;
            if !shared.progress.report(shared.done, total) {
                stop.store(true, Ordering::Relaxed);
            }
        };
        let worker = |_| -> Result<()> {
            let (mut memory, mut spare) = (None, Vec::new());
            while !stop.load(Ordering::Relaxed) {
                let Some(unit) = locked(&units).next() else { break };
                // One that finds nothing to do has no need of any.
                let work = memory.get_or_insert_with(|| self.workspace());
                let (mut sum, mut fresh, mut reported) = (DyadicSums::default(), 0, Instant::now());
                for block in unit {
                    let mut sums = spare.pop().unwrap_or_else(|| Sums::zero(self.uncertain.len()));
                    work.block(block, self.samples - block * crate::support::random::BLOCK, &mut sums)?;
                    fresh += sums.samples;
                    sum.insert(block, 1, sums, &mut spare, |_, _, _| {});
                    if reported.elapsed() > REPORT_AFTER {
                        reported = Instant::now();
                        report(&mut locked(&shared), std::mem::take(&mut fresh));
                    }
                    if stop.load(Ordering::Relaxed) {
                        break;
                    }
                }
                let shared = &mut *locked(&shared);
                for (first, blocks, sums) in sum.into_nodes() {
                    shared.part.insert(first, blocks, sums, &mut spare);
                }
                spare.truncate(SPARE);
                report(shared, fresh);
                shared.progress.finished(shared.part);
            }
            Ok(())
        };
        let ended = (0..rayon::current_num_threads()).into_par_iter().with_max_len(1).map(|at| {
            // One that fails stops the others.
            worker(at).inspect_err(|_| stop.store(true, Ordering::Relaxed))
        });
        ended.collect::<Result<()>>()?;
        let SharedRun { done, .. } = shared.into_inner().unwrap_or_else(PoisonError::into_inner);
        if done < total { Err(Error::Stopped { done, total }) } else { Ok(()) }
    }

    /// Samples the whole run, and doubles its samples, up to 2²⁰, until `decided` says that they suffice. It continues from what `part` has.
    ///
    /// # Errors
    ///
    /// As [`Sampling::sample`], or what `decided` returns.
    pub fn until_stable(
        &mut self,
        part: &mut PartialRun,
        decided: impl Fn(&Likelihood) -> Result<bool>,
        progress: &mut (impl Progress + ?Sized),
    ) -> Result<Likelihood> {
        self.samples = part.samples();
        loop {
            self.sample(part, progress)?;
            let result = self.likelihood(part);
            if self.samples >= LAST_STABLE || decided(&result)? {
                return Ok(result);
            }
            self.samples *= 2;
            part.double();
        }
    }

    /// The likelihoods, from a part that is the whole run.
    pub fn likelihood(&self, part: &PartialRun) -> Likelihood {
        let sums = part.sums().total().unwrap_or_default();
        if let Some(samples) = self.scaled_to {
            return Likelihood::exact(sums, self.uncertain.clone(), samples);
        }
        let mut found = Likelihood::new(sums, self.uncertain.clone(), part.trace());
        self.never.iter().for_each(|row| found.std_error[*row] = 0.0);
        found
    }
}

/// What the workers share.
struct SharedRun<'a, P: ?Sized> {
    part: &'a mut PartialRun,
    done: u64,
    progress: &'a mut P,
}

/// The content of a lock. A panic elsewhere leaves it usable: it only holds sums and counts.
fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Replaces sums by those of a block, in memory of its own.
type SumsOfBlock<'a> = Box<dyn FnMut(Block<'_>, &mut Sums) -> Result<()> + 'a>;

/// One worker and its memory.
pub struct SamplingWorkspace<'a> {
    sampling: &'a Sampling,
    masks: Vec<u64>,
    probability: [f64; BLOCK as usize],
    sums_of: SumsOfBlock<'a>,
}

/// A graph made ready for the way in which its samples are computed.
#[derive(Debug)]
enum SamplingPlan {
    /// Vessel by vessel, or reduced first to what samples can change.
    Graph(Box<SampledGraph>),
    /// By the book.
    Reference(Box<Reference>),
}

impl SamplingWorkspace<'_> {
    /// Replaces `sums` by those of the first `samples` (at most 64) samples of a block.
    ///
    /// # Errors
    ///
    /// The solver breaks down.
    pub fn block(&mut self, block: u64, samples: u64, sums: &mut Sums) -> Result<()> {
        let Sampling { patterns, coins, .. } = self.sampling;
        let samples = samples.min(BLOCK);
        let probability = patterns.fill(block, &mut self.masks, &mut self.probability).then_some(&self.probability);
        let valid = u64::MAX >> (BLOCK - samples);
        for mask in &mut self.masks {
            *mask &= valid;
        }
        let coin = &coins.of_block(block);
        let block = Block { masks: &mut self.masks, probability, coins, coin, samples: samples as usize };
        (self.sums_of)(block, sums)
    }
}

/// A worker that computes so many samples side by side.
fn side_by_side<const B: usize>(graph: &SampledGraph) -> SumsOfBlock<'_> {
    let mut work = graph.workspace::<B>();
    Box::new(move |block, sums| graph.block(block, &mut work, sums))
}
