//! The samples of one block of a reduced graph, eight at a time: flow, resilience, forest, accounts.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::bottleneck::{Bottleneck, TAKEN, Taken};
use super::census::open_vessels;
use super::forest::{Forest, key, keys};
use super::likelihood::Sums;
use super::params::Weight;
use super::reduced::Solve;
use super::sampler::Block;
use super::tally::{Samples, expectation};
use super::ties::{self, Ties};
use crate::error::{Error, Result};
use crate::hemodynamics::residual::{Check, Residual};
use crate::hemodynamics::{Circuit, cholesky, conjugate_gradients, star_mesh};
use crate::resilience::DROP_CUT;
use crate::rng::BLOCK;
use crate::simd::{Kernel, Lanes, Simd, map, masked, plus_product, splat, zip};

/// Samples side by side: with more of them the memory of a large graph only lies further away.
const B: usize = 8;
/// Resiliences are cut here, so that their keys stay finite as doubles.
const MOST: f64 = f64::MAX / 8.0;
/// A reduced graph.
#[derive(Debug)]
pub struct Core {
    pub circuit: Circuit,
    pub links: Vec<LinkFlow>,
    pub trees: Vec<TreeFlow>,
    pub solve: Solve,
    pub bottleneck: Option<Bottleneck>,
    pub ties: Ties,
    /// How many accounts: of the links, of the trees, of the chains.
    pub accounts: usize,
}

/// How the resilience of a link follows from pressures.
#[derive(Debug, Clone, Copy)]
pub struct LinkFlow {
    /// Where the pressures at its ends stand.
    pub slots: [u32; 2],
    /// m³/(Pa s).
    pub conductance: f64,
    /// ρ of its weakest vessel over the square of its flow.
    pub factor: f64,
    /// Σ ρ of its vessels over that of the weakest.
    pub whole: f64,
    /// The account of its other vessels, which every forest takes as long as there is flow.
    pub carried: Option<u32>,
    /// The vessel on trial that it is.
    pub mask: Option<u32>,
}

/// How the resilience in a tree follows from the pressure P at the node that it hangs on.
#[derive(Debug, Clone, Copy)]
pub struct TreeFlow {
    /// Where P stands.
    pub slot: u32,
    /// P₀, Pa above the level.
    pub end: f64,
    /// The largest ρ over the square of P - P₀.
    pub factor: f64,
    /// Σ ρ over the largest.
    pub whole: f64,
}

/// The memory of one worker.
pub struct Workspace {
    /// Per link the samples in which it is open.
    pub masks: Vec<u64>,
    /// The sums of a block.
    pub accounts: Sums,
    flow: FlowMemory,
    /// ρ of the weakest vessel of every link.
    resilience: Vec<Lanes<B>>,
    /// Keys by ray of the forest program.
    key: Vec<Lanes<B>>,
    taken: Vec<Taken<B>>,
    forest: Forest,
    ties: ties::Workspace,
    check: Check,
}

enum FlowMemory {
    Lanes(star_mesh::Workspace<B>),
    Gradients(Box<conjugate_gradients::Workspace<B>>),
    Cholesky { memory: Box<cholesky::Workspace>, pressure: Vec<Lanes<B>> },
}

impl Workspace {
    /// Memory for a reduced graph.
    pub fn new(core: &Core) -> Self {
        let links = core.links.len();
        Self {
            masks: Vec::with_capacity(links),
            accounts: Sums::zero(core.accounts),
            flow: match &core.solve {
                Solve::Lanes(program) => FlowMemory::Lanes(program.workspace()),
                Solve::Gradients(program) => FlowMemory::Gradients(Box::new(program.workspace())),
                Solve::Cholesky(_) => {
                    FlowMemory::Cholesky { memory: Box::default(), pressure: vec![Lanes::ZERO; core.circuit.node_count()] }
                }
            },
            resilience: vec![Lanes::ZERO; links],
            key: vec![Lanes::ZERO; core.bottleneck.as_ref().map_or(0, Bottleneck::rays)],
            taken: vec![[0; B]; links + 1],
            forest: Forest::default(),
            ties: ties::Workspace::default(),
            check: Check::default(),
        }
    }

    /// Takes from the masks of all vessels those of the links.
    pub fn gather(&mut self, core: &Core, masks: &[u64]) {
        self.masks.clear();
        self.masks.extend(core.links.iter().map(|link| link.mask.map_or(u64::MAX, |row| masks[row as usize])));
    }
}

/// A block whose samples are taken in groups of eight; how well the first is solved.
pub struct InLanes<'a> {
    pub core: &'a Core,
    pub block: Block<'a>,
    /// Nodes of the core whose injected flow has nowhere to go, with the samples in which that is so.
    pub stranded: &'a [(usize, u64)],
    pub weight: Weight,
    pub work: &'a mut Workspace,
    /// Receives what is no vessel's own.
    pub sums: &'a mut Sums,
}

