//! A graph made ready for its samples, and the samples of one block of it, a group side by side in SIMD lanes: flow, resilience, forest, sums.
//!
//! Its rows are the vessels of a small graph, and the chains of vessels in series of a large one that was reduced.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use std::ops::Range;

use super::coins::{Block, PerSample, SUM_LANES, expectation, open_vessels, pairwise, part, perfused};
use super::forest::{ExpectedForest, ForestEdge};
use super::ties::{Tie, Ties};
use super::{Coins, ForestProgram, InForest, Kruskal, Method, Sums, Weight, batch_forest::IN_FOREST, wider};
use crate::error::{Error, Result};
use crate::flow::drops::{Drops, DropsWorkspace};
use crate::flow::pressures::{Check, MOST_BACKWARD, Residual};
use crate::flow::{
    BatchSolver, Circuit, MOST_RESILIENCE, batch::conductances::MaskedRows, batch::solver::BatchWorkspace, stranded,
};
use crate::support::simd::{InstructionSet, Kernel, Lanes, Simd, map, masked, plus, plus_product, positive, product, splat, zip};
use crate::{flow::resilience::diffused_resilience, support::random::BLOCK};

/// A graph with all that its samples share.
#[derive(Debug)]
pub struct SampledGraph {
    /// What is solved in each sample: its rows, and after them the terminals.
    pub circuit: Circuit,
    pub rows: Vec<RowFlow>,
    /// The nodes of each row, for forests.
    pub ends: Vec<[usize; 2]>,
    /// The vessels that tie for the weakest of their row, row by row.
    pub equals: Vec<u32>,
    pub trees: Vec<TreeFlow>,
    /// Vessels for which another stands, with that one and their share of its sums.
    pub shares: Vec<(u32, u32, f64)>,
    /// Where the terminals stand in the masks of a block.
    pub terminals: Vec<usize>,
    pub solver: BatchSolver,
    /// Where pressures may not show what flows in wide vessels.
    pub drops: Option<Drops>,
    /// The forest program; Kruskal's algorithm without one.
    pub forest: Option<ForestProgram>,
    pub ties: Ties,
    pub weight: Weight,
    /// How many vessels there are.
    pub vessels: usize,
    /// Whether rows are chains, and not the vessels one by one.
    pub is_reduced: bool,
    pub instructions: InstructionSet,
}

/// In which order the contributions of a block's samples are added up, which is part of what a seed gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SumOrder {
    /// Every eighth sample, and then these sums pairwise.
    EveryEighth,
    /// Eight by eight, each eight pairwise.
    Eights,
    /// One after another.
    OneByOne,
}

/// How the resilience of a row follows from pressures.
#[derive(Debug, Clone, Copy)]
pub struct RowFlow {
    /// m³/(Pa s); where there is none, `factor` is that of the drop.
    pub conductance: Option<f64>,
    /// ρ of its weakest vessel over the square of its flow or drop; zero of one that never carries flow.
    pub factor: f64,
    /// Σ ρ of its vessels over ρ of the weakest.
    pub total_share: f64,
    /// Where the pressures at its ends stand.
    pub slots: [u32; 2],
    /// The vessel that is its weakest, the last of several.
    pub vessel: u32,
    /// Where its weakest vessels are among `equals`, if there are several: a coin decides which is left out of a forest.
    pub equals: [u32; 2],
    /// The vessel that stands for its others, which are in every forest as long as there is flow, and its ρ over that of the weakest.
    pub others: Option<(u32, f64)>,
    /// Whether samples may close it.
    pub may_close: bool,
    /// The row of the circuit that has its drop.
    pub stand_in: u32,
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
    /// The vessel of the largest ρ.
    pub vessel: u32,
}

impl RowFlow {
    /// Where its weakest vessels are among [`SampledGraph::equals`]: nowhere for a single one.
    fn equals(&self) -> Range<usize> {
        self.equals[0] as usize..self.equals[1] as usize
    }
}

