//! The samples of one block of a reduced graph, a group side by side in SIMD lanes: flow, resilience, forest, sums.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::batch_forest::{ForestProgram, IN_FOREST, InForest};
use super::block_sums::{PerSample, expectation, pairwise, perfused};
use super::choose_solver::REDUCED_GRAPH_LANES as B;
use super::forest::{Forest, key, keys_or_zero};
use super::likelihood::Sums;
use super::options::Weight;
use super::reduced_graph::{ChainFlow, ReducedGraph};
use super::ties;
use crate::flow::batch::solver::Workspace;
use crate::flow::residual::{Check, Residual};
use crate::flow::resilience::{diffused_resilience, rounding_drops};
use crate::support::random::BLOCK;
use crate::support::simd::{Kernel, Lanes, Simd, map, masked, plus, plus_product, splat, zip};

/// The memory of one worker.
pub struct Memory {
    flow: Workspace<B>,
    /// ρ of the weakest vessel of every chain.
    resilience: Vec<Lanes<B>>,
    in_forest: Vec<InForest<B>>,
    kruskal: Forest,
    ties: ties::Workspace,
    check: Check,
}

impl Memory {
    /// Memory for a reduced graph.
    pub fn new(graph: &ReducedGraph) -> Self {
        let chains = graph.chains.len();
        Self {
            // The keys of the forest program come to lie where the conductances were.
            flow: graph.solver.workspace(graph.forest.as_ref().map_or(0, ForestProgram::rays)),
            resilience: vec![Lanes::ZERO; chains],
            in_forest: vec![[0; B]; chains + 1],
            kruskal: Forest::default(),
            ties: ties::Workspace::default(),
            check: Check::default(),
        }
    }
}

/// A block of samples; the output says how well the first is solved.
pub struct BlockKernel<'a> {
    pub graph: &'a ReducedGraph,
    pub samples: usize,
    /// What each sample counts, for an enumeration; one without.
    pub probability: Option<&'a [f64; BLOCK as usize]>,
    /// |Ẽ| of each.
    pub present: &'a PerSample,
    /// Per row of the core the samples in which it is open.
    pub masks: &'a [u64],
    /// Nodes of the core whose injected flow has nowhere to go, with the samples in which that is so.
    pub stranded: &'a [(usize, u64)],
    pub memory: &'a mut Memory,
    /// Receives the sums of the vessels that stand for others, and what is no vessel's own.
    pub sums: &'a mut Sums,
}

impl Kernel for BlockKernel<'_> {
    type Output = Residual;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Residual {
        let Self { graph, samples, probability, present, masks, stranded, memory, sums } = self;
        let Memory { flow, resilience, in_forest, kruskal, ties, check } = memory;
        let (mut global, mut residual) = (PerSample::ZERO, Residual::default());
        for first in (0..samples).step_by(B) {
            graph.solver.solve(simd, masks, first, stranded, flow);
            let (pressure, key) = flow.pressure_and_spare();
            let group = Group { graph, pressure, level: graph.core.level, masks, first };
            if first == 0 {
                let pressure = |node| pressure[graph.solver.slot(node)][0];
                residual = check.residual(&graph.core, graph.core.if_open(masks), stranded, pressure);
            }
            group.resiliences(simd, resilience);
            graph.ties.equalise::<B, _>(|chain| graph.chains[chain].factor, resilience, ties);
            let mut total = Lanes::ZERO;
            for (chain, rho) in graph.chains.iter().zip(&*resilience) {
                total = plus_product(simd, &total, &splat(simd, chain.total_share), rho);
            }
            // The order of a sum is part of what a seed gives: without a forest program the trees are summed by themselves.
            let of_chains = if graph.forest.is_some() { Lanes::ZERO } else { std::mem::replace(&mut total, Lanes::ZERO) };
            group.each_tree(simd, |tree, rho, _| {
                total = plus_product(simd, &total, &splat(simd, graph.trees[tree].total_share), rho);
            });
            total = plus(simd, &of_chains, &total);
            let here = (samples - first).min(B);
            in_forest.fill([0; B]);
            match &graph.forest {
                Some(program) => {
                    program.clear(key);
                    for (row, (key_slot, rho)) in program.key_slots().iter().zip(&*resilience).enumerate() {
                        key_slot.put(simd, &keys_or_zero(simd, rho, row), key);
                    }
                    program.grow(simd, key, in_forest);
                }
                None => group.kruskal(kruskal, here, resilience, in_forest),
            }
            let mut counted = Lanes::ZERO;
            for lane in 0..here {
                let open = present[first + lane];
                total[lane] = if open > 0.0 { total[lane] / open } else { 0.0 };
                global[first + lane] = total[lane];
                counted[lane] = probability.map_or(1.0, |p| p[first + lane]);
            }
            group.add_up(simd, &total, &counted, resilience, in_forest, sums);
        }
        sums.samples = samples as u64;
        sums.network_resilience = expectation(&global, probability);
        sums.perfused = expectation(&perfused(&global), probability);
        residual
    }
}

