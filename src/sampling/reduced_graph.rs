//! Blocks of samples of a large graph, reduced first to what samples can change.
//!
//! Vessels of one chain or one tree share one flow up to a factor, and so do the sums of their contributions: they are kept once, for the
//! vessel that stands for them all, and each other has its share. In a chain only the vessel of least ρ can be the one that a forest
//! leaves out.

use super::forest_lanes::Bottleneck;
use super::likelihood::Sums;
use super::options::{SamplingOptions, Solver, Weight};
use super::reduced_graph_lanes::InLanes;
use super::reduced_graph_single::OneByOne;
use super::sampler::{Block, Method};
use super::sums::{Samples, open_vessels};
use super::ties::Ties;
use super::{reduced_graph_lanes, reduced_graph_single, sampler};
use crate::error::{Error, Result};
use crate::flow::batch::conjugate_gradients::ConjugateGradients;
use crate::flow::batch::reduction::Reduction;
use crate::flow::cholesky::Cholesky;
use crate::flow::circuit::beyond_doubles;
use crate::flow::floating::stranded;
use crate::flow::pressures::MOST_BACKWARD;
use crate::flow::resilience::{resilience, resilience_per_square_flow};
use crate::flow::{Circuit, StarMesh};
use crate::network::Network;
use crate::support::random::BLOCK;
use crate::support::simd::{InstructionSet, Scalar};

/// Everything about a reduced graph that all its samples share.
#[derive(Debug)]
pub struct Reduced {
    core: Core,
    /// Vessels for which another stands, with that one and their share of its sums.
    shares: Vec<(u32, u32, f64)>,
    weight: Weight,
    instructions: InstructionSet,
}

/// The memory of one worker, by the way in which its samples are taken.
pub enum Workspace {
    Lanes(Box<reduced_graph_lanes::Memory>),
    OneByOne(Box<reduced_graph_single::Memory>),
}

/// A reduced graph.
#[derive(Debug)]
pub struct Core {
    pub circuit: Circuit,
    pub links: Vec<LinkFlow>,
    pub trees: Vec<TreeFlow>,
    pub solve: Solve,
    /// The forests of eight samples at a time; without it they are grown one after another, by Kruskal's algorithm.
    pub bottleneck: Option<Bottleneck>,
    pub ties: Ties,
}

/// What the samples of a block share.
#[derive(Debug, Clone, Copy)]
pub struct ReducedBlock<'a> {
    pub core: &'a Core,
    pub samples: usize,
    /// What each sample counts, for an enumeration; one without.
    pub probability: Option<&'a [f64; BLOCK as usize]>,
    /// |Ẽ| of each.
    pub present: &'a Samples,
    /// Per link the samples in which it is open.
    pub masks: &'a [u64],
    /// Nodes of the core whose injected flow has nowhere to go, with the samples in which that is so.
    pub stranded: &'a [(usize, u64)],
    pub weight: Weight,
}

/// How the resilience of a link follows from pressures.
#[derive(Debug, Clone, Copy)]
pub struct LinkFlow {
    /// m³/(Pa s).
    pub conductance: f64,
    /// ρ of its weakest vessel over the square of its flow.
    pub factor: f64,
    /// Σ ρ of its vessels over that of the weakest.
    pub whole: f64,
    /// Where the pressures at its ends stand.
    pub slots: [u32; 2],
    /// The row of its weakest vessel.
    pub row: u32,
    /// The row that stands for its other vessels, which every forest takes as long as there is flow, and its ρ over the weakest.
    pub carried: Option<(u32, f64)>,
    /// Whether samples may close it.
    pub may_close: bool,
}

/// How the resilience in a tree follows from the pressure P at the node that it hangs on.
#[derive(Debug, Clone, Copy)]
pub struct TreeFlow {
    /// P₀, Pa above the level.
    pub end: f64,
    /// The largest ρ over the square of P - P₀.
    pub factor: f64,
    /// Σ ρ over the largest.
    pub whole: f64,
    /// Where P stands.
    pub slot: u32,
    /// The row of the vessel of the largest ρ.
    pub row: u32,
}

/// How pressures are found.
#[derive(Debug)]
pub enum Solve {
    Lanes(Box<StarMesh>),
    Gradients(Box<ConjugateGradients>),
    Cholesky(Box<Cholesky>),
}

