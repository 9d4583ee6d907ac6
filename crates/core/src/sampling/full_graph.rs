//! Blocks of samples of a graph as it is, vessel by vessel: a group of samples side by side goes through star-mesh elimination, resilience
//! and forest in SIMD lanes.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use std::ops::Range;

use super::batch_forest::{ForestProgram, IN_FOREST, InForest, KeySlot};
use super::block::{Block, BlockForests};
use super::choose_solver;
use super::choose_solver::{FULL_GRAPH_LANES as B, Method};
use super::coins::Coins;
use super::expected_forest::{ExpectedForest, ForestEdge};
use super::forest::Kruskal;
use super::likelihood::Sums;
use super::options::{SamplingOptions, Weight};
use super::per_sample::{PerSample, expectation, open_vessels, part, perfused};
use super::ties::{Ties, TiesWorkspace};
use crate::error::Result;
use crate::flow::batch::star_mesh::StarMeshWorkspace;
use crate::flow::circuit::beyond_doubles;
use crate::flow::drops::{Drops, DropsWorkspace, FEW_DIGITS};
use crate::flow::floating_components::stranded;
use crate::flow::peeling::{Peeled, peel};
use crate::flow::residual::Check;
use crate::flow::resilience::{
    DROP_CUT, MOST_RESILIENCE, diffused_resilience, resilience, resilience_per_square_drop, resilience_per_square_flow,
    rounding_drops,
};
use crate::flow::{Circuit, StarMesh};
use crate::network::Network;
use crate::support::random::BLOCK;
use crate::support::simd::{InstructionSet, Kernel, Lanes, Simd, masked, plus, splat, zip};

/// A graph with all that its samples share.
#[derive(Debug)]
pub struct FullGraph {
    /// Dead ends and certain chains are taken out of it.
    circuit: Circuit,
    solver: StarMesh,
    /// Where pressures may not show what flows in wide vessels.
    drops: Option<Drops>,
    ties: Ties,
    /// The forest program; Kruskal's algorithm without one.
    forest: Option<ForestProgram>,
    /// Where the keys of each vessel go: as the forest program has it, or each to a place of its own.
    key_slots: Vec<KeySlot>,
    vessels: Vec<VesselResilience>,
    /// Per vessel its nodes.
    ends: Vec<[usize; 2]>,
    weight: Weight,
    instructions: InstructionSet,
}

/// How a vessel's resilience follows from pressures.
#[derive(Debug, Clone, Copy)]
struct VesselResilience {
    /// Where the pressures at the two ends of its chain stand.
    slots: [u32; 2],
    /// The row that stands for the chain.
    stand_in: u32,
    /// ρ over the square of the drop between them, W/(m³ Pa²); zero for a vessel that never carries flow.
    factor: f64,
}

/// The memory of one worker.
#[derive(Debug)]
pub struct FullWorkspace {
    flow: StarMeshWorkspace<B>,
    nodes: Vec<NodePressure>,
    /// ρ of every vessel, one group after another.
    resilience: Vec<Lanes<B>>,
    /// Keys by the vessels' key slots.
    key: Vec<Lanes<B>>,
    /// Every vessel's place in the forests, one group after another.
    in_forest: Vec<InForest<B>>,
    kruskal: Kruskal,
    expected: ExpectedForest,
    diffused: Vec<ForestEdge>,
    check: Check,
    drops: DropsWorkspace,
    ties: TiesWorkspace,
}

/// The pressure at a slot above the circuit's level, and the drop that is only rounding beside it, Pa.
#[derive(Debug, Clone, Copy)]
struct NodePressure {
    pressure: Lanes<B>,
    rounding: Lanes<B>,
}

impl FullGraph {
    /// Prepares the samples of a network; `None` when a sample would take more than `most_joins`.
    ///
    /// # Errors
    ///
    /// A vessel whose resilience no double can hold.
    pub fn new(
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
        let Some(solver) = StarMesh::compile(&circuit, most_joins) else { return Ok(None) };
        let slot = |node: usize| solver.slot(node) as u32;
        let mut vessels = Vec::with_capacity(chain.len());
        for (row, ((_, vessel), chain)) in network.vessels().zip(&chain).enumerate() {
            vessels.push(match chain {
                None => VesselResilience { slots: [slot(ends[row][0]); 2], stand_in: row as u32, factor: 0.0 },
                Some(chain) => {
                    let factor = match vessel.resistance {
                        _ if chain.vessels == 1 => resilience_per_square_drop(chain.conductance, vessel.volume()),
                        Some(resistance) => {
                            let own = chain.conductance * resistance;
                            resilience_per_square_drop(chain.conductance * own, vessel.volume())
                        }
                        None => {
                            let squared = chain.conductance * chain.conductance;
                            squared * resilience_per_square_flow(options.viscosity, vessel.radius)
                        }
                    };
                    if !factor.is_normal() {
                        return Err(beyond_doubles(network, row, "resilience"));
                    }
                    VesselResilience { slots: chain.ends.map(slot), stand_in: chain.first as u32, factor }
                }
            });
        }
        let in_forest: Vec<Option<[usize; 2]>> = ends.iter().zip(&chain).map(|(e, chain)| chain.map(|_| *e)).collect();
        let forest = choose_solver::forest_program(network.node_count(), &in_forest);
        let one_each = || KeySlot::one_each(network.vessel_count());
        Ok(Some(Self {
            key_slots: forest.as_ref().map_or_else(one_each, |program| program.key_slots().to_vec()),
            forest,
            weight: options.weight,
            drops: Drops::may_hide(&circuit).then(|| Drops::compile(&circuit, most_joins)).flatten(),
            ties,
            circuit,
            solver,
            vessels,
            ends,
            instructions: InstructionSet::detect(),
        }))
    }

