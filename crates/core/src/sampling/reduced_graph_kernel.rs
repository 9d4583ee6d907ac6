//! The samples of one block of a reduced graph, a group side by side in SIMD lanes: flow, resilience, forest, sums.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::batch_forest::{ForestProgram, IN_FOREST, InForest};
use super::block::Block;
use super::choose_solver::REDUCED_GRAPH_LANES as B;
use super::coins::Coins;
use super::expected_forest::{ExpectedForest, ForestEdge};
use super::forest::Kruskal;
use super::likelihood::Sums;
use super::options::Weight;
use super::per_sample::{PerSample, expectation, open_vessels, pairwise, part, perfused};
use super::reduced_graph::{ChainFlow, ReducedGraph};
use super::ties::TiesWorkspace;
use crate::error::{Error, Result};
use crate::flow::batch::solver::BatchWorkspace;
use crate::flow::floating_components::stranded;
use crate::flow::pressures::MOST_BACKWARD;
use crate::flow::residual::{Check, Residual};
use crate::flow::resilience::{diffused_resilience, rounding_drops};
use crate::support::random::BLOCK;
use crate::support::simd::{Kernel, Lanes, Scalar, Simd, map, masked, plus, plus_product, product, splat, zip};

/// The memory of one worker.
pub struct ReducedWorkspace {
    flow: BatchWorkspace<B>,
    /// ρ of the weakest vessel of every chain.
    resilience: Vec<Lanes<B>>,
    /// The keys of every chain, for Kruskal's algorithm.
    key: Vec<Lanes<B>>,
    in_forest: Vec<InForest<B>>,
    /// Of several vessels that tie for the weakest of a chain, the one that a coin puts last.
    is_last: Vec<InForest<B>>,
    /// The probability of every chain to be in the forest whole, in an enumeration.
    share: Vec<Lanes<B>>,
    kruskal: Kruskal,
    expected: ExpectedForest,
    diffused: Vec<ForestEdge>,
    ties: TiesWorkspace,
    check: Check,
}

impl ReducedGraph {
    /// Memory for one worker.
    pub fn workspace(&self) -> ReducedWorkspace {
        let chains = self.chains.len();
        ReducedWorkspace {
            // The keys of the forest program come to lie where the conductances were.
            flow: self.solver.workspace(self.forest.as_ref().map_or(0, ForestProgram::rays)),
            resilience: vec![Lanes::ZERO; chains],
            key: vec![Lanes::ZERO; if self.forest.is_some() { 0 } else { chains }],
            in_forest: vec![[0; B]; chains + 1],
            is_last: vec![[0; B]; self.equals.len()],
            share: Vec::new(),
            kruskal: Kruskal::default(),
            expected: ExpectedForest::default(),
            diffused: Vec::new(),
            ties: TiesWorkspace::default(),
            check: Check::default(),
        }
    }

    /// Replaces `sums` by those of a block.
    ///
    /// # Errors
    ///
    /// Pressures that do not meet Kirchhoff's law.
    pub fn block(&self, block: Block<'_>, work: &mut ReducedWorkspace, sums: &mut Sums) -> Result<()> {
        let Block { masks, probability, coins, coin, samples } = block;
        let present = &open_vessels(Scalar::new(), &masks[..self.vessels]);
        // Chains are in the order of their rows, so that none is overwritten before it is read.
        for (at, chain) in self.chains.iter().enumerate() {
            masks[at] = if chain.may_close { masks[chain.row as usize] } else { u64::MAX };
        }
        for (at, row) in self.terminals.iter().enumerate() {
            masks[self.chains.len() + at] = masks[*row];
        }
        let masks = &mut masks[..self.core.row_count()];
        let stranded = &stranded(&self.core, masks, samples);
        let block = &Block { masks, probability, coins, coin, samples };
        sums.clear();
        let kernel = ReducedGraphKernel { graph: self, block, present, stranded, work, sums: &mut *sums };
        let residual = self.instructions.run(kernel);
        sums.residual = residual.relative;
        if residual.backward > MOST_BACKWARD {
            return Err(Error::Breakdown);
        }
        for (row, of, share) in &self.shares {
            let (row, of) = (*row as usize, *of as usize);
            let share = if self.weight == Weight::Resilience { *share } else { 1.0 };
            sums.likelihood[row] = share * sums.likelihood[of];
            sums.square[row] = share * share * sums.square[of];
            sums.count[row] = sums.count[of];
        }
        Ok(())
    }
}

