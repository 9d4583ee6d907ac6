//! A block of samples: mask, flow, resilience, forest. A serial step that allocates nothing after its first block.

use super::likelihood::Sums;
use super::options::{SamplingOptions, Solver};
use super::patterns::Patterns;
use super::reduced_graph;
use super::reduced_graph::Reduced;
use super::whole_graph::Whole;
use super::whole_graph_lanes::Group;
use crate::error::Result;
use crate::flow::batch::conjugate_gradients::ConjugateGradients;
use crate::flow::{Boundary, Circuit};
use crate::network::Network;
use crate::support::random::BLOCK;

/// Graphs of more vessels are reduced first. Smaller ones fit the nearest caches as they are.
const MANY: usize = 4096;
/// Joins of star-mesh elimination above which other solvers are considered.
const MOST_JOINS: usize = 200_000;

/// How a run computed its samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    /// The solver: `lanes`, `gradients` or `cholesky`.
    pub solver: &'static str,
    /// The joins of its program, or the entries of its factor: what a sample (of `gradients`, a step) costs is in proportion.
    pub solver_size: usize,
    /// The forest algorithm: `bottleneck` or `kruskal`.
    pub forest: &'static str,
    /// The joins of the forest program.
    pub forest_joins: Option<usize>,
    /// The instruction set.
    pub instructions: &'static str,
}

/// Everything about a graph that all its samples share.
#[derive(Debug)]
pub struct Sampler {
    patterns: Patterns,
    how: How,
}

#[derive(Debug)]
enum How {
    Whole(Box<Whole>),
    Reduced(Box<Reduced>),
}

/// The memory of one worker.
pub struct Workspace {
    masks: Vec<u64>,
    probability: [f64; BLOCK as usize],
    how: Memory,
}

enum Memory {
    Whole(Box<Group>),
    Reduced(Box<reduced_graph::Workspace>),
}

/// Samples that are taken together.
#[derive(Debug)]
pub struct Block<'a> {
    /// Per vessel the samples in which it is open, no bit beyond `samples`. May be overwritten.
    pub masks: &'a mut [u64],
    /// What each sample counts, for an enumeration; one without.
    pub probability: Option<&'a [f64; BLOCK as usize]>,
    /// How many samples, at most 64.
    pub samples: usize,
}

impl Sampler {
    /// Prepares the samples of a network.
    ///
    /// # Errors
    ///
    /// A vessel whose conductance or resilience no double can hold; no memory for a factorisation.
    pub fn new(network: &Network, boundary: &Boundary, params: &SamplingOptions) -> Result<Self> {
        let circuit = Circuit::new(network, boundary, params.viscosity)?;
        let keep = params.keep_probabilities(network);
        let certain: Vec<bool> = keep.iter().map(|p| *p >= 1.0).collect();
        let limit = match params.solver {
            _ if network.vessel_count() > MANY => None,
            Solver::Auto => Some(MOST_JOINS),
            Solver::Lanes => Some(usize::MAX),
            Solver::Gradients | Solver::Cholesky => None,
        };
        let whole = limit.map(|limit| Whole::new(network, &circuit, &certain, params, limit)).transpose()?.flatten();
        let how = match whole {
            Some(whole) => How::Whole(Box::new(whole)),
            None => How::Reduced(Box::new(Reduced::new(network, &circuit, &certain, params)?)),
        };
        Ok(Self { patterns: Patterns::new(keep, params)?, how })
    }

    /// How many samples a run of `asked` takes: all patterns in an enumeration.
    pub fn samples(&self, asked: u64) -> u64 {
        self.patterns.samples(asked)
    }

    /// How the samples are computed.
    pub fn method(&self) -> Method {
        match &self.how {
            How::Whole(whole) => whole.method(),
            How::Reduced(reduced) => reduced.method(),
        }
    }

    /// Memory for one worker.
    pub fn workspace(&self) -> Workspace {
        let how = match &self.how {
            How::Whole(whole) => Memory::Whole(Box::new(whole.workspace())),
            How::Reduced(reduced) => Memory::Reduced(Box::new(reduced.workspace())),
        };
        Workspace { masks: Vec::new(), probability: [0.0; BLOCK as usize], how }
    }

    /// Replaces `sums` by those of the first `samples` (at most 64) samples of a block.
    ///
    /// # Errors
    ///
    /// The solver breaks down.
    pub fn block(&self, block: u64, samples: u64, work: &mut Workspace, sums: &mut Sums) -> Result<()> {
        let samples = samples.min(BLOCK);
        let probability = self.patterns.fill(block, &mut work.masks, &mut work.probability).then_some(&work.probability);
        let valid = u64::MAX >> (BLOCK - samples);
        for mask in &mut work.masks {
            *mask &= valid;
        }
        let block = Block { masks: &mut work.masks, probability, samples: samples as usize };
        match (&self.how, &mut work.how) {
            (How::Whole(whole), Memory::Whole(memory)) => whole.block(block, memory, sums),
            (How::Reduced(reduced), Memory::Reduced(memory)) => reduced.block(block, memory, sums)?,
            _ => {}
        }
        Ok(())
    }
}

/// ns a join of star-mesh elimination takes, a sample.
const JOIN: f64 = 0.30;
/// Steps of conjugate gradients that a mesh of vessels takes, and ns a ray of the core takes in one, a sample.
const STEPS: f64 = 50.0;
const STEP_RAY: f64 = 0.5;
/// Joins of a forest program, per vessel, above which Kruskal's algorithm is faster.
const BOTTLENECK_JOINS_PER_VESSEL: usize = 40;
/// Nodes of a core above which its elimination is not even ordered: conjugate gradients are sure to be faster.
pub const SMALL_CORE: usize = 2000;

/// Joins of star-mesh elimination up to which it is expected to be faster than conjugate gradients.
pub fn lanes_limit(gradients: &ConjugateGradients) -> usize {
    let nanoseconds = JOIN * gradients.joins() as f64 + STEPS * STEP_RAY * gradients.rays() as f64;
    (nanoseconds / JOIN) as usize
}

/// The longest forest program that is worth its while.
pub fn forest_limit(vessels: usize) -> usize {
    BOTTLENECK_JOINS_PER_VESSEL * vessels
}