    /// How the samples are computed.
    pub fn method(&self) -> Method {
        Method::new("lanes", self.solver.updates(), self.forest.as_ref(), self.instructions.name())
    }

    /// Memory for one worker.
    pub fn workspace(&self) -> FullWorkspace {
        let (vessels, groups) = (self.vessels.len(), BLOCK as usize / B);
        let flow = self.solver.workspace();
        FullWorkspace {
            nodes: vec![NodePressure { pressure: Lanes::ZERO, rounding: Lanes::ZERO }; flow.pressure.len()],
            flow,
            resilience: vec![Lanes::ZERO; vessels * groups],
            key: vec![Lanes::ZERO; self.forest.as_ref().map_or(vessels, ForestProgram::rays)],
            in_forest: vec![[0; B]; (vessels + 1) * groups],
            kruskal: Kruskal::default(),
            expected: ExpectedForest::default(),
            diffused: Vec::new(),
            check: Check::default(),
            drops: DropsWorkspace::default(),
            ties: TiesWorkspace::default(),
        }
    }

    /// Replaces `sums` by those of a block.
    pub fn block(&self, block: &Block<'_>, work: &mut FullWorkspace, sums: &mut Sums) {
        let stranded = stranded(&self.circuit, block.masks, block.samples);
        self.instructions.run(FullGraphKernel { graph: self, block, stranded: &stranded, work, sums });
    }
}

/// A block whose samples are computed in groups of `B`.
struct FullGraphKernel<'a> {
    graph: &'a FullGraph,
    block: &'a Block<'a>,
    /// Nodes whose injected flow has nowhere to go, with the samples in which that is so.
    stranded: &'a [(usize, u64)],
    work: &'a mut FullWorkspace,
    sums: &'a mut Sums,
}

impl Kernel for FullGraphKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { graph, block, stranded, work, sums } = self;
        let Block { masks, probability, coins, coin, samples } = block;
        let FullGraph { circuit, solver, forest, .. } = graph;
        let vessels = graph.vessels.len();
        work.in_forest.fill([0; B]);
        let present = open_vessels(simd, &masks[..vessels]);
        let mut global = PerSample::ZERO;
        for (group, first) in (0..*samples).step_by(B).enumerate() {
            solver.solve(simd, masks, first, stranded, &mut work.flow);
            if first == 0 {
                let pressure = |node| work.flow.pressure[solver.slot(node)][0];
                sums.residual = work.check.residual(circuit, circuit.if_open(masks), stranded, pressure).relative;
            }
            if let Some(program) = forest {
                program.clear(&mut work.key);
            }
            let coin = Coin { coins, of_samples: &part(&***coin, first) };
            graph.resiliences(simd, masks, group, work);
            if let Some(drops) = &graph.drops {
                graph.refine(drops, masks, first..(first + B).min(*samples), work);
            }
            let rho = &mut work.resilience[group * vessels..][..vessels];
            graph.ties.equalise(rho, &mut work.ties);
            let total = graph.sum_and_keys(simd, group, coin, work);
            global[first..first + B].copy_from_slice(&*total);
            let in_forest = &mut work.in_forest[group * (vessels + 1)..][..=vessels];
            match forest {
                _ if probability.is_some() => {}
                Some(program) => program.grow(simd, coins, &mut work.key, in_forest),
                None => graph.kruskal(coins, &mut work.kruskal, &work.key, in_forest),
            }
        }
        // Nothing flows where no vessel is open.
        let global = zip(simd, &global, &present, |sum, n| simd.div_f64s(sum, simd.max_f64s(n, simd.splat_f64s(1.0))));
        sums.samples = *samples as u64;
        sums.network_resilience = expectation(&global, *probability);
        sums.perfused = expectation(&perfused(&global), *probability);
        if let Some(probability) = probability {
            graph.expect(probability, *samples, &global, work, sums);
            return;
        }
        let forests = BlockForests { in_forest: &work.in_forest, vessels };
        let resilience = |vessel: usize, first: usize| part(&*work.resilience[first / B * vessels + vessel], first % B);
        match graph.weight {
            Weight::Resilience => forests.add_up(simd, resilience, sums),
            Weight::Count => forests.add_up(simd, |_, _| splat(simd, 1.0), sums),
            Weight::Global => forests.add_up(simd, |_, first| part(&*global, first), sums),
        }
    }
}

/// What decides between equals in a group of samples.
#[derive(Clone, Copy)]
struct Coin<'a> {
    coins: &'a Coins,
    of_samples: &'a Lanes<B>,
}

