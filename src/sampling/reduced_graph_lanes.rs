//! The samples of one block of a reduced graph, eight at a time: flow, resilience, forest, sums.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::forest::{MOST_RESILIENCE, keys_or_zero};
use super::forest_lanes::{Bottleneck, TAKEN, Taken};
use super::likelihood::Sums;
use super::options::Weight;
use super::reduced_graph::{Core, ReducedBlock, Solve};
use super::sums::{Samples, expectation, pairwise};
use super::ties;
use crate::error::{Error, Result};
use crate::flow::batch::star_mesh;
use crate::flow::residual::{Check, Residual};
use crate::flow::resilience::DROP_CUT;
use crate::support::random::BLOCK;
use crate::support::simd::{Kernel, Lanes, Simd, map, masked, plus_product, splat, zip};

/// Samples side by side: with more of them the memory of a large graph only lies further away.
const B: usize = 8;

/// The memory of one worker.
pub struct Memory {
    flow: Option<star_mesh::Workspace<B>>,
    /// ρ of the weakest vessel of every link.
    resilience: Vec<Lanes<B>>,
    taken: Vec<Taken<B>>,
    ties: ties::Workspace,
    check: Check,
}

impl Memory {
    /// Memory for a reduced graph.
    pub fn new(core: &Core) -> Self {
        let links = core.links.len();
        Self {
            flow: match &core.solve {
                Solve::Lanes(program) => {
                    // The keys of the forest program come to lie where the conductances were.
                    Some(program.workspace_with(core.bottleneck.as_ref().map_or(0, Bottleneck::rays)))
                }
                _ => None,
            },
            resilience: vec![Lanes::ZERO; links],
            taken: vec![[0; B]; links + 1],
            ties: ties::Workspace::default(),
            check: Check::default(),
        }
    }
}

/// A block whose samples are taken in groups of eight; how well the first is solved.
pub struct InLanes<'a> {
    pub job: ReducedBlock<'a>,
    pub memory: &'a mut Memory,
    /// Receives the sums of the vessels that stand for others, and what is no vessel's own.
    pub sums: &'a mut Sums,
}

impl Kernel for InLanes<'_> {
    type Output = Result<Residual>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<Residual> {
        let Self { job: ReducedBlock { core, samples, probability, present, masks, stranded, weight }, memory, sums } = self;
        let Memory { flow, resilience, taken, ties, check } = memory;
        let (Solve::Lanes(solver), Some(forest), Some(flow)) = (&core.solve, &core.bottleneck, flow) else {
            return Err(Error::Breakdown);
        };
        let (mut global, mut residual) = (Samples::ZERO, Residual::default());
        for first in (0..samples).step_by(B) {
            solver.solve(simd, masks, first, stranded, flow);
            let (pressure, key) = flow.spare();
            let group = Group { core, pressure, level: core.circuit.level, masks, first };
            if first == 0 {
                residual = check.residual(&core.circuit, masks, 0, stranded, |node| pressure[solver.slot(node)][0]);
            }
            group.resiliences(simd, resilience);
            core.ties.settle::<B, _>(|link| core.links[link].factor, resilience, ties);
            let mut total = Lanes::ZERO;
            for (link, rho) in core.links.iter().zip(&*resilience) {
                total = plus_product(simd, &total, &splat(simd, link.whole), rho);
            }
            group.of_trees(simd, |tree, rho, _| {
                total = plus_product(simd, &total, &splat(simd, core.trees[tree].whole), rho);
            });
            taken.fill([0; B]);
            offer(simd, forest, resilience, key);
            forest.grow(simd, key, taken);
            let mut counted = Lanes::ZERO;
            for lane in 0..(samples - first).min(B) {
                let open = present[first + lane];
                total[lane] = if open > 0.0 { total[lane] / open } else { 0.0 };
                global[first + lane] = total[lane];
                counted[lane] = probability.map_or(1.0, |p| p[first + lane]);
            }
            group.add_up(simd, &Worth { weight, global: total, counted }, resilience, taken, sums);
        }
        sums.samples = samples as u64;
        sums.network_resilience = expectation(&global, probability);
        Ok(residual)
    }
}

/// What a vessel contributes in each of eight samples.
struct Worth {
    weight: Weight,
    /// ρ_G of each.
    global: Lanes<B>,
    /// What each counts.
    counted: Lanes<B>,
}

/// Eight samples at their pressures.
struct Group<'a> {
    core: &'a Core,
    pressure: &'a [Lanes<B>],
    level: f64,
    masks: &'a [u64],
    first: usize,
}