/// The memory of one worker that computes `B` samples side by side.
pub struct GraphWorkspace<const B: usize> {
    flow: BatchWorkspace<B>,
    /// ρ of the weakest vessel of every row.
    resilience: Vec<Lanes<B>>,
    /// The keys of every row, or by the rays of the forest program.
    key: Vec<Lanes<B>>,
    in_forest: Vec<InForest<B>>,
    /// Of several vessels that tie for the weakest of a row, the one that a coin puts last.
    is_last: Vec<InForest<B>>,
    /// The probability of every row to be in the forest whole, in an enumeration.
    share: Vec<Lanes<B>>,
    /// Per vessel the sums of likelihood, square and count of every eighth sample.
    eighths: Vec<[Lanes<SUM_LANES>; 3]>,
    kruskal: Kruskal,
    expected: ExpectedForest,
    diffused: Vec<ForestEdge>,
    /// Per row the samples of a group in which it flows, and per terminal those in which it holds, as bits.
    flowing: Vec<u64>,
    ties: Vec<Tie>,
    drops: DropsWorkspace,
    check: Check,
}

impl SampledGraph {
    /// How the samples are computed.
    pub fn method(&self) -> Method {
        Method::new(self.solver.name(), self.solver.joins(), self.forest.as_ref(), self.instructions.name())
    }

    /// Memory for one worker.
    pub fn workspace<const B: usize>(&self) -> GraphWorkspace<B> {
        const {
            assert!(
                (BLOCK as usize).is_multiple_of(B) && B.is_multiple_of(SUM_LANES),
                "a block is made of whole groups, a group of whole eights"
            );
        };
        let rows = self.rows.len();
        GraphWorkspace {
            flow: self.solver.workspace(),
            resilience: vec![Lanes::ZERO; rows],
            key: vec![Lanes::ZERO; self.forest.as_ref().map_or(rows, ForestProgram::rays)],
            in_forest: vec![[0; B]; rows + 1],
            is_last: vec![[0; B]; self.equals.len()],
            share: Vec::new(),
            eighths: vec![[Lanes::ZERO; 3]; if self.is_reduced { 0 } else { self.vessels }],
            kruskal: Kruskal::default(),
            expected: ExpectedForest::default(),
            diffused: Vec::new(),
            flowing: Vec::new(),
            ties: Vec::new(),
            drops: DropsWorkspace::default(),
            check: Check::default(),
        }
    }

    /// Replaces `sums` by those of a block.
    ///
    /// # Errors
    ///
    /// Pressures that do not meet Kirchhoff's law.
    pub fn block<const B: usize>(&self, block: Block<'_>, work: &mut GraphWorkspace<B>, sums: &mut Sums) -> Result<()> {
        sums.clear();
        let residual = self.instructions.run(BlockKernel { graph: self, block, work, sums: &mut *sums });
        sums.residual = residual.relative;
        if self.is_reduced && residual.backward > MOST_BACKWARD {
            return Err(Error::Breakdown);
        }
        for (vessel, of, share) in &self.shares {
            let (vessel, of) = (*vessel as usize, *of as usize);
            let share = if self.weight == Weight::Resilience { *share } else { 1.0 };
            sums.likelihood[vessel] = share * sums.likelihood[of];
            sums.square[vessel] = share * share * sums.square[of];
            sums.count[vessel] = sums.count[of];
        }
        Ok(())
    }

    /// The masks of the circuit's rows, in place of those of vessels and terminals.
    fn masks_of_rows<'a>(&self, masks: &'a mut [u64]) -> &'a [u64] {
        // Rows are in the order of their vessels, so that none is overwritten before it is read.
        for (at, row) in self.rows.iter().enumerate() {
            masks[at] = if row.may_close { masks[row.vessel as usize] } else { u64::MAX };
        }
        for (at, terminal) in self.terminals.iter().enumerate() {
            masks[self.rows.len() + at] = masks[*terminal];
        }
        &masks[..self.circuit.row_count()]
    }
}

/// A block of samples; the output says how well the first is solved.
struct BlockKernel<'a, const B: usize> {
    graph: &'a SampledGraph,
    block: Block<'a>,
    work: &'a mut GraphWorkspace<B>,
    /// Receives the sums of the vessels that stand for others, and what is no vessel's own.
    sums: &'a mut Sums,
}

