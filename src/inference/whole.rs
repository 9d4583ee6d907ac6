//! Blocks of samples of a graph as it is, vessel by vessel.

use super::bottleneck::{Bottleneck, Offer};
use super::cost;
use super::group::{self, Flow, Group};
use super::likelihood::Sums;
use super::sampler::{Block, Method};
use super::{Params, Solver, Weight};
use crate::error::{Error, Result};
use crate::hemodynamics::cholesky::Cholesky;
use crate::hemodynamics::floating::stranded;
use crate::hemodynamics::peel::{Peeled, peel};
use crate::hemodynamics::{Circuit, StarMesh};
use crate::network::Network;
use crate::resilience::{resilience_per_square_drop, resilience_per_square_flow};
use crate::simd::InstructionSet;

/// How flows are solved.
#[derive(Debug)]
enum Solve {
    Lanes(Box<StarMesh>),
    Cholesky(Box<Cholesky>),
}

/// Everything about a graph that all its samples share.
#[derive(Debug)]
pub struct Whole {
    circuit: Circuit,
    solve: Solve,
    bottleneck: Option<Bottleneck>,
    /// Where the keys of the vessels go when there is no forest program.
    places: Vec<Offer>,
    flows: Vec<Flow>,
    ends: Vec<[usize; 2]>,
    weight: Weight,
    instructions: InstructionSet,
    lanes: usize,
}

/// The variable that forces 8, 16 or 32 samples side by side.
pub const FORCE_LANES: &str = "WILLIS_LANES";

impl Whole {
    /// Prepares the samples of a network.
    ///
    /// # Errors
    ///
    /// A vessel whose conductance or resilience no double can hold; no memory for a factorisation.
    pub fn new(network: &Network, circuit: &Circuit, certain: &[bool], params: &Params) -> Result<Self> {
        let ends = circuit.ends.clone();
        let Peeled { circuit, chain } = peel(circuit, certain);
        let solve = compile(&circuit, params.solver)?;
        let slot = |node: usize| match &solve {
            Solve::Lanes(program) => program.slot(node) as u32,
            Solve::Cholesky(_) => node as u32,
        };
        let mut flows = Vec::with_capacity(chain.len());
        for (row, ((_, vessel), chain)) in network.vessels().zip(&chain).enumerate() {
            flows.push(match chain {
                None => Flow { slots: [slot(ends[row][0]); 2], factor: 0.0 },
                Some(chain) => {
                    let factor = match vessel.resistance {
                        _ if chain.vessels == 1 => resilience_per_square_drop(chain.conductance, vessel.radius, vessel.length),
                        Some(resistance) => {
                            let own = chain.conductance * resistance;
                            resilience_per_square_drop(chain.conductance * own, vessel.radius, vessel.length)
                        }
                        None => {
                            let squared = chain.conductance * chain.conductance;
                            squared * resilience_per_square_flow(params.viscosity, vessel.radius)
                        }
                    };
                    if !factor.is_normal() {
                        let size = format!("of length {} m and radius {} m", vessel.length, vessel.radius);
                        return Err(Error::parameter(
                            network.vessel_name(row),
                            size,
                            "expected a resilience that a double can hold",
                        ));
                    }
                    Flow { slots: chain.ends.map(slot), factor }
                }
            });
        }
        let in_forest: Vec<Option<[usize; 2]>> = ends.iter().zip(&chain).map(|(e, chain)| chain.map(|_| *e)).collect();
        let limit = cost::forest_limit(network.vessel_count());
        let lanes =
            if matches!(solve, Solve::Lanes(_)) { Bottleneck::compile(network.node_count(), &in_forest, limit) } else { None };
        let instructions = InstructionSet::detect();
        let of_solve = if let Solve::Lanes(program) = &solve { program.rays() } else { 0 };
        let rays = of_solve + lanes.as_ref().map_or(0, Bottleneck::rays);
        Ok(Self {
            places: if lanes.is_some() { Vec::new() } else { Offer::one_each(network.vessel_count()) },
            bottleneck: lanes,
            weight: params.weight,
            lanes: group::lanes(instructions, rays, std::env::var(FORCE_LANES).ok().as_deref()),
            circuit,
            solve,
            flows,
            ends,
            instructions,
        })
    }