impl Kernel for InLanes<'_> {
    type Output = Result<Residual>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<Residual> {
        let Self { core, block, stranded, weight, work, sums } = self;
        let present = open_vessels(simd, block.masks);
        let (mut global, mut residual) = (Samples::ZERO, Residual::default());
        work.accounts.clear();
        for first in (0..block.samples).step_by(B) {
            let lanes = (block.samples - first).min(B);
            let pressure = match (&core.solve, &mut work.flow) {
                (Solve::Lanes(program), FlowMemory::Lanes(memory)) => {
                    program.solve(simd, &work.masks, first, stranded, memory);
                    &memory.pressure
                }
                (Solve::Gradients(program), FlowMemory::Gradients(memory)) => {
                    program.solve(simd, &work.masks, first, stranded, memory);
                    &memory.mesh.pressure
                }
                (Solve::Cholesky(factor), FlowMemory::Cholesky { memory, pressure }) => {
                    for (lane, sample) in (first..first + lanes).enumerate() {
                        let open = |link: usize| work.masks[link] >> sample & 1 == 1;
                        factor.solve(open, memory, |node, p| pressure[node][lane] = p)?;
                    }
                    pressure
                }
                _ => return Err(Error::Breakdown),
            };
            if first == 0 {
                let pressure = |node| pressure[core.slot(node)][0];
                residual = work.check.residual(&core.circuit, &work.masks, 0, stranded, pressure);
            }
            let group = Group { core, pressure, level: core.circuit.level, masks: &work.masks, first };
            group.resiliences(simd, &mut work.resilience);
            core.ties.settle(|link| core.links[link].factor, &mut work.resilience, &mut work.ties);
            let mut total = Lanes::ZERO;
            for (link, rho) in core.links.iter().zip(&work.resilience) {
                total = plus_product(simd, &total, &splat(simd, link.whole), rho);
            }
            group.of_trees(simd, |tree, rho, _| {
                total = plus_product(simd, &total, &splat(simd, core.trees[tree].whole), rho);
            });
            work.taken.fill([0; B]);
            match &core.bottleneck {
                Some(program) => {
                    offer(simd, program, &work.resilience, &mut work.key);
                    program.grow(simd, &mut work.key, &mut work.taken);
                }
                None => core.kruskal(&work.resilience, &mut work.forest, &mut work.taken, lanes),
            }
            let mut counted = Lanes::ZERO;
            for lane in 0..lanes {
                let open = present[first + lane];
                total[lane] = if open > 0.0 { total[lane] / open } else { 0.0 };
                global[first + lane] = total[lane];
                counted[lane] = block.probability.map_or(1.0, |p| p[first + lane]);
            }
            let worth = Worth { weight, global: total, counted };
            group.account(simd, &worth, &work.resilience, &work.taken, &mut work.accounts);
        }
        sums.samples = block.samples as u64;
        sums.network_resilience = expectation(&global, block.probability);
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
            [DROP_CUT, self.level, conductance, factor, MOST, 0.0].map(|x| simd.splat_f64s(x));
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

    /// Adds the group to the accounts.
    #[inline(always)]
    fn account<S: Simd>(&self, simd: S, worth: &Worth, resilience: &[Lanes<B>], taken: &[Taken<B>], accounts: &mut Sums) {
        let links = self.core.links.len();
        let Worth { weight, global, counted } = worth;
        let mut add = |account: usize, rho: &Lanes<B>, one: &Lanes<B>| {
            let value = match weight {
                Weight::Resilience => *rho,
                Weight::Count => splat(simd, 1.0),
                Weight::Global => *global,
            };
            let value_of = zip(simd, &value, one, |value, one| simd.mul_f64s(value, one));
            let square = zip(simd, &value_of, &value, |a, b| simd.mul_f64s(a, b));
            accounts.likelihood[account] += sum(&value_of);
            accounts.square[account] += sum(&square);
            accounts.count[account] += sum(one);
        };
        for (row, (link, rho)) in self.core.links.iter().zip(resilience).enumerate() {
            let mut one = *counted;
            for (one, taken) in one.iter_mut().zip(&taken[links - row]) {
                *one = if *taken == TAKEN { *one } else { 0.0 };
            }
            add(row, rho, &one);
            if let Some(account) = link.carried {
                let zero = simd.splat_f64s(0.0);
                let flows = zip(simd, rho, counted, |rho, one| simd.select_f64s(simd.greater_than_f64s(rho, zero), one, zero));
                add(account as usize, rho, &flows);
            }
        }
        self.of_trees(simd, |tree, rho, flows| {
            let one = zip(simd, flows, counted, |flows, one| simd.mul_f64s(flows, one));
            add(links + tree, rho, &one);
        });
    }
}

impl Core {
    /// The forests of a group, one sample after another.
    fn kruskal(&self, resilience: &[Lanes<B>], forest: &mut Forest, taken: &mut [Taken<B>], lanes: usize) {
        let links = self.links.len();
        for lane in 0..lanes {
            forest.clear();
            for (row, rho) in resilience.iter().enumerate().filter(|(_, rho)| rho[lane] > 0.0) {
                forest.add(key(rho[lane], row));
            }
            forest.grow(self.circuit.node_count(), &self.circuit.ends, |row| taken[links - row][lane] = TAKEN);
        }
    }

    fn slot(&self, node: usize) -> usize {
        match &self.solve {
            Solve::Lanes(program) => program.slot(node),
            Solve::Gradients(program) => program.slot(node),
            Solve::Cholesky(_) => node,
        }
    }
}

/// Offers the keys of all links to a forest program.
#[inline(always)]
fn offer<S: Simd>(simd: S, program: &Bottleneck, resilience: &[Lanes<B>], key: &mut [Lanes<B>]) {
    let zero = simd.splat_f64s(0.0);
    program.clear(key);
    for (row, (offer, rho)) in program.offers().iter().zip(resilience).enumerate() {
        let keys = map(simd, rho, |rho| simd.select_f64s(simd.greater_than_f64s(rho, zero), keys(simd, rho, row), zero));
        offer.put(simd, &keys, key);
    }
}

/// The sum of the lanes, pairwise.
fn sum(lanes: &Lanes<B>) -> f64 {
    let [a, b, c, d, e, f, g, h] = lanes.0;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

const _: () = assert!((BLOCK as usize).is_multiple_of(B), "a block is made of whole groups");