impl<const B: usize> Kernel for BlockKernel<'_, B> {
    type Output = Residual;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Residual {
        let Self { graph, block, work, sums } = self;
        let Block { masks, probability, coins, coin, samples } = block;
        let present = open_vessels(&masks[..graph.vessels]);
        let masks = graph.masks_of_rows(masks);
        let stranded = &stranded(&graph.circuit, masks, samples);
        let GraphWorkspace { flow, resilience, key: keys, in_forest, is_last, share, eighths, .. } = work;
        let GraphWorkspace { kruskal, expected, diffused, flowing, ties, drops, check, .. } = work;
        let order = match (graph.is_reduced, &graph.forest) {
            (false, _) if probability.is_none() => SumOrder::EveryEighth,
            (true, Some(_)) => SumOrder::Eights,
            _ => SumOrder::OneByOne,
        };
        let (mut global, mut residual) = (PerSample::ZERO, Residual::default());
        eighths.fill([Lanes::ZERO; 3]);
        for first in (0..samples).step_by(B) {
            let here = (samples - first).min(B);
            let open_rows = MaskedRows { conductance: &graph.circuit.conductance, masks, first };
            graph.solver.solve(simd, &open_rows, first, stranded, flow);
            let group = SampleGroup { graph, pressure: flow.pressure(), masks, first, order };
            if first == 0 {
                let pressure = |node| group.pressure[graph.solver.slot(node)][0];
                residual = check.residual(&graph.circuit, graph.circuit.if_open(masks), stranded, pressure);
            }
            group.resiliences(simd, resilience);
            if let Some(of_drops) = &graph.drops {
                group.refine(of_drops, here, drops, resilience);
            }
            if !graph.ties.is_empty() {
                flowing.clear();
                for rho in &*resilience {
                    flowing.push(positive(simd, rho));
                }
                flowing.extend(masks[graph.rows.len()..].iter().map(|holds| holds >> first));
                graph.ties.equalise(resilience, flowing, ties);
            }
            let mut total = Lanes::ZERO;
            for (row, rho) in graph.rows.iter().zip(&*resilience) {
                total = plus_product(simd, &total, &splat(simd, row.total_share), rho);
            }
            // The order of a sum is part of what a seed gives: without a forest program the trees are summed by themselves.
            let of_rows = if graph.forest.is_some() { Lanes::ZERO } else { std::mem::replace(&mut total, Lanes::ZERO) };
            group.each_tree(simd, |tree, rho, _| {
                total = plus_product(simd, &total, &splat(simd, graph.trees[tree].total_share), rho);
            });
            total = plus(simd, &of_rows, &total);
            let coin = part(&**coin, first);
            in_forest.fill([0; B]);
            match &graph.forest {
                _ if probability.is_some() => group.expect(expected, diffused, here, resilience, share),
                Some(program) => {
                    for (widest, rows) in keys.iter_mut().zip(program.vessels_of()) {
                        let mut most = Lanes::ZERO;
                        for row in rows {
                            most = wider(simd, &most, &group.keys(simd, coins, &coin, *row as usize, resilience, is_last));
                        }
                        *widest = most;
                    }
                    program.grow(simd, coins, keys, in_forest);
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
            group.add_up(simd, &total, &counted, resilience, chosen, eighths, sums);
        }
        for (vessel, [likelihood, square, count]) in eighths.iter().enumerate().filter(|_| probability.is_none()) {
            sums.likelihood[vessel] = pairwise(likelihood);
            sums.square[vessel] = pairwise(square);
            sums.count[vessel] = pairwise(count);
        }
        sums.samples = samples as u64;
        sums.network_resilience = expectation(&global, probability);
        sums.perfused = expectation(&perfused(&global), probability);
        residual
    }
}

/// What the forests of a group have.
#[derive(Clone, Copy)]
struct Chosen<'a, const B: usize> {
    /// As a forest program has it: the last row comes first.
    in_forest: &'a [InForest<B>],
    is_last: &'a [InForest<B>],
    share: Option<&'a [Lanes<B>]>,
}

impl<const B: usize> Chosen<'_, B> {
    /// The probability of a row to be in the forest whole: one or zero in a sample.
    #[inline(always)]
    fn whole(&self, number: usize, row: usize) -> Lanes<B> {
        if let Some(share) = self.share {
            return share[row];
        }
        let mut out = Lanes::ZERO;
        for (out, in_forest) in out.iter_mut().zip(&self.in_forest[number]) {
            *out = if *in_forest == IN_FOREST { 1.0 } else { 0.0 };
        }
        out
    }

    /// The probability of one of several that tie for the weakest of such a row, where blood flows: the forest leaves out one of them at most.
    #[inline(always)]
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
struct SampleGroup<'a, const B: usize> {
    graph: &'a SampledGraph,
    pressure: &'a [Lanes<B>],
    masks: &'a [u64],
    first: usize,
    /// How its sums are taken.
    order: SumOrder,
}

