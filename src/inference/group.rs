//! The samples of one block, a group of lanes at a time: flow, resilience, forest, sums.

use super::bottleneck::Bottleneck;
use super::forest::{Forest, key};
use super::likelihood::Sums;
use super::params::Weight;
use crate::error::Result;
use crate::hemodynamics::cholesky::{self, Cholesky};
use crate::hemodynamics::star_mesh::{self, StarMesh};
use crate::resilience::{DROP_CUT, is_diffused};
use crate::rng::BLOCK;
use crate::simd::{InstructionSet, Lanes, lane_masks, masked, plus_product, zip};

/// Sums are kept in so many lanes, whatever the width of a group, so that the width changes no bit.
const SUM_LANES: usize = 8;
/// Resiliences are cut here, so that their keys stay finite as doubles.
const MOST: f64 = f64::MAX / 8.0;

/// The memory of a group, by its width.
pub enum Group {
    /// One sample at a time, for the sparse solver.
    One(Box<Single>),
    /// Eight samples side by side.
    Eight(Memory<8>),
    /// Sixteen samples side by side.
    Sixteen(Memory<16>),
}

/// The memory of a group of one.
#[derive(Default)]
pub struct Single {
    solver: cholesky::Workspace,
    pressure: Vec<f64>,
    resilience: Vec<f64>,
    forest: Forest,
}

/// The memory of a group of `B`.
#[derive(Debug)]
pub struct Memory<const B: usize> {
    flow: star_mesh::Workspace<B>,
    resilience: Vec<Lanes<B>>,
    key: Vec<Lanes<B>>,
    widest: Vec<Lanes<B>>,
    taken: Vec<u64>,
    sums: Vec<[Lanes<SUM_LANES>; 2]>,
    forest: Forest,
}

impl<const B: usize> Memory<B> {
    /// Memory for so many vessels and rays of the forest program.
    pub fn new(flow: star_mesh::Workspace<B>, vessels: usize, rays: usize) -> Self {
        Self {
            flow,
            resilience: vec![Lanes::ZERO; vessels],
            key: vec![Lanes::ZERO; vessels],
            widest: vec![Lanes::ZERO; rays],
            taken: vec![0; vessels + 1],
            sums: vec![[Lanes::ZERO; 2]; vessels],
            forest: Forest::default(),
        }
    }
}

/// The width of a group: what is forced, or what suits the instruction set.
pub fn lanes(instructions: InstructionSet, forced: Option<&str>) -> usize {
    match (forced, instructions) {
        (Some("8"), _) => 8,
        (Some("16"), _) | (_, InstructionSet::Avx512 | InstructionSet::Avx2) => 16,
        _ => 8,
    }
}

/// How a vessel's resilience follows from pressures.
#[derive(Debug, Clone, Copy)]
pub struct Flow {
    /// Where the pressures at the two ends of its chain stand.
    pub slots: [u32; 2],
    /// ρ over the square of the drop between them, W/(m³ Pa²); zero for a vessel that never carries flow.
    pub factor: f64,
}

/// What all groups of a block share.
#[derive(Debug)]
pub struct Job<'a> {
    /// Per vessel the samples in which it is open; no bit beyond `samples`.
    pub masks: &'a [u64],
    /// Nodes whose injected flow has nowhere to go, with the samples in which that is so.
    pub stranded: &'a [(usize, u64)],
    /// How many samples.
    pub samples: usize,
    /// Per vessel how its resilience follows.
    pub flows: &'a [Flow],
    /// Added to every pressure, Pa.
    pub level: f64,
    /// What each sample counts, for an enumeration; one without.
    pub probability: Option<&'a [f64; BLOCK as usize]>,
    /// The nodes of each vessel.
    pub ends: &'a [[usize; 2]],
    /// How many nodes.
    pub nodes: usize,
    /// What a vessel of the forest contributes.
    pub weight: Weight,
    /// The forest program; Kruskal's algorithm without one.
    pub bottleneck: Option<&'a Bottleneck>,
}

