//! A small graph as it is, vessel by vessel.

use super::choose_solver;
use super::options::SamplingOptions;
use super::sampled_graph::{RowFlow, SampledGraph};
use super::ties::Ties;
use crate::error::Result;
use crate::flow::circuit::beyond_doubles;
use crate::flow::drops::Drops;
use crate::flow::peeling::{Peeled, peel};
use crate::flow::resilience::{resilience, resilience_per_square_drop, resilience_per_square_flow};
use crate::flow::{BatchSolver, Circuit};
use crate::network::Network;
use crate::support::simd::InstructionSet;

impl SampledGraph {
    /// Prepares the samples of a network as it is, but for dead ends and certain chains, which are taken out of its circuit; `None` when a
    /// sample would take more than `most_joins`.
    ///
    /// # Errors
    ///
    /// A vessel whose resilience no double can hold.
    pub fn full(
        network: &Network,
        circuit: &Circuit,
        certain: &[bool],
        options: &SamplingOptions,
        most_joins: usize,
    ) -> Result<Option<Self>> {
        let ends = circuit.ends[..circuit.vessel_count()].to_vec();
        let of_square_flow: Vec<f64> =
            network.vessels().zip(&circuit.conductance).map(|((_, v), c)| resilience(1.0 / c, 1.0, v.volume())).collect();
        let ties = Ties::new(circuit, &of_square_flow);
        let Peeled { circuit, chain } = peel(circuit, &circuit.certain_rows(certain));
        let Some(solver) = BatchSolver::star_mesh(&circuit, most_joins) else { return Ok(None) };
        let slots = |ends: [usize; 2]| ends.map(|node| solver.slot(node) as u32);
        let mut rows = Vec::with_capacity(ends.len());
        for (row, ((_, vessel), chain)) in network.vessels().zip(&chain).enumerate() {
            let factor = match (chain, vessel.resistance) {
                (None, _) => 0.0,
                (Some(chain), _) if chain.vessels == 1 => resilience_per_square_drop(chain.conductance, vessel.volume()),
                (Some(chain), Some(resistance)) => {
                    let own = chain.conductance * resistance;
                    resilience_per_square_drop(chain.conductance * own, vessel.volume())
                }
                (Some(chain), None) => {
                    let squared = chain.conductance * chain.conductance;
                    squared * resilience_per_square_flow(options.viscosity, vessel.radius)
                }
            };
            if chain.is_some() && !factor.is_normal() {
                return Err(beyond_doubles(network, row, "resilience"));
            }
            rows.push(RowFlow {
                conductance: None,
                factor,
                total_share: 1.0,
                slots: slots(chain.map_or([ends[row][0]; 2], |chain| chain.ends)),
                vessel: row as u32,
                equals: [0; 2],
                others: None,
                may_close: true,
                stand_in: chain.map_or(row, |chain| chain.first) as u32,
            });
        }
        let in_forest: Vec<Option<[usize; 2]>> = ends.iter().zip(&chain).map(|(e, chain)| chain.map(|_| *e)).collect();
        Ok(Some(Self {
            drops: Drops::may_hide(&circuit).then(|| Drops::compile(&circuit, most_joins)).flatten(),
            forest: choose_solver::forest_program(network.node_count(), &in_forest),
            terminals: (circuit.vessel_count()..circuit.row_count()).collect(),
            vessels: rows.len(),
            circuit,
            rows,
            ends,
            equals: Vec::new(),
            trees: Vec::new(),
            shares: Vec::new(),
            solver,
            ties,
            weight: options.weight,
            is_reduced: false,
            instructions: InstructionSet::detect(),
        }))
    }
}