impl<const B: usize> SampleGroup<'_, B> {
    /// ρ of every row's weakest vessel.
    #[inline(always)]
    fn resiliences<S: Simd>(&self, simd: S, resilience: &mut [Lanes<B>]) {
        for ((row, mask), resilience) in self.graph.rows.iter().zip(self.masks).zip(resilience) {
            let ends = row.slots.map(|slot| &self.pressure[slot as usize]);
            let rho = diffused_resilience(simd, ends, self.graph.circuit.level, row.conductance, row.factor);
            *resilience = masked(simd, &rho, *mask, self.first);
        }
    }

    /// Works out ρ from drops in those of the samples in which a vessel flows although pressures do not show it, or hardly.
    #[cold]
    fn refine(&self, drops: &Drops, samples: usize, work: &mut DropsWorkspace, resilience: &mut [Lanes<B>]) {
        let rows = &self.graph.rows;
        for lane in 0..samples {
            let is_open = |row: usize| self.masks[row] >> (self.first + lane) & 1 == 1;
            let doubtful = |row: &usize| {
                let [a, b] = rows[*row].slots.map(|slot| self.pressure[slot as usize][lane]);
                let level = self.graph.circuit.level;
                rows[*row].factor > 0.0 && is_open(*row) && Drops::has_few_digits(a - b, a + level, b + level)
            };
            if !(0..rows.len()).any(|row| doubtful(&row)) {
                continue;
            }
            drops.solve(is_open, work);
            let drop = |row: usize| drops.drop(rows[row].stand_in as usize, work);
            if !(0..rows.len()).filter(doubtful).any(|row| drop(row).is_some()) {
                continue;
            }
            for (at, (row, resilience)) in rows.iter().zip(&mut *resilience).enumerate() {
                let drop = if row.factor > 0.0 && is_open(at) { drop(at) } else { None };
                resilience[lane] = drop.map_or(0.0, |drop| (drop * drop * row.factor).min(MOST_RESILIENCE));
            }
        }
    }

    /// Calls `each` with every tree, the largest ρ in it, and one where there is flow.
    #[inline(always)]
    fn each_tree<S: Simd>(&self, simd: S, mut each: impl FnMut(usize, &Lanes<B>, &Lanes<B>)) {
        let [zero, one] = [0.0, 1.0].map(|x| simd.splat_f64s(x));
        for (row, tree) in self.graph.trees.iter().enumerate() {
            let ends = [&self.pressure[tree.slot as usize], &splat(simd, tree.end)];
            let rho = diffused_resilience(simd, ends, self.graph.circuit.level, None, tree.factor);
            let flows = map(simd, &rho, |rho| simd.select_f64s(simd.greater_than_f64s(rho, zero), one, zero));
            each(row, &rho, &flows);
        }
    }

    /// The keys of a row: those of its weakest vessel. Of several that tie, the one that the coin puts last is marked.
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
        let row = &self.graph.rows[at];
        let mut figure = splat(simd, coins.of_vessel(row.vessel as usize));
        let equals = row.equals();
        let vessels = &self.graph.equals[equals.clone()];
        if !vessels.is_empty() {
            let is_last = &mut is_last[equals];
            is_last.fill([0; B]);
            for lane in 0..B {
                let toss = |vessel: u32| coins.toss(coins.of_vessel(vessel as usize), coin[lane]);
                // Where a coin leaves two equal the lower row comes first.
                let last = (0..vessels.len()).rev().min_by_key(|i| toss(vessels[*i])).unwrap_or_default();
                figure[lane] = coins.of_vessel(vessels[last] as usize);
                is_last[last][lane] = IN_FOREST;
            }
        }
        coins.keys_or_zero(simd, &resilience[at], &figure, coin, (resilience.len() - at) as u64)
    }

    /// The forests of the group's samples, one after another.
    fn kruskal(&self, coins: &Coins, forest: &mut Kruskal, samples: usize, keys: &[Lanes<B>], in_forest: &mut [InForest<B>]) {
        let rows = keys.len();
        for lane in 0..samples {
            forest.clear();
            for key in keys.iter().map(|keys| keys[lane]).filter(|key| *key > 0.0) {
                forest.add(key.to_bits());
            }
            let row = |key| rows - coins.number_of(key);
            let take = |row: usize| in_forest[rows - row][lane] = IN_FOREST;
            forest.grow(self.graph.circuit.node_count(), &self.graph.ends, row, take);
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
        let SampledGraph { circuit, ends, rows, .. } = self.graph;
        share.clear();
        share.resize(resilience.len(), Lanes::ZERO);
        for lane in 0..samples {
            let flows = (0..resilience.len()).filter(|row| resilience[*row][lane] > 0.0);
            let candidate = |row: usize| ForestEdge {
                resilience: resilience[row][lane],
                row,
                ends: ends[row],
                weakest: rows[row].equals().len().max(1),
            };
            diffused.clear();
            diffused.extend(flows.map(candidate));
            expected.grow(circuit.node_count(), diffused, |row, whole| share[row][lane] = whole);
        }
    }

    /// Adds the group to the sums, given the ρ_G of each sample and what it counts.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "memory of a worker")]
    fn add_up<S: Simd>(
        &self,
        simd: S,
        global: &Lanes<B>,
        counted: &Lanes<B>,
        resilience: &[Lanes<B>],
        chosen: Chosen<'_, B>,
        eighths: &mut [[Lanes<SUM_LANES>; 3]],
        sums: &mut Sums,
    ) {
        let SampledGraph { rows, trees, weight, equals, .. } = self.graph;
        let mut into = VesselSums { weight: *weight, order: self.order, global, eighths, sums };
        let zero = simd.splat_f64s(0.0);
        for (at, (row, rho)) in rows.iter().zip(resilience).enumerate() {
            let whole = chosen.whole(rows.len() - at, at);
            if row.equals().is_empty() {
                into.add(simd, row.vessel, rho, &product(simd, &whole, counted));
            }
            if row.equals().is_empty() && row.others.is_none() {
                continue;
            }
            let flows = zip(simd, rho, counted, |rho, one| simd.select_f64s(simd.greater_than_f64s(rho, zero), one, zero));
            for equal in row.equals() {
                into.add(simd, equals[equal], rho, &product(simd, &chosen.share_of(&whole, equal, row.equals().len()), &flows));
            }
            if let Some((vessel, share)) = row.others {
                let share = simd.splat_f64s(share);
                into.add(simd, vessel, &map(simd, rho, |rho| simd.mul_f64s(share, rho)), &flows);
            }
        }
        self.each_tree(simd, |tree, rho, flows| into.add(simd, trees[tree].vessel, rho, &product(simd, flows, counted)));
    }
}

