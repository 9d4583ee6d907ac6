//! A graph made ready for its samples: a small one as it is, vessel by vessel, and a large one reduced to what samples can change.
//!
//! The flows of all vessels of one chain are equal, and those of one tree have fixed ratios. So have the sums of their contributions: they
//! are kept once, for one vessel that stands for all of them, and each other vessel has a fixed share of them. A forest can leave out only
//! the vessel of least ρ of a chain.

use super::sampled_graph::{RowFlow, SampledGraph, TreeFlow};
use super::ties::{Ties, same};
use super::{SamplingOptions, choose_solver};
use crate::flow::peeling::{Peeled, peel};
use crate::flow::{BatchSolver, Circuit, drops::Drops, resilience, resilience_per_square_drop, resilience_per_square_flow};
use crate::flow::{batch::reduction::Reduction, circuit::beyond_doubles};
use crate::{error::Result, error::ensure, network::Network, support::counted, support::simd::InstructionSet};

impl SampledGraph {
    /// Reduces a circuit whose `certain` vessels are open in every sample, and prepares its samples.
    ///
    /// # Errors
    ///
    /// A vessel whose resilience no double can hold; a mesh beyond what indices can count.
    pub fn reduced(network: &Network, circuit: &Circuit, certain: &[bool], params: &SamplingOptions) -> Result<Self> {
        let Reduction { circuit: core, mut chains, trees } = Reduction::of(circuit, certain);
        let terminals = chains.split_off(core.vessel_count()).concat();
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
            chains.iter().map(|chain| chain.iter().map(|row| of_square_flow(*row)).collect()).collect::<Result<_>>()?;
        let weakest = |chain: usize| {
            let least = factors[chain].iter().copied().fold(f64::INFINITY, f64::min);
            factors[chain].iter().rposition(|factor| same(*factor, least))
        };
        let weakest: Vec<usize> = (0..chains.len()).map(|chain| weakest(chain).unwrap_or_default()).collect();
        // Chains in the order of their weakest vessels, so that theirs is the order among those that even a coin leaves equal.
        let mut order: Vec<usize> = (0..chains.len()).collect();
        order.sort_unstable_by_key(|chain| chains[*chain][weakest[*chain]]);
        let core = Circuit {
            ends: order.iter().copied().chain(chains.len()..core.row_count()).map(|row| core.ends[row]).collect(),
            conductance: order.iter().copied().chain(chains.len()..core.row_count()).map(|row| core.conductance[row]).collect(),
            ..core
        };

        let (mut shares, mut equals) = (Vec::new(), Vec::new());
        let mut flows = Vec::with_capacity(chains.len());
        for (at, chain) in order.iter().enumerate() {
            let (rows, factors, weakest) = (&chains[*chain], &factors[*chain], weakest[*chain]);
            let least = factors[weakest];
            let (alike, others): (Vec<usize>, Vec<usize>) = (0..rows.len()).partition(|member| same(factors[*member], least));
            let first_equal = equals.len();
            if alike.len() > 1 {
                equals.extend(alike.iter().map(|member| rows[*member] as u32));
            }
            if let Some((first, rest)) = others.split_first() {
                let share = |other: &usize| (rows[*other] as u32, rows[*first] as u32, factors[*other] / factors[*first]);
                shares.extend(rest.iter().map(share));
            }
            flows.push(RowFlow {
                slots: [0; 2],
                conductance: Some(core.conductance[at]),
                factor: least,
                total_share: factors.iter().map(|factor| factor / least).sum(),
                vessel: rows[weakest] as u32,
                equals: [first_equal as u32, equals.len() as u32],
                others: others.first().map(|first| (rows[*first] as u32, factors[*first] / least)),
                may_close: !certain[rows[0]],
                stand_in: at as u32,
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
            let total_share = factors.iter().map(|factor| factor / factors[most]).sum();
            hanging.push(TreeFlow { slot: tree.node as u32, end: tree.end, factor: factors[most], total_share, vessel: row });
        }

        let solver = choose_solver::reduced_graph_solver(&core, params.solver)?;
        let ends = core.ends[..flows.len()].to_vec();
        let in_forest: Vec<Option<[usize; 2]>> = ends.iter().copied().map(Some).collect();
        let eliminates = solver.core().is_none();
        let forest = eliminates.then(|| choose_solver::forest_program(core.node_count(), &in_forest)).flatten();
        let slot = |node: usize| solver.slot(node) as u32;
        for (flow, ends) in flows.iter_mut().zip(&core.ends) {
            flow.slots = ends.map(slot);
        }
        for tree in &mut hanging {
            tree.slot = slot(tree.slot as usize);
        }
        Ok(Self {
            ties: Ties::new(&core, &flows.iter().map(|flow| flow.factor).collect::<Vec<_>>()),
            circuit: core,
            rows: flows,
            ends,
            equals,
            trees: hanging,
            solver,
            drops: None,
            is_reduced: true,
            forest,
            weight: params.weight,
            vessels: network.vessel_count(),
            terminals,
            shares,
            instructions: InstructionSet::detect(),
        })
    }

    /// Prepares the samples of a network as it is, but for dead ends and certain chains, which are taken out of its circuit; `None` when a
    /// sample would take too many joins, so that it is reduced first.
    ///
    /// # Errors
    ///
    /// A vessel whose resilience no double can hold.
    pub fn full(network: &Network, circuit: &Circuit, certain: &[bool], params: &SamplingOptions) -> Result<Option<Self>> {
        let most_joins = choose_solver::most_joins_in_full(network.vessel_count(), params.solver);
        let Some(most_joins) = most_joins else { return Ok(None) };
        let ends = circuit.ends[..circuit.vessel_count()].to_vec();
        let of_square_flow: Vec<f64> =
            network.vessels().zip(&circuit.conductance).map(|((_, v), c)| resilience(1.0 / c, 1.0, v.volume())).collect();
        let ties = Ties::new(circuit, &of_square_flow);
        let Peeled { circuit, stand_in } = peel(circuit, &circuit.certain_rows(certain));
        let Some(solver) = BatchSolver::star_mesh(&circuit, most_joins) else { return Ok(None) };
        let in_chain = counted(circuit.row_count(), stand_in.iter().flatten().copied());
        let mut rows = Vec::with_capacity(ends.len());
        for (row, ((_, vessel), first)) in network.vessels().zip(&stand_in).enumerate() {
            let stand_in = first.unwrap_or(row);
            let conductance = circuit.conductance[stand_in];
            let factor = match vessel.resistance {
                _ if first.is_none() => 0.0,
                _ if in_chain[stand_in] == 1 => resilience_per_square_drop(conductance, vessel.volume()),
                Some(resistance) => resilience_per_square_drop(conductance * (conductance * resistance), vessel.volume()),
                None => conductance * conductance * resilience_per_square_flow(params.viscosity, vessel.radius),
            };
            ensure(first.is_none() || factor.is_normal(), || beyond_doubles(network, row, "resilience"))?;
            rows.push(RowFlow {
                conductance: None,
                factor,
                total_share: 1.0,
                slots: circuit.ends[stand_in].map(|node| solver.slot(node) as u32),
                vessel: row as u32,
                equals: [0; 2],
                others: None,
                may_close: true,
                stand_in: stand_in as u32,
            });
        }
        let in_forest: Vec<Option<[usize; 2]>> = ends.iter().zip(&stand_in).map(|(ends, first)| first.map(|_| *ends)).collect();
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
            weight: params.weight,
            is_reduced: false,
            instructions: InstructionSet::detect(),
        }))
    }
}
