//! Blocks of samples of a graph as it is, vessel by vessel, by star-mesh elimination in lanes.

use super::forest_lanes::{Bottleneck, Offer};
use super::likelihood::Sums;
use super::options::{SamplingOptions, Weight};
use super::sampler::{Block, Method};
use super::whole_graph_lanes::{Flow, Group};
use super::{sampler, whole_graph_lanes};
use crate::error::Result;
use crate::flow::circuit::beyond_doubles;
use crate::flow::floating::stranded;
use crate::flow::peeling::{Peeled, peel};
use crate::flow::resilience::{resilience_per_square_drop, resilience_per_square_flow};
use crate::flow::{Circuit, StarMesh};
use crate::network::Network;
use crate::support::simd::InstructionSet;

/// Everything about a graph that all its samples share.
#[derive(Debug)]
pub struct Whole {
    /// Dead ends and certain chains are taken out of it.
    pub circuit: Circuit,
    pub solver: StarMesh,
    /// The forest program; Kruskal's algorithm without one.
    pub bottleneck: Option<Bottleneck>,
    /// Where the keys of the vessels go when there is no forest program.
    places: Vec<Offer>,
    /// Per vessel how its resilience follows from pressures.
    pub flows: Vec<Flow>,
    /// Per vessel its nodes.
    pub ends: Vec<[usize; 2]>,
    /// What a vessel of a forest contributes.
    pub weight: Weight,
    instructions: InstructionSet,
    lanes: usize,
}

/// The variable that forces 8, 16 or 32 samples side by side.
pub const FORCE_LANES: &str = "WILLIS_LANES";

impl Whole {
    /// Prepares the samples of a network; `None` when a sample would take more than `limit` joins.
    ///
    /// # Errors
    ///
    /// A vessel whose resilience no double can hold.
    pub fn new(
        network: &Network,
        circuit: &Circuit,
        certain: &[bool],
        params: &SamplingOptions,
        limit: usize,
    ) -> Result<Option<Self>> {
        let ends = circuit.ends.clone();
        let Peeled { circuit, chain } = peel(circuit, certain);
        let Some(solver) = StarMesh::compile(&circuit, limit) else { return Ok(None) };
        let slot = |node: usize| solver.slot(node) as u32;
        let mut flows = Vec::with_capacity(chain.len());
        for (row, ((_, vessel), chain)) in network.vessels().zip(&chain).enumerate() {
            flows.push(match chain {
                None => Flow { slots: [slot(ends[row][0]); 2], factor: 0.0 },
                Some(chain) => {
                    let factor = match vessel.resistance {
                        _ if chain.vessels == 1 => resilience_per_square_drop(chain.conductance, vessel.volume()),
                        Some(resistance) => {
                            let own = chain.conductance * resistance;
                            resilience_per_square_drop(chain.conductance * own, vessel.volume())
                        }
                        None => {
                            let squared = chain.conductance * chain.conductance;
                            squared * resilience_per_square_flow(params.viscosity, vessel.radius)
                        }
                    };
                    if !factor.is_normal() {
                        return Err(beyond_doubles(network, row, "resilience"));
                    }
                    Flow { slots: chain.ends.map(slot), factor }
                }
            });
        }
        let in_forest: Vec<Option<[usize; 2]>> = ends.iter().zip(&chain).map(|(e, chain)| chain.map(|_| *e)).collect();
        let bottleneck = Bottleneck::compile(network.node_count(), &in_forest, sampler::forest_limit(network.vessel_count()));
        let instructions = InstructionSet::detect();
        let rays = solver.rays() + bottleneck.as_ref().map_or(0, Bottleneck::rays);
        Ok(Some(Self {
            places: if bottleneck.is_some() { Vec::new() } else { Offer::one_each(network.vessel_count()) },
            bottleneck,
            weight: params.weight,
            lanes: whole_graph_lanes::lanes(instructions, rays, std::env::var(FORCE_LANES).ok().as_deref()),
            circuit,
            solver,
            flows,
            ends,
            instructions,
        }))
    }

    /// How the samples are computed.
    pub fn method(&self) -> Method {
        Method {
            solver: "lanes",
            solver_size: self.solver.updates(),
            forest: if self.bottleneck.is_some() { "bottleneck" } else { "kruskal" },
            forest_joins: self.bottleneck.as_ref().map(Bottleneck::joins),
            instructions: self.instructions.name(),
        }
    }

    /// Memory for one worker.
    pub fn workspace(&self) -> Group {
        let rays = self.bottleneck.as_ref().map_or(self.flows.len(), Bottleneck::rays);
        match self.lanes {
            32 => Group::ThirtyTwo(whole_graph_lanes::Memory::new(self.solver.workspace(), self.flows.len(), rays)),
            16 => Group::Sixteen(whole_graph_lanes::Memory::new(self.solver.workspace(), self.flows.len(), rays)),
            _ => Group::Eight(whole_graph_lanes::Memory::new(self.solver.workspace(), self.flows.len(), rays)),
        }
    }

    /// Replaces `sums` by those of a block.
    pub fn block(&self, block: Block<'_>, work: &mut Group, sums: &mut Sums) {
        let Block { masks, probability, samples } = block;
        let stranded = stranded(&self.circuit, masks, samples);
        let job = whole_graph_lanes::BlockOfLanes { whole: self, masks, stranded: &stranded, samples, probability };
        match work {
            Group::Eight(work) => self.instructions.run(whole_graph_lanes::InLanes { job, work, sums }),
            Group::Sixteen(work) => self.instructions.run(whole_graph_lanes::InLanes { job, work, sums }),
            Group::ThirtyTwo(work) => self.instructions.run(whole_graph_lanes::InLanes { job, work, sums }),
        }
    }

    /// Where the keys of each vessel go.
    pub fn offers(&self) -> &[Offer] {
        self.bottleneck.as_ref().map_or(&self.places, Bottleneck::offers)
    }
}