/// A group of samples at their pressures.
struct Group<'a> {
    graph: &'a ReducedGraph,
    pressure: &'a [Lanes<B>],
    level: f64,
    masks: &'a [u64],
    first: usize,
}

impl Group<'_> {
    /// ρ of every chain's weakest vessel.
    #[inline(always)]
    fn resiliences<S: Simd>(&self, simd: S, resilience: &mut [Lanes<B>]) {
        for ((chain, mask), resilience) in self.graph.chains.iter().zip(self.masks).zip(resilience) {
            let ends = chain.slots.map(|slot| &self.pressure[slot as usize]);
            *resilience = masked(simd, &self.resilience(simd, ends, chain.conductance, chain.factor), *mask, self.first);
        }
    }

    /// Calls `each` with every tree, the largest ρ in it, and one where there is flow.
    #[inline(always)]
    fn each_tree<S: Simd>(&self, simd: S, mut each: impl FnMut(usize, &Lanes<B>, &Lanes<B>)) {
        let [zero, one] = [0.0, 1.0].map(|x| simd.splat_f64s(x));
        for (row, tree) in self.graph.trees.iter().enumerate() {
            let ends = [&self.pressure[tree.slot as usize], &splat(simd, tree.end)];
            let rho = self.resilience(simd, ends, 1.0, tree.factor);
            let flows = map(simd, &rho, |rho| simd.select_f64s(simd.greater_than_f64s(rho, zero), one, zero));
            each(row, &rho, &flows);
        }
    }

    /// ρ from the pressures at two ends, what is conducted between them, and ρ over the square of the flow.
    #[inline(always)]
    fn resilience<S: Simd>(&self, simd: S, [a, b]: [&Lanes<B>; 2], conductance: f64, factor: f64) -> Lanes<B> {
        let (at_a, at_b) = (rounding_drops(simd, a, self.level), rounding_drops(simd, b, self.level));
        diffused_resilience(simd, [a, b], [&at_a, &at_b], Some(conductance), factor)
    }

    /// The forests of the group's samples, one after another.
    fn kruskal(&self, forest: &mut Forest, samples: usize, resilience: &[Lanes<B>], in_forest: &mut [InForest<B>]) {
        let chains = resilience.len();
        for lane in 0..samples {
            forest.clear();
            for (chain, rho) in resilience.iter().enumerate().filter(|(_, rho)| rho[lane] > 0.0) {
                forest.add(key(rho[lane], chain));
            }
            let core = &self.graph.core;
            forest.grow(core.node_count(), &core.ends, |chain| in_forest[chains - chain][lane] = IN_FOREST);
        }
    }

    /// Adds the group to the sums, given the ρ_G of each sample and what it counts.
    #[inline(always)]
    fn add_up<S: Simd>(
        &self,
        simd: S,
        global: &Lanes<B>,
        counted: &Lanes<B>,
        resilience: &[Lanes<B>],
        in_forest: &[InForest<B>],
        sums: &mut Sums,
    ) {
        let ReducedGraph { chains, trees, forest, weight, .. } = self.graph;
        // Pairwise with a forest program, sample after sample without one.
        let pairs = forest.is_some();
        let add = |sum: &mut f64, lanes: &Lanes<B>| {
            if pairs { *sum += pairwise(lanes) } else { lanes.iter().for_each(|x| *sum += x) }
        };
        let mut add = |row: u32, rho: &Lanes<B>, one: &Lanes<B>| {
            let value = match weight {
                Weight::Resilience => *rho,
                Weight::Count => splat(simd, 1.0),
                Weight::Global => *global,
            };
            let weighted = zip(simd, &value, one, |value, one| simd.mul_f64s(value, one));
            let square = zip(simd, &weighted, &value, |a, b| simd.mul_f64s(a, b));
            let row = row as usize;
            add(&mut sums.likelihood[row], &weighted);
            add(&mut sums.square[row], &square);
            add(&mut sums.count[row], one);
        };
        let zero = simd.splat_f64s(0.0);
        for (at, (chain, rho)) in chains.iter().zip(resilience).enumerate() {
            let mut one = *counted;
            for (one, in_forest) in one.iter_mut().zip(&in_forest[chains.len() - at]) {
                *one = if *in_forest == IN_FOREST { *one } else { 0.0 };
            }
            let ChainFlow { row, others, .. } = chain;
            add(*row, rho, &one);
            if let Some((row, share)) = *others {
                let share = simd.splat_f64s(share);
                let flows = zip(simd, rho, counted, |rho, one| simd.select_f64s(simd.greater_than_f64s(rho, zero), one, zero));
                add(row, &map(simd, rho, |rho| simd.mul_f64s(share, rho)), &flows);
            }
        }
        self.each_tree(simd, |tree, rho, flows| {
            let one = zip(simd, flows, counted, |flows, one| simd.mul_f64s(flows, one));
            add(trees[tree].row, rho, &one);
        });
    }
}

const _: () = assert!((BLOCK as usize).is_multiple_of(B), "a block is made of whole groups");