impl Group<'_> {
    /// ρ of every link's weakest vessel.
    #[inline(always)]
    fn resiliences<S: Simd>(&self, simd: S, resilience: &mut [Lanes<B>]) {
        for ((link, mask), resilience) in self.core.links.iter().zip(self.masks).zip(resilience) {
            let [a, b] = link.slots.map(|slot| &self.pressure[slot as usize]);
            let drop = zip(simd, a, b, |a, b| simd.sub_f64s(a, b));
            let rho = self.resilience(simd, &drop, [a, b], link.conductance, link.factor);
            *resilience = masked(simd, &rho, *mask, self.first);
        }
    }

    /// Calls `each` with every tree, the largest ρ in it, and one where there is flow.
    #[inline(always)]
    fn of_trees<S: Simd>(&self, simd: S, mut each: impl FnMut(usize, &Lanes<B>, &Lanes<B>)) {
        let [zero, one] = [0.0, 1.0].map(|x| simd.splat_f64s(x));
        for (row, tree) in self.core.trees.iter().enumerate() {
            let (at, end) = (&self.pressure[tree.slot as usize], splat(simd, tree.end));
            let drop = zip(simd, at, &end, |a, b| simd.sub_f64s(a, b));
            let rho = self.resilience(simd, &drop, [at, &end], 1.0, tree.factor);
            let flows = map(simd, &rho, |rho| simd.select_f64s(simd.greater_than_f64s(rho, zero), one, zero));
            each(row, &rho, &flows);
        }
    }

    /// (C ΔP)² times a factor; zero where the drop is rounding.
    #[inline(always)]
    fn resilience<S: Simd>(&self, simd: S, drop: &Lanes<B>, ends: [&Lanes<B>; 2], conductance: f64, factor: f64) -> Lanes<B> {
        let [share, above, conductance, factor, most, zero] =
            [DROP_CUT, self.level, conductance, factor, MOST_RESILIENCE, 0.0].map(|x| simd.splat_f64s(x));
        let largest = zip(simd, ends[0], ends[1], |a, b| {
            simd.max_f64s(simd.abs_f64s(simd.add_f64s(a, above)), simd.abs_f64s(simd.add_f64s(b, above)))
        });
        zip(simd, drop, &largest, |drop, largest| {
            let flow = simd.mul_f64s(conductance, drop);
            let rho = simd.min_f64s(simd.mul_f64s(simd.mul_f64s(flow, flow), factor), most);
            let flows = simd.greater_than_f64s(simd.abs_f64s(drop), simd.mul_f64s(share, largest));
            simd.select_f64s(flows, rho, zero)
        })
    }

    /// Adds the group to the sums.
    #[inline(always)]
    fn add_up<S: Simd>(&self, simd: S, worth: &Worth, resilience: &[Lanes<B>], taken: &[Taken<B>], sums: &mut Sums) {
        let links = self.core.links.len();
        let Worth { weight, global, counted } = worth;
        let mut add = |row: u32, rho: &Lanes<B>, one: &Lanes<B>| {
            let value = match weight {
                Weight::Resilience => *rho,
                Weight::Count => splat(simd, 1.0),
                Weight::Global => *global,
            };
            let weighted = zip(simd, &value, one, |value, one| simd.mul_f64s(value, one));
            let square = zip(simd, &weighted, &value, |a, b| simd.mul_f64s(a, b));
            let row = row as usize;
            sums.likelihood[row] += pairwise(&weighted);
            sums.square[row] += pairwise(&square);
            sums.count[row] += pairwise(one);
        };
        let zero = simd.splat_f64s(0.0);
        for (at, (link, rho)) in self.core.links.iter().zip(resilience).enumerate() {
            let mut one = *counted;
            for (one, taken) in one.iter_mut().zip(&taken[links - at]) {
                *one = if *taken == TAKEN { *one } else { 0.0 };
            }
            add(link.row, rho, &one);
            if let Some((row, share)) = link.carried {
                let share = simd.splat_f64s(share);
                let flows = zip(simd, rho, counted, |rho, one| simd.select_f64s(simd.greater_than_f64s(rho, zero), one, zero));
                add(row, &map(simd, rho, |rho| simd.mul_f64s(share, rho)), &flows);
            }
        }
        self.of_trees(simd, |tree, rho, flows| {
            let one = zip(simd, flows, counted, |flows, one| simd.mul_f64s(flows, one));
            add(self.core.trees[tree].row, rho, &one);
        });
    }
}

/// Offers the keys of all links to a forest program.
#[inline(always)]
fn offer<S: Simd>(simd: S, program: &Bottleneck, resilience: &[Lanes<B>], key: &mut [Lanes<B>]) {
    program.clear(key);
    for (row, (offer, rho)) in program.offers().iter().zip(resilience).enumerate() {
        offer.put(simd, &keys_or_zero(simd, rho, row), key);
    }
}

const _: () = assert!((BLOCK as usize).is_multiple_of(B), "a block is made of whole groups");