    /// How the samples are computed.
    pub fn method(&self) -> Method {
        let (solver, size) = match &self.solve {
            Solve::Lanes(program) => ("lanes", program.updates()),
            Solve::Cholesky(factor) => ("cholesky", factor.factor_entries()),
        };
        Method {
            solver,
            solver_size: size,
            forest: if self.bottleneck.is_some() { "bottleneck" } else { "kruskal" },
            forest_joins: self.bottleneck.as_ref().map(Bottleneck::joins),
            instructions: self.instructions.name(),
            residual: None,
        }
    }

    /// Memory for one worker.
    pub fn workspace(&self) -> Group {
        let rays = self.bottleneck.as_ref().map_or(self.flows.len(), Bottleneck::rays);
        match (&self.solve, self.lanes) {
            (Solve::Lanes(program), 32) => Group::ThirtyTwo(group::Memory::new(program.workspace(), self.flows.len(), rays)),
            (Solve::Lanes(program), 16) => Group::Sixteen(group::Memory::new(program.workspace(), self.flows.len(), rays)),
            (Solve::Lanes(program), _) => Group::Eight(group::Memory::new(program.workspace(), self.flows.len(), rays)),
            (Solve::Cholesky(_), _) => Group::One(Box::default()),
        }
    }

    /// Replaces `sums` by those of a block.
    ///
    /// # Errors
    ///
    /// The Cholesky factorisation breaks down.
    pub fn block(&self, block: Block<'_>, work: &mut Group, sums: &mut Sums) -> Result<()> {
        let Block { masks, probability, samples } = block;
        let stranded = stranded(&self.circuit, masks, samples);
        let job = group::Job {
            masks,
            stranded: &stranded,
            probability,
            samples,
            flows: &self.flows,
            level: self.circuit.level,
            ends: &self.ends,
            nodes: self.circuit.node_count(),
            weight: self.weight,
            bottleneck: self.bottleneck.as_ref(),
            offers: self.bottleneck.as_ref().map_or(&self.places, Bottleneck::offers),
        };
        match (work, &self.solve) {
            (Group::Eight(work), Solve::Lanes(solver)) => self.instructions.run(group::InLanes { job, solver, work, sums }),
            (Group::Sixteen(work), Solve::Lanes(solver)) => self.instructions.run(group::InLanes { job, solver, work, sums }),
            (Group::ThirtyTwo(work), Solve::Lanes(solver)) => self.instructions.run(group::InLanes { job, solver, work, sums }),
            (Group::One(memory), Solve::Cholesky(factor)) => job.one_by_one(factor, memory, sums)?,
            _ => {}
        }
        Ok(())
    }
}

/// Compiles a circuit for the solver asked for, or for the one that the cost model prefers.
fn compile(circuit: &Circuit, solver: Solver) -> Result<Solve> {
    let lanes = match solver {
        Solver::Lanes => StarMesh::compile(circuit, usize::MAX),
        Solver::Auto => StarMesh::compile(circuit, cost::SURELY_SPARSE),
        Solver::Cholesky | Solver::Gradients => None,
    };
    let sparse = || Cholesky::compile(circuit).map(Box::new);
    match lanes {
        Some(program) if solver == Solver::Lanes || program.updates() <= cost::SURELY_LANES => {
            Ok(Solve::Lanes(Box::new(program)))
        }
        Some(program) => Ok(match sparse().filter(|f| cost::sparse(f, circuit.vessel_count()) < cost::lanes(&program)) {
            Some(factor) => Solve::Cholesky(factor),
            None => Solve::Lanes(Box::new(program)),
        }),
        None => sparse().map(Solve::Cholesky).ok_or(Error::Breakdown),
    }
}
