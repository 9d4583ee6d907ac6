//! The samples of one block of a reduced graph whose forests are grown one after another; pressures of eight are solved at a time.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::forest::{Forest, MOST_RESILIENCE, key};
use super::likelihood::Sums;
use super::reduced_graph::{Core, ReducedBlock, Solve};
use super::sums::{Samples, expectation};
use super::ties;
use crate::error::{Error, Result};
use crate::flow::batch::{conjugate_gradients, star_mesh};
use crate::flow::cholesky;
use crate::flow::residual::{Check, Residual};
use crate::flow::resilience::is_diffused;
use crate::support::simd::{Kernel, Simd};

/// Samples solved side by side.
const B: usize = 8;

/// The memory of one worker.
pub struct Memory {
    flow: FlowMemory,
    /// By node, Pa above the level.
    pressure: Vec<f64>,
    /// ρ of the weakest vessel of every link.
    resilience: Vec<[f64; 1]>,
    forest: Forest,
    ties: ties::Workspace,
    check: Check,
}

enum FlowMemory {
    Lanes(star_mesh::Workspace<B>),
    Gradients(Box<conjugate_gradients::Workspace<B>>),
    Cholesky(Box<cholesky::Workspace>),
}

impl Memory {
    /// Memory for a reduced graph.
    pub fn new(core: &Core) -> Self {
        Self {
            flow: match &core.solve {
                Solve::Lanes(program) => FlowMemory::Lanes(program.workspace()),
                Solve::Gradients(program) => FlowMemory::Gradients(Box::new(program.workspace())),
                Solve::Cholesky(_) => FlowMemory::Cholesky(Box::default()),
            },
            pressure: vec![0.0; core.circuit.node_count()],
            resilience: vec![[0.0]; core.links.len()],
            forest: Forest::default(),
            ties: ties::Workspace::default(),
            check: Check::default(),
        }
    }
}

/// A block whose samples are taken one by one; how well the first is solved.
pub struct OneByOne<'a> {
    pub job: ReducedBlock<'a>,
    pub memory: &'a mut Memory,
    /// Receives the sums of the vessels that stand for others, and what is no vessel's own.
    pub sums: &'a mut Sums,
}

impl Kernel for OneByOne<'_> {
    type Output = Result<Residual>;

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) -> Result<Residual> {
        let (mut global, mut residual) = (Samples::ZERO, Residual::default());
        for first in (0..self.job.samples).step_by(B) {
            match (&self.job.core.solve, &mut self.memory.flow) {
                (Solve::Lanes(program), FlowMemory::Lanes(work)) => {
                    program.solve(simd, self.job.masks, first, self.job.stranded, work);
                }
                (Solve::Gradients(program), FlowMemory::Gradients(work)) => {
                    program.solve(simd, self.job.masks, first, self.job.stranded, work);
                }
                _ => {}
            }
            for sample in first..self.job.samples.min(first + B) {
                self.pressures(first, sample)?;
                if sample == 0 {
                    let Memory { check, pressure, .. } = &mut *self.memory;
                    residual =
                        check.residual(&self.job.core.circuit, self.job.masks, 0, self.job.stranded, |node| pressure[node]);
                }
                global[sample] = self.one(sample, self.job.present[sample]);
            }
        }
        self.sums.samples = self.job.samples as u64;
        self.sums.network_resilience = expectation(&global, self.job.probability);
        Ok(residual)
    }
}

impl OneByOne<'_> {
    /// The pressures of a sample, those of the eight from `first` on being solved.
    fn pressures(&mut self, first: usize, sample: usize) -> Result<()> {
        let Memory { flow, pressure, .. } = &mut *self.memory;
        match (&self.job.core.solve, flow) {
            (Solve::Lanes(program), FlowMemory::Lanes(work)) => {
                for (node, p) in pressure.iter_mut().enumerate() {
                    *p = work.pressure[program.slot(node)][sample - first];
                }
            }
            (Solve::Gradients(program), FlowMemory::Gradients(work)) => {
                program.pressures(self.job.masks, first, sample, work, pressure);
            }
            (Solve::Cholesky(factor), FlowMemory::Cholesky(work)) => {
                factor.solve(|link| self.job.masks[link] >> sample & 1 == 1, work, |node, p| pressure[node] = p)?;
            }
            _ => return Err(Error::Breakdown),
        }
        Ok(())
    }

    /// Adds a sample to the sums; its ρ_G, given how many vessels are open.
    fn one(&mut self, sample: usize, present: f64) -> f64 {
        let (core, memory) = (self.job.core, &mut *self.memory);
        let Memory { pressure, resilience, forest, ties, .. } = memory;
        let level = core.circuit.level;
        let rho = |flow: f64, factor: f64, a: f64, b: f64| {
            if is_diffused(a - b, a + level, b + level) { (flow * flow * factor).min(MOST_RESILIENCE) } else { 0.0 }
        };
        for (row, (link, out)) in core.links.iter().zip(&mut *resilience).enumerate() {
            let [a, b] = link.slots.map(|node| pressure[node as usize]);
            let open = self.job.masks[row] >> sample & 1 == 1;
            *out = [if open { rho(link.conductance * (a - b), link.factor, a, b) } else { 0.0 }];
        }
        core.ties.settle::<1, _>(|link| core.links[link].factor, resilience, ties);
        let of_tree = |row: usize| {
            let tree = &core.trees[row];
            let p = pressure[tree.slot as usize];
            rho(p - tree.end, tree.factor, p, tree.end)
        };
        let of_links: f64 = core.links.iter().zip(&*resilience).map(|(link, [rho])| link.whole * rho).sum();
        let of_trees: f64 = (0..core.trees.len()).map(|row| core.trees[row].whole * of_tree(row)).sum();
        let global = if present > 0.0 { (of_links + of_trees) / present } else { 0.0 };

        let (weight, sums) = (self.job.weight, &mut *self.sums);
        let one = self.job.probability.map_or(1.0, |p| p[sample]);
        let mut add = |row: u32, rho: f64| {
            let (row, value) = (row as usize, weight.of(rho, global));
            sums.likelihood[row] += value * one;
            sums.square[row] += value * one * value;
            sums.count[row] += one;
        };
        forest.clear();
        for (row, (link, [rho])) in core.links.iter().zip(&*resilience).enumerate().filter(|(_, (_, [rho]))| *rho > 0.0) {
            forest.add(key(*rho, row));
            if let Some((other, share)) = link.carried {
                add(other, share * rho);
            }
        }
        for (row, tree) in core.trees.iter().enumerate() {
            let rho = of_tree(row);
            if rho > 0.0 {
                add(tree.row, rho);
            }
        }
        forest.grow(core.circuit.node_count(), &core.circuit.ends, |link| add(core.links[link].row, resilience[link][0]));
        global
    }
}