impl Solve {
    fn slot(&self, node: usize) -> u32 {
        (match self {
            Self::Lanes(program) => program.slot(node),
            Self::Gradients(program) => program.slot(node),
            Self::Cholesky(_) => node,
        }) as u32
    }
}

impl Reduced {
    /// Reduces a circuit whose `certain` vessels are open in every sample, and prepares its samples.
    ///
    /// # Errors
    ///
    /// A vessel whose resilience no double can hold; a mesh beyond what indices can count.
    pub fn new(network: &Network, circuit: &Circuit, certain: &[bool], params: &SamplingOptions) -> Result<Self> {
        let Reduction { circuit: core, links, trees } = Reduction::of(circuit, certain);
        // ρ of a vessel over the square of its flow.
        let of_square_flow = |row: usize| {
            let vessel = network.vessel(row);
            let factor = match vessel.resistance {
                Some(resistance) => resilience(resistance, 1.0, vessel.volume()),
                None => resilience_per_square_flow(params.viscosity, vessel.radius),
            };
            if factor.is_normal() { Ok(factor) } else { Err(beyond_doubles(network, row, "resilience")) }
        };
        let factors: Vec<Vec<f64>> =
            links.iter().map(|link| link.iter().map(|row| of_square_flow(*row)).collect()).collect::<Result<_>>()?;
        // Of equals the last is the weakest: the forest prefers the first.
        let weakest = |link: usize| (0..links[link].len()).rev().min_by(|a, b| factors[link][*a].total_cmp(&factors[link][*b]));
        let weakest: Vec<usize> = (0..links.len()).map(|link| weakest(link).unwrap_or_default()).collect();
        // Links in the order of their weakest vessels, so that theirs is the order among equals.
        let mut order: Vec<usize> = (0..links.len()).collect();
        order.sort_unstable_by_key(|link| links[*link][weakest[*link]]);
        let core = Circuit {
            ends: order.iter().map(|link| core.ends[*link]).collect(),
            conductance: order.iter().map(|link| core.conductance[*link]).collect(),
            ..core
        };

        let mut shares = Vec::new();
        let mut flows = Vec::with_capacity(links.len());
        for (at, link) in order.iter().enumerate() {
            let (rows, factors, weakest) = (&links[*link], &factors[*link], weakest[*link]);
            let least = factors[weakest];
            let mut others = (0..rows.len()).filter(|member| *member != weakest);
            let first = others.next();
            for other in others {
                shares.extend(first.map(|first| (rows[other] as u32, rows[first] as u32, factors[other] / factors[first])));
            }
            flows.push(LinkFlow {
                slots: [0; 2],
                conductance: core.conductance[at],
                factor: least,
                whole: factors.iter().map(|factor| factor / least).sum(),
                row: rows[weakest] as u32,
                carried: first.map(|first| (rows[first] as u32, factors[first] / least)),
                may_close: !certain[rows[0]],
            });
        }
        let mut hanging = Vec::with_capacity(trees.len());
        for tree in &trees {
            let mut factors = Vec::with_capacity(tree.vessels.len());
            for (row, flow) in &tree.vessels {
                factors.push(of_square_flow(*row)? * flow * flow);
            }
            let most = (0..factors.len()).max_by(|a, b| factors[*a].total_cmp(&factors[*b])).unwrap_or_default();
            let row = tree.vessels[most].0 as u32;
            let others = (0..factors.len()).filter(|at| *at != most);
            shares.extend(others.map(|at| (tree.vessels[at].0 as u32, row, factors[at] / factors[most])));
            let whole = factors.iter().map(|factor| factor / factors[most]).sum();
            hanging.push(TreeFlow { slot: tree.node as u32, end: tree.end, factor: factors[most], whole, row });
        }

        let solve = compile(&core, params.solver)?;
        let in_forest: Vec<Option<[usize; 2]>> = core.ends.iter().map(|ends| Some(*ends)).collect();
        let bottleneck = match solve {
            Solve::Lanes(_) => Bottleneck::compile(core.node_count(), &in_forest, sampler::forest_limit(links.len())),
            Solve::Gradients(_) | Solve::Cholesky(_) => None,
        };
        // One by one pressures stand by node.
        let slot = |node: usize| if bottleneck.is_some() { solve.slot(node) } else { node as u32 };
        for (flow, ends) in flows.iter_mut().zip(&core.ends) {
            flow.slots = ends.map(slot);
        }
        for tree in &mut hanging {
            tree.slot = slot(tree.slot as usize);
        }
        let ties = Ties::new(&core, &flows.iter().map(|flow| flow.factor).collect::<Vec<_>>());
        Ok(Self {
            core: Core { bottleneck, ties, links: flows, trees: hanging, solve, circuit: core },
            shares,
            weight: params.weight,
            instructions: InstructionSet::detect(),
        })
    }

