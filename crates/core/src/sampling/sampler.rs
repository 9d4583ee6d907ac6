//! A block of samples: which vessels are open, then flow, resilience and forest by the plan. It allocates nothing after its first block.
//! Only an enumeration of equal vessels does.

use super::block_sums::PerSample;
use super::choose_solver::{Method, Plan};
use super::forest::Coins;
use super::likelihood::Sums;
use super::options::SamplingOptions;
use super::patterns::Patterns;
use super::{full_graph, reduced_graph};
use crate::error::Result;
use crate::flow::{Boundary, Circuit};
use crate::network::Network;
use crate::support::random::BLOCK;

/// Everything about a graph that all its samples share.
#[derive(Debug)]
pub struct Sampler {
    patterns: Patterns,
    coins: Coins,
    plan: Plan,
}

/// The memory of one worker.
pub struct Workspace {
    masks: Vec<u64>,
    probability: [f64; BLOCK as usize],
    memory: Memory,
}

enum Memory {
    Full(Box<full_graph::Memory>),
    Reduced(Box<reduced_graph::Memory>),
    Reference,
}

/// Samples that are taken together.
#[derive(Debug)]
pub struct Block<'a> {
    /// Per vessel the samples in which it is open, then per terminal of the circuit those in which it holds; no bit beyond `samples`. May be
    /// overwritten.
    pub masks: &'a mut [u64],
    /// What each sample counts, for an enumeration; one without.
    pub probability: Option<&'a [f64; BLOCK as usize]>,
    /// What decides between vessels of equal resilience in a sample that is drawn.
    pub coins: &'a Coins,
    /// The figures of the samples for that.
    pub coin: &'a PerSample,
    /// How many samples, at most 64.
    pub samples: usize,
}

impl Sampler {
    /// Prepares the samples of a network.
    ///
    /// # Errors
    ///
    /// A vessel whose conductance or resilience no double can hold; a mesh beyond what indices can count.
    pub fn new(network: &Network, boundary: &Boundary, params: &SamplingOptions) -> Result<Self> {
        let keep = params.keep_probabilities(network);
        let certain: Vec<bool> = keep.iter().map(|p| *p >= 1.0).collect();
        let provisional = params.provisional(network, boundary);
        let circuit = Circuit::sampled(network, boundary, &provisional, params.viscosity)?;
        let plan = Plan::choose(network, circuit, &certain, params)?;
        let (patterns, coins) = (Patterns::new(network, &provisional, params)?, Coins::new(network.vessel_count(), params.seed));
        Ok(Self { patterns, coins, plan })
    }

    /// How many samples a run of `asked` takes: all patterns in an enumeration.
    pub fn samples(&self, asked: u64) -> u64 {
        self.patterns.samples(asked)
    }

    /// How the samples are computed.
    pub fn method(&self) -> Method {
        match &self.plan {
            Plan::Full(graph) => graph.method(),
            Plan::Reduced(graph) => graph.method(),
            Plan::Reference(reference) => reference.method(),
        }
    }

    /// Memory for one worker.
    pub fn workspace(&self) -> Workspace {
        let memory = match &self.plan {
            Plan::Full(graph) => Memory::Full(Box::new(graph.memory())),
            Plan::Reduced(graph) => Memory::Reduced(Box::new(graph.memory())),
            Plan::Reference(_) => Memory::Reference,
        };
        Workspace { masks: Vec::new(), probability: [0.0; BLOCK as usize], memory }
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
        let coin = &self.coins.of_block(block);
        let block = Block { masks: &mut work.masks, probability, coins: &self.coins, coin, samples: samples as usize };
        match (&self.plan, &mut work.memory) {
            (Plan::Full(graph), Memory::Full(memory)) => graph.block(&block, memory, sums),
            (Plan::Reduced(graph), Memory::Reduced(memory)) => graph.block(block, memory, sums)?,
            (Plan::Reference(reference), _) => reference.block(&block, sums)?,
            _ => debug_assert!(false, "the memory of another plan"),
        }
        Ok(())
    }
}