/// Where groups of samples are added up.
struct VesselSums<'a, const B: usize> {
    weight: Weight,
    order: SumOrder,
    /// ρ_G of each sample.
    global: &'a Lanes<B>,
    eighths: &'a mut [[Lanes<SUM_LANES>; 3]],
    sums: &'a mut Sums,
}

impl<const B: usize> VesselSums<'_, B> {
    /// Adds a vessel, given its ρ and how much each sample counts.
    #[inline(always)]
    fn add<S: Simd>(&mut self, simd: S, vessel: u32, rho: &Lanes<B>, one: &Lanes<B>) {
        let value = match self.weight {
            Weight::Resilience => rho,
            Weight::Count => &splat(simd, 1.0),
            Weight::Global => self.global,
        };
        let vessel = vessel as usize;
        if self.order == SumOrder::EveryEighth {
            let [mut likelihood, mut square, mut count] = self.eighths[vessel];
            for first in (0..B).step_by(SUM_LANES) {
                let (value, one) = (part(&**value, first), part(&**one, first));
                let weighted = product(simd, &value, &one);
                likelihood = plus(simd, &likelihood, &weighted);
                square = plus_product(simd, &square, &weighted, &value);
                count = plus(simd, &count, &one);
            }
            self.eighths[vessel] = [likelihood, square, count];
            return;
        }
        let weighted = product(simd, value, one);
        let square = product(simd, &weighted, value);
        let sums = [&mut self.sums.likelihood[vessel], &mut self.sums.square[vessel], &mut self.sums.count[vessel]];
        for (sum, lanes) in sums.into_iter().zip([&weighted, &square, one]) {
            if self.order == SumOrder::Eights {
                lanes.as_chunks().0.iter().for_each(|eight| *sum += pairwise(eight));
            } else {
                lanes.iter().for_each(|x| *sum += x);
            }
        }
    }
}