    /// How the samples are computed.
    pub fn method(&self) -> Method {
        let (solver, size) = match &self.core.solve {
            Solve::Lanes(program) => ("lanes", program.updates()),
            Solve::Gradients(program) => ("gradients", program.joins()),
            Solve::Cholesky(factor) => ("cholesky", factor.factor_entries()),
        };
        Method {
            solver,
            solver_size: size,
            forest: if self.core.bottleneck.is_some() { "bottleneck" } else { "kruskal" },
            forest_joins: self.core.bottleneck.as_ref().map(Bottleneck::joins),
            instructions: self.instructions.name(),
        }
    }

    /// Memory for one worker.
    pub fn workspace(&self) -> Workspace {
        match &self.core.bottleneck {
            Some(_) => Workspace::Lanes(Box::new(reduced_graph_lanes::Memory::new(&self.core))),
            None => Workspace::OneByOne(Box::new(reduced_graph_single::Memory::new(&self.core))),
        }
    }

    /// Replaces `sums` by those of a block.
    ///
    /// # Errors
    ///
    /// Pressures that do not meet Kirchhoff's law.
    pub fn block(&self, block: Block<'_>, work: &mut Workspace, sums: &mut Sums) -> Result<()> {
        let Block { masks, probability, samples } = block;
        let (core, weight) = (&self.core, self.weight);
        let present = &open_vessels(Scalar::new(), masks);
        // Links are in the order of their rows, so that none is overwritten before it is read.
        for (at, link) in core.links.iter().enumerate() {
            masks[at] = if link.may_close { masks[link.row as usize] } else { u64::MAX };
        }
        let masks = &masks[..core.links.len()];
        let stranded = &stranded(&core.circuit, masks, samples);
        sums.clear();
        let job = ReducedBlock { core, samples, probability, present, masks, stranded, weight };
        let residual = match work {
            Workspace::Lanes(memory) => self.instructions.run(InLanes { job, memory, sums }),
            Workspace::OneByOne(memory) => self.instructions.run(OneByOne { job, memory, sums }),
        }?;
        sums.residual = residual.relative;
        if residual.backward > MOST_BACKWARD {
            return Err(Error::Breakdown);
        }
        for (row, of, share) in &self.shares {
            let (row, of) = (*row as usize, *of as usize);
            let share = if weight == Weight::Resilience { *share } else { 1.0 };
            sums.likelihood[row] = share * sums.likelihood[of];
            sums.square[row] = share * share * sums.square[of];
            sums.count[row] = sums.count[of];
        }
        Ok(())
    }
}

/// Compiles a core for the solver asked for, or for the one that is predicted to be the fastest.
fn compile(core: &Circuit, solver: Solver) -> Result<Solve> {
    match solver {
        Solver::Lanes => {
            return StarMesh::compile(core, usize::MAX).map(|program| Solve::Lanes(Box::new(program))).ok_or(Error::Breakdown);
        }
        Solver::Cholesky => return Cholesky::compile(core).map(|f| Solve::Cholesky(Box::new(f))).ok_or(Error::Breakdown),
        Solver::Gradients | Solver::Auto => {}
    }
    let gradients = ConjugateGradients::compile(core).ok_or(Error::Breakdown)?;
    let lanes = match solver {
        Solver::Auto if gradients.core() <= sampler::SMALL_CORE => StarMesh::compile(core, sampler::lanes_limit(&gradients)),
        _ => None,
    };
    Ok(match lanes {
        Some(program) => Solve::Lanes(Box::new(program)),
        None => Solve::Gradients(Box::new(gradients)),
    })
}
