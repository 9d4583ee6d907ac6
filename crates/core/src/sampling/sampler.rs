//! The sampler: block by block which vessels are open, then flow, resilience and forest by the plan. It allocates nothing after its first
//! block; only an enumeration of equal vessels does.

use super::choose_solver::{FULL_GRAPH_LANES, REDUCED_GRAPH_LANES, most_joins_in_full};
use super::sampled_graph::SampledGraph;
use super::{Coins, Method, SamplingOptions, Solver, Sums, block::Block, patterns::Patterns, reference::Reference};
use crate::flow::{Boundary, Circuit, Tube};
use crate::{error::Result, network::Network, support::random::BLOCK};

/// Everything about a graph that all its samples share.
#[derive(Debug)]
pub struct Sampler {
    patterns: Patterns,
    coins: Coins,
    plan: SamplingPlan,
}

/// Replaces sums by those of a block, in memory of its own.
type SumsOfBlock<'a> = Box<dyn FnMut(Block<'_>, &mut Sums) -> Result<()> + 'a>;

/// One worker and its memory.
pub struct SamplerWorkspace<'a> {
    sampler: &'a Sampler,
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
        let circuit = Circuit::with(network, boundary, &provisional, &Tube::at_rest(network, params.viscosity))?;
        // What is asked for, or what is predicted to be the fastest.
        let plan = if params.solver == Solver::Reference {
            SamplingPlan::Reference(Box::new(Reference::new(network, circuit, params.weight)))
        } else {
            let most = most_joins_in_full(network.vessel_count(), params.solver);
            let full = most.map(|most| SampledGraph::full(network, &circuit, &certain, params, most)).transpose()?.flatten();
            let reduced = || SampledGraph::reduced(network, &circuit, &certain, params);
            SamplingPlan::Graph(Box::new(full.map_or_else(reduced, Ok)?))
        };
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
            SamplingPlan::Graph(graph) => graph.method(),
            SamplingPlan::Reference(reference) => reference.method(),
        }
    }

    /// A worker.
    pub fn workspace(&self) -> SamplerWorkspace<'_> {
        SamplerWorkspace {
            sampler: self,
            masks: Vec::new(),
            probability: [0.0; BLOCK as usize],
            sums_of: match &self.plan {
                SamplingPlan::Graph(graph) if graph.is_reduced => side_by_side::<REDUCED_GRAPH_LANES>(graph),
                SamplingPlan::Graph(graph) => side_by_side::<FULL_GRAPH_LANES>(graph),
                SamplingPlan::Reference(reference) => Box::new(|block, sums| reference.block(&block, sums)),
            },
        }
    }
}

impl SamplerWorkspace<'_> {
    /// Replaces `sums` by those of the first `samples` (at most 64) samples of a block.
    ///
    /// # Errors
    ///
    /// The solver breaks down.
    pub fn block(&mut self, block: u64, samples: u64, sums: &mut Sums) -> Result<()> {
        let Sampler { patterns, coins, .. } = self.sampler;
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