impl FullGraph {
    /// ρ of every vessel in a group.
    #[inline(always)]
    fn resiliences<S: Simd>(&self, simd: S, masks: &[u64], group: usize, work: &mut FullWorkspace) {
        for (node, pressure) in work.nodes.iter_mut().zip(&work.flow.pressure) {
            node.pressure = *pressure;
            node.rounding = rounding_drops(simd, pressure, self.circuit.level);
        }
        let nodes = &work.nodes[..];
        let resilience = &mut work.resilience[group * self.vessels.len()..][..self.vessels.len()];
        for ((vessel, mask), resilience) in self.vessels.iter().zip(masks).zip(resilience) {
            let [a, b] = vessel.slots.map(|slot| &nodes[slot as usize]);
            let (ends, rounding) = ([&a.pressure, &b.pressure], [&a.rounding, &b.rounding]);
            let rho = diffused_resilience(simd, ends, rounding, None, vessel.factor);
            *resilience = masked(simd, &rho, *mask, group * B);
        }
    }

    /// Works out ρ from drops in those of the samples in which a vessel flows although pressures do not show it, or hardly.
    #[cold]
    fn refine(&self, drops: &Drops, masks: &[u64], samples: Range<usize>, work: &mut FullWorkspace) {
        let (vessels, rounding, group) = (self.vessels.len(), FEW_DIGITS / DROP_CUT, samples.start / B);
        let resilience = &mut work.resilience[group * vessels..][..vessels];
        for sample in samples {
            let open = |row: usize| masks[row] >> sample & 1 == 1;
            let lane = sample % B;
            let doubtful = |row: &usize| {
                let vessel = &self.vessels[*row];
                let [a, b] = vessel.slots.map(|slot| &work.nodes[slot as usize]);
                let few = rounding * a.rounding[lane].max(b.rounding[lane]);
                vessel.factor > 0.0 && open(*row) && (a.pressure[lane] - b.pressure[lane]).abs() <= few
            };
            if !(0..vessels).any(|row| doubtful(&row)) {
                continue;
            }
            drops.solve(open, &mut work.drops);
            let drop = |row: usize| drops.drop(self.vessels[row].stand_in as usize, &work.drops);
            if !(0..vessels).filter(doubtful).any(|row| drop(row).is_some()) {
                continue;
            }
            for (row, (vessel, resilience)) in self.vessels.iter().zip(&mut *resilience).enumerate() {
                let drop = if vessel.factor > 0.0 && open(row) { drop(row) } else { None };
                resilience[lane] = drop.map_or(0.0, |drop| (drop * drop * vessel.factor).min(MOST_RESILIENCE));
            }
        }
    }

    /// Puts the forest key of every vessel in a group; returns Σ ρ of each sample.
    #[inline(always)]
    fn sum_and_keys<S: Simd>(&self, simd: S, group: usize, coin: Coin<'_>, work: &mut FullWorkspace) -> Lanes<B> {
        let resilience = &work.resilience[group * self.vessels.len()..][..self.vessels.len()];
        let mut sum = Lanes::ZERO;
        for (row, (rho, key_slot)) in resilience.iter().zip(&self.key_slots).enumerate() {
            sum = plus(simd, &sum, rho);
            key_slot.put(simd, &coin.coins.keys_or_zero(simd, rho, row, coin.of_samples), &mut work.key);
        }
        sum
    }

    /// The forests of a group, one sample after another.
    fn kruskal(&self, coins: &Coins, forest: &mut Kruskal, keys: &[Lanes<B>], in_forest: &mut [InForest<B>]) {
        let vessels = self.vessels.len();
        for lane in 0..B {
            forest.clear();
            for keys in keys.iter().map(|k| k[lane]).filter(|k| *k > 0.0) {
                forest.add(keys.to_bits());
            }
            let take = |vessel: usize| in_forest[vessels - vessel][lane] = IN_FOREST;
            forest.grow(self.circuit.node_count(), &self.ends, |key| coins.vessel(key), take);
        }
    }

    /// Adds up the expected forests of the patterns of an enumeration.
    fn expect(
        &self,
        probability: &[f64; BLOCK as usize],
        samples: usize,
        global: &PerSample,
        work: &mut FullWorkspace,
        sums: &mut Sums,
    ) {
        let FullWorkspace { resilience, expected, diffused, .. } = work;
        let vessels = self.vessels.len();
        sums.likelihood.fill(0.0);
        sums.square.fill(0.0);
        sums.count.fill(0.0);
        for sample in 0..samples {
            let resilience = &resilience[sample / B * vessels..][..vessels];
            let rho = |row: usize| resilience[row][sample % B];
            let flows = (0..vessels).filter(|row| rho(*row) > 0.0);
            diffused.clear();
            diffused.extend(flows.map(|row| ForestEdge { resilience: rho(row), row, ends: self.ends[row], weakest: 1 }));
            expected.grow(self.circuit.node_count(), diffused, |row, share| {
                sums.add(row, self.weight.of(rho(row), global[sample]), probability[sample] * share);
            });
        }
    }
}