/// A block of samples; the output says how well the first is solved.
struct ReducedGraphKernel<'a> {
    graph: &'a ReducedGraph,
    /// With a mask for each row of the core.
    block: &'a Block<'a>,
    /// |Ẽ| of each sample.
    present: &'a PerSample,
    /// Nodes of the core whose injected flow has nowhere to go, with the samples in which that is so.
    stranded: &'a [(usize, u64)],
    work: &'a mut ReducedWorkspace,
    /// Receives the sums of the vessels that stand for others, and what is no vessel's own.
    sums: &'a mut Sums,
}

impl Kernel for ReducedGraphKernel<'_> {
    type Output = Residual;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Residual {
        let Self { graph, block, present, stranded, work, sums } = self;
        let Block { masks, probability, coins, coin, samples } = block;
        let (samples, probability) = (*samples, *probability);
        let ReducedWorkspace { flow, resilience, key: keys, in_forest, is_last, share, kruskal, expected, diffused, ties, check } =
            work;
        let (mut global, mut residual) = (PerSample::ZERO, Residual::default());
        for first in (0..samples).step_by(B) {
            graph.solver.solve(simd, masks, first, stranded, flow);
            let (pressure, key) = flow.pressure_and_spare();
            let group = SampleGroup { graph, pressure, level: graph.core.level, masks, first };
            if first == 0 {
                let pressure = |node| pressure[graph.solver.slot(node)][0];
                residual = check.residual(&graph.core, graph.core.if_open(masks), stranded, pressure);
            }
            group.resiliences(simd, resilience);
            graph.ties.equalise(resilience, ties);
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
            let coin = part(&***coin, first);
            in_forest.fill([0; B]);
            match &graph.forest {
                _ if probability.is_some() => group.expect(expected, diffused, here, resilience, share),
                Some(program) => {
                    program.clear(key);
                    for (at, key_slot) in program.key_slots().iter().enumerate() {
                        key_slot.put(simd, &group.keys(simd, coins, &coin, at, resilience, is_last), key);
                    }
                    program.grow(simd, coins, key, in_forest);
                }
                None => {
                    for (at, key) in keys.iter_mut().enumerate() {
                        *key = group.keys(simd, coins, &coin, at, resilience, is_last);
                    }
                    group.kruskal(coins, kruskal, here, keys, in_forest);
                }
            }
            let mut counted = Lanes::ZERO;
            for lane in 0..here {
                let open = present[first + lane];
                total[lane] = if open > 0.0 { total[lane] / open } else { 0.0 };
                global[first + lane] = total[lane];
                counted[lane] = probability.map_or(1.0, |p| p[first + lane]);
            }
            let chosen = Chosen { in_forest, is_last, share: probability.map(|_| &**share) };
            group.add_up(simd, &total, &counted, resilience, chosen, sums);
        }
        sums.samples = samples as u64;
        sums.network_resilience = expectation(&global, probability);
        sums.perfused = expectation(&perfused(&global), probability);
        residual
    }
}

/// What the forests of a group have.
#[derive(Clone, Copy)]
struct Chosen<'a> {
    /// As a forest program has it: the last chain comes first.
    in_forest: &'a [InForest<B>],
    is_last: &'a [InForest<B>],
    share: Option<&'a [Lanes<B>]>,
}

impl Chosen<'_> {
    /// The probability of a chain to be in the forest whole: one or zero in a sample.
    #[inline(always)]
    fn whole(&self, number: usize, chain: usize) -> Lanes<B> {
        if let Some(share) = self.share {
            return share[chain];
        }
        let mut out = Lanes::ZERO;
        for (out, in_forest) in out.iter_mut().zip(&self.in_forest[number]) {
            *out = if *in_forest == IN_FOREST { 1.0 } else { 0.0 };
        }
        out
    }

    /// The probability of one of several that tie for the weakest of such a chain, where blood flows: the forest leaves out one of them at most.
    fn share_of(&self, whole: &Lanes<B>, equal: usize, equals: usize) -> Lanes<B> {
        let mut out = *whole;
        for (out, is_last) in out.iter_mut().zip(&self.is_last[equal]) {
            *out = match self.share {
                Some(_) => 1.0 - (1.0 - *out) / equals as f64,
                None if *is_last == IN_FOREST => *out,
                None => 1.0,
            };
        }
        out
    }
}

/// A group of samples at their pressures.
struct SampleGroup<'a> {
    graph: &'a ReducedGraph,
    pressure: &'a [Lanes<B>],
    level: f64,
    masks: &'a [u64],
    first: usize,
}

