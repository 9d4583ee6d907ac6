//! The samples of one block, a group of lanes at a time: flow, resilience, forest, sums.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::forest::{Forest, MOST_RESILIENCE, keys_or_zero};
use super::forest_lanes::{TAKEN, Taken};
use super::likelihood::Sums;
use super::options::Weight;
use super::sums::{Samples, Tally, expectation, open_vessels, part};
use super::whole_graph::Whole;
use crate::flow::batch::star_mesh;
use crate::flow::residual::Check;
use crate::flow::resilience::DROP_CUT;
use crate::support::random::BLOCK;
use crate::support::simd::{InstructionSet, Kernel, Lanes, Simd, map, masked, plus, splat, zip};

/// The memory of a group, by its width.
pub enum Group {
    /// Eight samples side by side.
    Eight(Memory<8>),
    /// Sixteen samples side by side.
    Sixteen(Memory<16>),
    /// Thirty-two samples side by side.
    ThirtyTwo(Memory<32>),
}

/// The memory of a group of `B`.
#[derive(Debug)]
pub struct Memory<const B: usize> {
    flow: star_mesh::Workspace<B>,
    level: Vec<Level<B>>,
    /// ρ of every vessel, one group after another.
    resilience: Vec<Lanes<B>>,
    /// Keys by ray of the forest program, or by vessel.
    key: Vec<Lanes<B>>,
    /// Every vessel's place in the forests, one group after another.
    taken: Vec<Taken<B>>,
    forest: Forest,
    check: Check,
}

/// The pressure at a slot above the circuit's level, and the least drop that is more than rounding beside it, Pa.
#[derive(Debug, Clone, Copy)]
struct Level<const B: usize> {
    pressure: Lanes<B>,
    cut: Lanes<B>,
}

impl<const B: usize> Memory<B> {
    /// Memory for so many vessels and keys.
    pub fn new(flow: star_mesh::Workspace<B>, vessels: usize, keys: usize) -> Self {
        Self {
            level: vec![Level { pressure: Lanes::ZERO, cut: Lanes::ZERO }; flow.pressure.len()],
            flow,
            resilience: vec![Lanes::ZERO; vessels * BLOCK as usize / B],
            key: vec![Lanes::ZERO; keys],
            taken: vec![[0; B]; (vessels + 1) * BLOCK as usize / B],
            forest: Forest::default(),
            check: Check::default(),
        }
    }
}

/// Rays of both programs up to which a group of thirty-two is the fastest: beyond, its memory leaves the nearest caches.
const RAYS_OF_32: usize = 1024;

/// The width of a group: what is forced, or what suits the instruction set and programs with so many rays.
pub fn lanes(instructions: InstructionSet, rays: usize, forced: Option<&str>) -> usize {
    match (forced, instructions) {
        (Some("8"), _) => 8,
        (Some("16"), _) => 16,
        (Some("32"), _) => 32,
        (_, InstructionSet::Avx512) if rays <= RAYS_OF_32 => 32,
        (_, InstructionSet::Avx512 | InstructionSet::Avx2) => 16,
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
pub struct BlockOfLanes<'a> {
    /// The graph.
    pub whole: &'a Whole,
    /// Per vessel the samples in which it is open; no bit beyond `samples`.
    pub masks: &'a [u64],
    /// Nodes whose injected flow has nowhere to go, with the samples in which that is so.
    pub stranded: &'a [(usize, u64)],
    /// How many samples.
    pub samples: usize,
    /// What each sample counts, for an enumeration; one without.
    pub probability: Option<&'a [f64; BLOCK as usize]>,
}

/// A block whose samples are taken in groups of `B`.
pub struct InLanes<'a, const B: usize> {
    /// What the groups share.
    pub job: BlockOfLanes<'a>,
    /// The memory of a group.
    pub work: &'a mut Memory<B>,
    /// Receives the sums.
    pub sums: &'a mut Sums,
}