impl Job<'_> {
    /// The whole block in groups of `B`.
    #[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
    #[inline(always)]
    pub fn lanes<const B: usize>(&self, solver: &StarMesh, work: &mut Memory<B>, sums: &mut Sums) {
        work.sums.fill([Lanes::ZERO; 2]);
        work.taken.fill(0);
        let present = self.present();
        let mut global_sum = [0.0; SUM_LANES];
        for first in (0..self.samples).step_by(B) {
            solver.solve(self.masks, first, self.stranded, &mut work.flow);
            let mut global = self.resiliences(first, work);
            for lane in 0..B {
                let count = present[first + lane];
                global[lane] = if count > 0.0 { global[lane] / count } else { 0.0 };
                global_sum[lane % SUM_LANES] += global[lane] * self.probability.map_or(1.0, |p| p[first + lane]);
            }
            match self.bottleneck {
                Some(program) => self.accumulate(program, first, &global, work),
                None => self.accumulate_by_kruskal(first, &global, work),
            }
        }
        sums.samples = self.samples as u64;
        sums.network_resilience = tree_sum(&global_sum);
        for (vessel, [likelihood, square]) in work.sums.iter().enumerate() {
            sums.likelihood[vessel] = tree_sum(likelihood);
            sums.square[vessel] = tree_sum(square);
            sums.count[vessel] = self.count(work.taken[vessel]);
        }
    }

    /// ρ and the forest key of every vessel; returns Σ ρ of each sample.
    #[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
    #[inline(always)]
    fn resiliences<const B: usize>(&self, first: usize, work: &mut Memory<B>) -> Lanes<B> {
        let mut sum = Lanes::ZERO;
        work.widest.fill(Lanes::ZERO);
        for (vessel, (flow, mask)) in self.flows.iter().zip(self.masks).enumerate() {
            let open = lane_masks(mask >> first);
            let (a, b) = (&work.flow.pressure[flow.slots[0] as usize], &work.flow.pressure[flow.slots[1] as usize]);
            let drop = zip(a, b, |a, b| a - b);
            let top = zip(a, b, |a, b| {
                let (a, b) = ((a + self.level).abs(), (b + self.level).abs());
                if a > b { a } else { b }
            });
            let rho = zip(&drop, &top, |drop, top| {
                let flows = u64::from(drop.abs() > DROP_CUT * top).wrapping_neg();
                let rho = drop * drop * flow.factor;
                let rho = if rho < MOST { rho } else { MOST };
                f64::from_bits(rho.to_bits() & flows)
            });
            let rho = masked(&rho, &open);
            let keys = zip(&rho, &rho, |rho, _| {
                let live = u64::from(rho > 0.0).wrapping_neg();
                f64::from_bits(key(rho, vessel) & live)
            });
            sum = zip(&sum, &rho, |a, b| a + b);
            work.resilience[vessel] = rho;
            if let Some(program) = self.bottleneck {
                program.offer(vessel, &keys, &mut work.widest);
            } else {
                work.key[vessel] = keys;
            }
        }
        sum
    }

    #[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
    #[inline(always)]
    fn accumulate<const B: usize>(&self, program: &Bottleneck, first: usize, global: &Lanes<B>, work: &mut Memory<B>) {
        program.grow(&mut work.widest, first, &mut work.taken);
        let mut ones = Lanes([1.0; B]);
        if let Some(probability) = self.probability {
            ones.copy_from_slice(&probability[first..first + B]);
        }
        for ((rho, taken), [likelihood, square]) in work.resilience.iter().zip(&work.taken).zip(&mut work.sums) {
            let takes = lane_masks(taken >> first);
            let values = match self.weight {
                Weight::Resilience => rho,
                Weight::Count => &Lanes([1.0; B]),
                Weight::Global => global,
            };
            let (values, ones) = (masked(values, &takes), masked(&ones, &takes));
            for half in 0..B / SUM_LANES {
                let (value, one) = (part(&values, half), part(&ones, half));
                let weighted = zip(&value, &one, |a, b| a * b);
                *likelihood = zip(likelihood, &weighted, |a, b| a + b);
                *square = plus_product(square, &weighted, &value);
            }
        }
    }

    fn accumulate_by_kruskal<const B: usize>(&self, first: usize, global: &Lanes<B>, work: &mut Memory<B>) {
        for (lane, global) in global.iter().enumerate() {
            let one = self.probability.map_or(1.0, |p| p[first + lane]);
            work.forest.clear();
            for keys in work.key.iter().map(|k| k[lane]).filter(|k| *k > 0.0) {
                work.forest.add(keys.to_bits());
            }
            work.forest.grow(self.nodes, self.ends, |vessel| {
                let value = self.weight.of(work.resilience[vessel][lane], *global);
                let [likelihood, square] = &mut work.sums[vessel];
                likelihood[lane % SUM_LANES] += value * one;
                square[lane % SUM_LANES] += value * one * value;
                work.taken[vessel] |= 1 << (first + lane);
            });
        }
    }

    /// The whole block, one sample after another, by the sparse solver and Kruskal's algorithm.
    ///
    /// # Errors
    ///
    /// The factorisation breaks down.
    pub fn one_by_one(&self, solver: &Cholesky, work: &mut Single, sums: &mut Sums) -> Result<()> {
        let present = self.present();
        let Single { solver: memory, pressure, resilience, forest } = work;
        pressure.resize(self.nodes, 0.0);
        sums.clear();
        for (sample, present) in present.iter().enumerate().take(self.samples) {
            let is_open = |vessel: usize| self.masks[vessel] >> sample & 1 == 1;
            solver.solve(is_open, memory, |node, p| pressure[node] = p)?;
            resilience.clear();
            forest.clear();
            for (vessel, flow) in self.flows.iter().enumerate() {
                let [a, b] = flow.slots.map(|slot| pressure[slot as usize]);
                let flows = is_open(vessel) && is_diffused(a - b, a + self.level, b + self.level);
                let rho = if flows { ((a - b) * (a - b) * flow.factor).min(MOST) } else { 0.0 };
                resilience.push(rho);
                if rho > 0.0 {
                    forest.add(key(rho, vessel));
                }
            }
            let total: f64 = resilience.iter().sum();
            let global = if *present > 0.0 { total / present } else { 0.0 };
            let one = self.probability.map_or(1.0, |p| p[sample]);
            sums.samples += 1;
            sums.network_resilience += global * one;
            forest.grow(self.nodes, self.ends, |vessel| {
                let value = self.weight.of(resilience[vessel], global);
                sums.likelihood[vessel] += value * one;
                sums.square[vessel] += value * one * value;
                sums.count[vessel] += one;
            });
        }
        Ok(())
    }

    /// How much the samples of a word count.
    fn count(&self, taken: u64) -> f64 {
        let Some(probability) = self.probability else { return f64::from(taken.count_ones()) };
        let mut lanes = [0.0; SUM_LANES];
        for (sample, p) in probability.iter().enumerate() {
            lanes[sample % SUM_LANES] += if taken >> sample & 1 == 1 { *p } else { 0.0 };
        }
        tree_sum(&lanes)
    }

    /// |Ẽ|: how many vessels are open in each sample, counted in bit planes.
    fn present(&self) -> [f64; BLOCK as usize] {
        let mut planes = [0_u64; 32];
        for mask in self.masks {
            let mut carry = *mask;
            for plane in &mut planes {
                if carry == 0 {
                    break;
                }
                (*plane, carry) = (*plane ^ carry, *plane & carry);
            }
        }
        std::array::from_fn(|sample| {
            let bits = planes.iter().enumerate().map(|(power, plane)| (plane >> sample & 1) << power);
            bits.sum::<u64>() as f64
        })
    }
}

/// One half, or the whole, of a group.
#[expect(clippy::inline_always, reason = "part of a lane loop")]
#[inline(always)]
fn part<const B: usize>(values: &Lanes<B>, half: usize) -> Lanes<SUM_LANES> {
    let mut out = Lanes::ZERO;
    out.copy_from_slice(&values[half * SUM_LANES..(half + 1) * SUM_LANES]);
    out
}

/// The sum of the lanes, pairwise.
fn tree_sum(lanes: &[f64; SUM_LANES]) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes;
    ((a + b) + (c + d)) + ((e + f) + (g + h))
}
