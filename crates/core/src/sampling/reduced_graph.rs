//! A large graph, reduced to what samples can change.
//!
//! The flows of all vessels of one chain are equal, and those of one tree have fixed ratios. So have the sums of their contributions: they
//! are kept once, for one vessel that stands for all of them, and each other vessel has a fixed share of them. A forest can leave out only
//! the vessel of least ρ of a chain.

use std::ops::Range;

use super::batch_forest::ForestProgram;
use super::choose_solver;
use super::choose_solver::Method;
use super::options::{SamplingOptions, Weight};
use super::ties::{Ties, same};
use crate::error::Result;
use crate::flow::batch::reduction::Reduction;
use crate::flow::circuit::beyond_doubles;
use crate::flow::resilience::{resilience, resilience_per_square_flow};
use crate::flow::{BatchSolver, Circuit};
use crate::network::Network;
use crate::support::simd::InstructionSet;

/// A reduced graph with all that its samples share.
#[derive(Debug)]
pub struct ReducedGraph {
    /// What is left of the graph; its rows are the chains.
    pub core: Circuit,
    pub chains: Vec<ChainFlow>,
    /// The rows of vessels that tie for the weakest of their chain, chain by chain.
    pub equals: Vec<u32>,
    pub trees: Vec<TreeFlow>,
    pub solver: BatchSolver,
    /// The forest program; Kruskal's algorithm without one.
    pub forest: Option<ForestProgram>,
    pub ties: Ties,
    pub weight: Weight,
    /// How many vessels there are.
    pub vessels: usize,
    /// The terminals of the core, by row of the circuit.
    pub terminals: Vec<usize>,
    /// Vessels for which another stands, with that one and their share of its sums.
    pub shares: Vec<(u32, u32, f64)>,
    pub instructions: InstructionSet,
}

/// How the resilience of a chain follows from pressures.
#[derive(Debug, Clone, Copy)]
pub struct ChainFlow {
    /// m³/(Pa s).
    pub conductance: f64,
    /// ρ of its weakest vessel over the square of its flow.
    pub factor: f64,
    /// Σ ρ of its vessels over ρ of the weakest.
    pub total_share: f64,
    /// Where the pressures at its ends stand.
    pub slots: [u32; 2],
    /// The row of its weakest vessel, the last of several.
    pub row: u32,
    /// Where the rows of its weakest vessels are among `equals`, if there are several: a coin decides which is left out of a forest.
    pub equals: [u32; 2],
    /// The row that stands for its other vessels, which are in every forest as long as there is flow, and its ρ over that of the weakest.
    pub others: Option<(u32, f64)>,
    /// Whether samples may close it.
    pub may_close: bool,
}

/// How the resilience in a tree follows from the pressure P at its root in the core.
#[derive(Debug, Clone, Copy)]
pub struct TreeFlow {
    /// P₀, Pa above the level.
    pub end: f64,
    /// The largest ρ over the square of P - P₀.
    pub factor: f64,
    /// Σ ρ over the largest.
    pub total_share: f64,
    /// Where P stands.
    pub slot: u32,
    /// The row of the vessel of the largest ρ.
    pub row: u32,
}

impl ChainFlow {
    /// Where its weakest vessels are among [`ReducedGraph::equals`]: nowhere for a single one.
    pub fn equals(&self) -> Range<usize> {
        self.equals[0] as usize..self.equals[1] as usize
    }
}

impl ReducedGraph {
    /// Reduces a circuit whose `certain` vessels are open in every sample, and prepares its samples.
    ///
    /// # Errors
    ///
    /// A vessel whose resilience no double can hold; a mesh beyond what indices can count.
    pub fn new(network: &Network, circuit: &Circuit, certain: &[bool], params: &SamplingOptions) -> Result<Self> {
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
            let is_weakest = |member: usize| same(factors[member], least);
            let first_equal = equals.len();
            equals.extend((0..rows.len()).filter(|member| is_weakest(*member)).map(|member| rows[member] as u32));
            if equals.len() == first_equal + 1 {
                equals.pop();
            }
            let mut others = (0..rows.len()).filter(|member| !is_weakest(*member));
            let first = others.next();
            for other in others {
                shares.extend(first.map(|first| (rows[other] as u32, rows[first] as u32, factors[other] / factors[first])));
            }
            flows.push(ChainFlow {
                slots: [0; 2],
                conductance: core.conductance[at],
                factor: least,
                total_share: factors.iter().map(|factor| factor / least).sum(),
                row: rows[weakest] as u32,
                equals: [first_equal as u32, equals.len() as u32],
                others: first.map(|first| (rows[first] as u32, factors[first] / least)),
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
            let total_share = factors.iter().map(|factor| factor / factors[most]).sum();
            hanging.push(TreeFlow { slot: tree.node as u32, end: tree.end, factor: factors[most], total_share, row });
        }

        let solver = choose_solver::reduced_graph_solver(&core, params.solver)?;
        let in_forest: Vec<Option<[usize; 2]>> = core.ends[..flows.len()].iter().map(|ends| Some(*ends)).collect();
        let forest = match solver.core() {
            None => choose_solver::forest_program(core.node_count(), &in_forest),
            Some(_) => None,
        };
        let slot = |node: usize| solver.slot(node) as u32;
        for (flow, ends) in flows.iter_mut().zip(&core.ends) {
            flow.slots = ends.map(slot);
        }
        for tree in &mut hanging {
            tree.slot = slot(tree.slot as usize);
        }
        Ok(Self {
            ties: Ties::new(&core, &flows.iter().map(|flow| flow.factor).collect::<Vec<_>>()),
            core,
            chains: flows,
            equals,
            trees: hanging,
            solver,
            forest,
            weight: params.weight,
            vessels: network.vessel_count(),
            terminals,
            shares,
            instructions: InstructionSet::detect(),
        })
    }

    /// How the samples are computed.
    pub fn method(&self) -> Method {
        Method::new(self.solver.name(), self.solver.joins(), self.forest.as_ref(), self.instructions.name())
    }
}