impl<const B: usize> Kernel for InLanes<'_, B> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { job, work, sums } = self;
        let Whole { solver, bottleneck, .. } = job.whole;
        let vessels = job.whole.flows.len();
        work.taken.fill([0; B]);
        let present = open_vessels(simd, job.masks);
        let mut global = Samples::ZERO;
        for (at, first) in (0..job.samples).step_by(B).enumerate() {
            solver.solve(simd, job.masks, first, job.stranded, &mut work.flow);
            if first == 0 {
                let pressure = |node| work.flow.pressure[solver.slot(node)][0];
                sums.residual = work.check.residual(&job.whole.circuit, job.masks, 0, job.stranded, pressure).relative;
            }
            job.level(simd, &work.flow.pressure, &mut work.level);
            if let Some(program) = bottleneck {
                program.clear(&mut work.key);
            }
            let total = job.resiliences(simd, at, work);
            global[first..first + B].copy_from_slice(&*total);
            let taken = &mut work.taken[at * (vessels + 1)..][..=vessels];
            match bottleneck {
                Some(program) => program.grow(simd, &mut work.key, taken),
                None => job.kruskal(&mut work.forest, &work.key, taken),
            }
        }
        // Nothing flows where no vessel is open.
        let global = zip(simd, &global, &present, |sum, n| simd.div_f64s(sum, simd.max_f64s(n, simd.splat_f64s(1.0))));
        sums.samples = job.samples as u64;
        sums.network_resilience = expectation(&global, job.probability);
        let tally = Tally { taken: &work.taken, vessels };
        let resilience = |vessel: usize, first: usize| part(&*work.resilience[first / B * vessels + vessel], first % B);
        let one = |_, _| splat(simd, 1.0);
        let global = |_, first| part(&*global, first);
        match (job.whole.weight, job.probability) {
            (Weight::Resilience, None) => tally.add_up(simd, resilience, sums),
            (Weight::Resilience, Some(p)) => tally.add_up_weighted(simd, resilience, p, sums),
            (Weight::Count, None) => tally.add_up(simd, one, sums),
            (Weight::Count, Some(p)) => tally.add_up_weighted(simd, one, p, sums),
            (Weight::Global, None) => tally.add_up(simd, global, sums),
            (Weight::Global, Some(p)) => tally.add_up_weighted(simd, global, p, sums),
        }
    }
}

impl BlockOfLanes<'_> {
    /// What the vessels at a slot need to know of it.
    #[inline(always)]
    fn level<S: Simd, const B: usize>(&self, simd: S, pressure: &[Lanes<B>], level: &mut [Level<B>]) {
        let (above, share) = (simd.splat_f64s(self.whole.circuit.level), simd.splat_f64s(DROP_CUT));
        for (level, pressure) in level.iter_mut().zip(pressure) {
            level.pressure = *pressure;
            level.cut = map(simd, pressure, |p| simd.mul_f64s(share, simd.abs_f64s(simd.add_f64s(p, above))));
        }
    }

    /// ρ and the forest key of every vessel in a group; returns Σ ρ of each sample.
    #[inline(always)]
    fn resiliences<S: Simd, const B: usize>(&self, simd: S, group: usize, work: &mut Memory<B>) -> Lanes<B> {
        let [most, zero] = [MOST_RESILIENCE, 0.0].map(|x| simd.splat_f64s(x));
        let (level, key) = (&work.level[..], &mut work.key[..]);
        let mut sum = Lanes::ZERO;
        let flows = &self.whole.flows;
        let resilience = &mut work.resilience[group * flows.len()..][..flows.len()];
        let vessels = flows.iter().zip(self.masks).zip(self.whole.offers()).zip(resilience);
        for (vessel, (((flow, mask), offer), resilience)) in vessels.enumerate() {
            let [a, b] = flow.slots.map(|slot| &level[slot as usize]);
            let drop = zip(simd, &a.pressure, &b.pressure, |a, b| simd.sub_f64s(a, b));
            let least = zip(simd, &a.cut, &b.cut, |a, b| simd.max_f64s(a, b));
            let factor = simd.splat_f64s(flow.factor);
            let rho = zip(simd, &drop, &least, |drop, least| {
                let flows = simd.greater_than_f64s(simd.abs_f64s(drop), least);
                let rho = simd.min_f64s(simd.mul_f64s(simd.mul_f64s(drop, drop), factor), most);
                simd.select_f64s(flows, rho, zero)
            });
            let rho = masked(simd, &rho, *mask, group * B);
            sum = plus(simd, &sum, &rho);
            *resilience = rho;
            offer.put(simd, &keys_or_zero(simd, &rho, vessel), key);
        }
        sum
    }

    /// The forests of a group, one sample after another.
    fn kruskal<const B: usize>(&self, forest: &mut Forest, keys: &[Lanes<B>], taken: &mut [Taken<B>]) {
        for lane in 0..B {
            forest.clear();
            for keys in keys.iter().map(|k| k[lane]).filter(|k| *k > 0.0) {
                forest.add(keys.to_bits());
            }
            let Whole { circuit, ends, flows, .. } = self.whole;
            forest.grow(circuit.node_count(), ends, |vessel| taken[flows.len() - vessel][lane] = TAKEN);
        }
    }
}