impl SampleGroup<'_> {
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

    /// The keys of a chain: those of its weakest vessel. Of several that tie, the one that the coin puts last is marked.
    #[inline(always)]
    fn keys<S: Simd>(
        &self,
        simd: S,
        coins: &Coins,
        coin: &Lanes<B>,
        at: usize,
        resilience: &[Lanes<B>],
        is_last: &mut [InForest<B>],
    ) -> Lanes<B> {
        let chain = &self.graph.chains[at];
        let mut figure = splat(simd, coins.of_vessel(chain.row as usize));
        let equals = chain.equals();
        let rows = &self.graph.equals[equals.clone()];
        if !rows.is_empty() {
            let is_last = &mut is_last[equals];
            is_last.fill([0; B]);
            for lane in 0..B {
                let toss = |row: u32| coins.toss(coins.of_vessel(row as usize), coin[lane]);
                // Where a coin leaves two equal the lower row comes first.
                let last = (0..rows.len()).rev().min_by_key(|i| toss(rows[*i])).unwrap_or_default();
                figure[lane] = coins.of_vessel(rows[last] as usize);
                is_last[last][lane] = IN_FOREST;
            }
        }
        coins.numbered_keys_or_zero(simd, &resilience[at], &figure, coin, (resilience.len() - at) as u64)
    }

    /// The forests of the group's samples, one after another.
    fn kruskal(&self, coins: &Coins, forest: &mut Kruskal, samples: usize, keys: &[Lanes<B>], in_forest: &mut [InForest<B>]) {
        let chains = keys.len();
        for lane in 0..samples {
            forest.clear();
            for key in keys.iter().map(|keys| keys[lane]).filter(|key| *key > 0.0) {
                forest.add(key.to_bits());
            }
            let (core, row) = (&self.graph.core, |key| chains - coins.number_of(key));
            forest.grow(core.node_count(), &core.ends, row, |chain| in_forest[chains - chain][lane] = IN_FOREST);
        }
    }

    /// The expected forests of the group's patterns.
    fn expect(
        &self,
        expected: &mut ExpectedForest,
        diffused: &mut Vec<ForestEdge>,
        samples: usize,
        resilience: &[Lanes<B>],
        share: &mut Vec<Lanes<B>>,
    ) {
        let core = &self.graph.core;
        share.clear();
        share.resize(resilience.len(), Lanes::ZERO);
        for lane in 0..samples {
            let flows = (0..resilience.len()).filter(|row| resilience[*row][lane] > 0.0);
            let candidate = |row: usize| ForestEdge {
                resilience: resilience[row][lane],
                row,
                ends: core.ends[row],
                weakest: self.graph.chains[row].equals().len().max(1),
            };
            diffused.clear();
            diffused.extend(flows.map(candidate));
            expected.grow(core.node_count(), diffused, |row, whole| share[row][lane] = whole);
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
        chosen: Chosen<'_>,
        sums: &mut Sums,
    ) {
        let graph = self.graph;
        let ReducedGraph { chains, trees, forest, weight, .. } = graph;
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
            let weighted = product(simd, &value, one);
            let square = product(simd, &weighted, &value);
            let row = row as usize;
            add(&mut sums.likelihood[row], &weighted);
            add(&mut sums.square[row], &square);
            add(&mut sums.count[row], one);
        };
        let zero = simd.splat_f64s(0.0);
        for (at, (chain, rho)) in chains.iter().zip(resilience).enumerate() {
            let whole = chosen.whole(chains.len() - at, at);
            let ChainFlow { row, others, .. } = chain;
            let flows = zip(simd, rho, counted, |rho, one| simd.select_f64s(simd.greater_than_f64s(rho, zero), one, zero));
            if chain.equals().is_empty() {
                add(*row, rho, &product(simd, &whole, counted));
            }
            for equal in chain.equals() {
                add(graph.equals[equal], rho, &product(simd, &chosen.share_of(&whole, equal, chain.equals().len()), &flows));
            }
            if let Some((row, share)) = *others {
                let share = simd.splat_f64s(share);
                add(row, &map(simd, rho, |rho| simd.mul_f64s(share, rho)), &flows);
            }
        }
        self.each_tree(simd, |tree, rho, flows| {
            let one = product(simd, flows, counted);
            add(trees[tree].row, rho, &one);
        });
    }
}

const _: () = assert!((BLOCK as usize).is_multiple_of(B), "a block is made of whole groups");
