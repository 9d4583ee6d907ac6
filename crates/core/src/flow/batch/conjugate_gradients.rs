//! Conjugate gradients for circuits whose elimination would fill in: large meshes, several samples at a time in SIMD lanes.
//!
//! Nodes of few neighbours are eliminated exactly ([`StarMesh`]), which removes most nodes of a mesh of vessels and adds hardly any
//! conductances. The rest, the core, is solved by conjugate gradients, preconditioned by an incomplete elimination of
//! the same kind: joins without a place are dropped, and `GROUNDED` of each goes to ground at its two ends, which keeps
//! nearly all row sums (Gustafsson 1978, modified incomplete factorisation) and never subtracts.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use super::conductances::Conductances;
use super::star_mesh::{StarMesh, StarMeshWorkspace, inverse};
use crate::flow::circuit::Circuit;
use crate::flow::dead_ends::{DeadEnds, DeadEndsWorkspace};
use crate::support::elimination::{Elimination, Incomplete, NOWHERE};
use crate::support::simd::{Lanes, Simd, map, plus, plus_product, product, splat, zip};

/// Nodes of at most so many neighbours are eliminated exactly.
const FEW: usize = 6;
/// The share of a dropped join that goes to ground.
const GROUNDED: f64 = 0.03;
/// The energy of the error, as a share of that of the answer, at which a sample is solved: the square of 1e-13.
const ENERGY: f64 = 1e-26;
/// The most steps; far more than any circuit of vessels has needed.
const MOST_STEPS: usize = 5000;

/// The core that partial elimination leaves of a circuit, compiled.
#[derive(Debug, Clone)]
pub struct ConjugateGradients {
    /// The incomplete elimination of the core.
    pub incomplete: Incomplete,
    pub(super) dead_ends: DeadEnds,
    fixed: Vec<Option<f64>>,
    /// One over the largest conductance of a vessel.
    scale: f64,
}

/// The memory of one worker that solves the core of `B` samples side by side, beside that of the elimination.
#[derive(Debug, Clone)]
pub struct GradientsWorkspace<const B: usize> {
    /// Conductances of the incomplete elimination, over the largest; once a star is eliminated, the weights of its mean. Single precision
    /// is enough for a preconditioner, and half of the memory that every step passes over.
    weight: Vec<[f32; B]>,
    /// 1/S of its stars.
    inverse: Vec<[f32; B]>,
    residual: Vec<Lanes<B>>,
    direction: Vec<Lanes<B>>,
    /// The outflow at the direction; later the preconditioned residual.
    product: Vec<Lanes<B>>,
    /// The pressures of one sample by node, and the memory for its dead ends.
    pressure: Vec<f64>,
    dead_ends: DeadEndsWorkspace,
}

impl ConjugateGradients {
    /// Eliminates the nodes of few neighbours of a circuit, and compiles the rest; `None` when indices cannot count its joins.
    pub fn compile(circuit: &Circuit) -> Option<(StarMesh, Self)> {
        let mesh = StarMesh::compile(circuit, |nodes, links| Elimination::compile_partly(nodes, links, FEW))?;
        let incomplete = Incomplete::compile(&mesh.program);
        let largest = circuit.conductance[..circuit.vessel_count()].iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let dead_ends = DeadEnds::new(circuit);
        Some((mesh, Self { incomplete, dead_ends, fixed: circuit.fixed.clone(), scale: 1.0 / largest }))
    }

    /// The memory for groups of `B` samples.
    pub fn workspace<const B: usize>(&self) -> GradientsWorkspace<B> {
        let core = || vec![Lanes::ZERO; self.incomplete.program.nodes()];
        GradientsWorkspace {
            weight: vec![[0.0; B]; self.incomplete.program.rays()],
            inverse: vec![[0.0; B]; self.incomplete.program.nodes()],
            residual: core(),
            direction: core(),
            product: core(),
            pressure: vec![0.0; self.fixed.len()],
            dead_ends: DeadEndsWorkspace::default(),
        }
    }

    /// Levels the dead ends of every sample: iteration leaves rounding there that could pass for flow.
    pub(super) fn level_dead_ends<const B: usize>(
        &self,
        mesh: &StarMesh,
        of_mesh: &mut StarMeshWorkspace<B>,
        work: &mut GradientsWorkspace<B>,
        rows: &impl Conductances<B>,
    ) {
        let GradientsWorkspace { pressure, dead_ends, .. } = work;
        for lane in 0..B {
            for (node, p) in pressure.iter_mut().enumerate() {
                *p = of_mesh.pressure[mesh.slot(node)][lane];
            }
            self.dead_ends.level(|vessel| rows.is_open(vessel, lane), dead_ends, pressure, &self.fixed);
            for (node, p) in pressure.iter().enumerate() {
                of_mesh.pressure[mesh.slot(node)][lane] = *p;
            }
        }
    }

    /// The incomplete elimination of the core, of a group of samples whose other nodes are eliminated.
    #[inline(always)]
    pub(super) fn precondition<S: Simd, const B: usize>(
        &self,
        simd: S,
        program: &Elimination,
        mesh: &StarMeshWorkspace<B>,
        work: &mut GradientsWorkspace<B>,
    ) {
        let core = program.eliminated();
        let GradientsWorkspace { weight, inverse: inverses, residual: ground, .. } = work;
        for (weight, from) in weight.iter_mut().zip(&self.incomplete.from) {
            *weight = if *from == NOWHERE { [0.0; B] } else { narrow(&mesh.conductance[*from as usize], self.scale) };
        }
        // The residual is not needed yet; its memory takes the grounds.
        for (ground, own) in ground.iter_mut().zip(&mesh.ground[core..]) {
            *ground = map(simd, own, |g| simd.mul_f64s(g, simd.splat_f64s(self.scale)));
        }
        let grounded = splat(simd, GROUNDED);
        let ray_to = self.incomplete.program.ray_to();
        for k in 0..self.incomplete.program.nodes() {
            let star = self.incomplete.program.star(k);
            let (done, later) = weight.split_at_mut(star.end);
            let rays = &mut done[star.clone()];
            let own = ground[k];
            let mut total = own;
            for c in &*rays {
                total = plus(simd, &total, &wide(c));
            }
            let one_over = inverse(simd, &total);
            let to = &ray_to[star.clone()];
            let mut mesh = self.incomplete.program.mesh(k).iter();
            for i in 0..rays.len() {
                let weight = product(simd, &wide(&rays[i]), &one_over);
                rays[i] = narrow(&weight, 1.0);
                let mut lost = Lanes::ZERO;
                for ((j, other), target) in rays.iter().enumerate().skip(i + 1).zip(&mut mesh) {
                    let other = &wide(other);
                    if *target == NOWHERE {
                        let join = product(simd, &weight, other);
                        lost = plus(simd, &lost, &join);
                        let ground = &mut ground[to[j] as usize];
                        *ground = plus_product(simd, ground, &grounded, &join);
                    } else {
                        let sum = &mut later[*target as usize - star.end];
                        *sum = narrow(&plus_product(simd, &wide(sum), &weight, other), 1.0);
                    }
                }
                let ground = &mut ground[to[i] as usize];
                let share = plus_product(simd, &product(simd, &weight, &own), &grounded, &lost);
                *ground = plus(simd, ground, &share);
            }
            // What single precision cannot hold belongs to a node that is all but cut off.
            inverses[k] = narrow(&map(simd, &one_over, |i| simd.min_f64s(i, simd.splat_f64s(f64::from(f32::MAX)))), 1.0);
        }
    }

    /// Applies the preconditioner to the residual.
    #[inline(always)]
    fn improve<S: Simd, const B: usize>(&self, simd: S, work: &mut GradientsWorkspace<B>) {
        let ray_to = self.incomplete.program.ray_to();
        let GradientsWorkspace { weight, inverse, residual, product: better, .. } = work;
        better.copy_from_slice(residual);
        for k in 0..self.incomplete.program.nodes() {
            let star = self.incomplete.program.star(k);
            let own = better[k];
            for (weight, to) in weight[star.clone()].iter().zip(&ray_to[star]) {
                let sum = &mut better[*to as usize];
                *sum = plus_product(simd, sum, &wide(weight), &own);
            }
            better[k] = product(simd, &own, &wide(&inverse[k]));
        }
        for k in (0..self.incomplete.program.nodes()).rev() {
            let star = self.incomplete.program.star(k);
            let mut sum = better[k];
            for (weight, to) in weight[star.clone()].iter().zip(&ray_to[star]) {
                sum = plus_product(simd, &sum, &wide(weight), &better[*to as usize]);
            }
            better[k] = sum;
        }
    }

    /// What flows out of every node of the core at the pressures `at`.
    #[inline(always)]
    fn flows<S: Simd, const B: usize>(
        simd: S,
        program: &Elimination,
        mesh: &StarMeshWorkspace<B>,
        at: &[Lanes<B>],
        flow: &mut [Lanes<B>],
    ) {
        let core = program.eliminated();
        for (flow, (ground, at)) in flow.iter_mut().zip(mesh.ground[core..].iter().zip(at)) {
            *flow = product(simd, ground, at);
        }
        for k in 0..at.len() {
            let star = program.star(core + k);
            let (own, mut out) = (at[k], flow[k]);
            for (c, to) in mesh.conductance[star.clone()].iter().zip(&program.ray_to()[star]) {
                let to = *to as usize - core;
                let drop = zip(simd, &own, &at[to], |a, b| simd.sub_f64s(a, b));
                let along = product(simd, c, &drop);
                out = plus(simd, &out, &along);
                flow[to] = zip(simd, &flow[to], &along, |f, q| simd.sub_f64s(f, q));
            }
            flow[k] = out;
        }
    }

    /// Finds the pressures of the core from what flows into it.
    #[inline(always)]
    pub(super) fn iterate<S: Simd, const B: usize>(
        &self,
        simd: S,
        program: &Elimination,
        mesh: &mut StarMeshWorkspace<B>,
        work: &mut GradientsWorkspace<B>,
    ) {
        let core = program.eliminated()..program.nodes();
        let answer = &mut mesh.pressure[core.clone()];
        work.residual.copy_from_slice(answer);
        answer.fill(Lanes::ZERO);
        self.improve(simd, work);
        work.direction.copy_from_slice(&work.product);
        let mut energy = dot(simd, &work.residual, &work.product);
        let enough = map(simd, &energy, |e| simd.mul_f64s(e, simd.splat_f64s(ENERGY)));
        let mut steps = 0;
        while energy.iter().zip(enough.iter()).any(|(energy, enough)| energy > enough) && steps < MOST_STEPS {
            Self::flows(simd, program, mesh, &work.direction, &mut work.product);
            let bend = dot(simd, &work.direction, &work.product);
            // A sample that is solved stands still, so that no other one changes it.
            let moving = |ratio: Lanes<B>| {
                let mut out = ratio;
                for (lane, ratio) in out.iter_mut().enumerate() {
                    if energy[lane] <= enough[lane] {
                        *ratio = 0.0;
                    }
                }
                out
            };
            let step = moving(zip(simd, &energy, &bend, |e, b| simd.div_f64s(e, b)));
            let answer = &mut mesh.pressure[core.clone()];
            for (k, answer) in answer.iter_mut().enumerate() {
                *answer = plus_product(simd, answer, &step, &work.direction[k]);
                let lost = product(simd, &step, &work.product[k]);
                work.residual[k] = zip(simd, &work.residual[k], &lost, |r, l| simd.sub_f64s(r, l));
            }
            self.improve(simd, work);
            let now = dot(simd, &work.residual, &work.product);
            let turn = moving(zip(simd, &now, &energy, |now, before| simd.div_f64s(now, before)));
            for (direction, better) in work.direction.iter_mut().zip(&work.product) {
                *direction = plus_product(simd, better, &turn, direction);
            }
            for (lane, energy) in energy.iter_mut().enumerate() {
                if *energy > enough[lane] {
                    *energy = now[lane];
                }
            }
            steps += 1;
        }
    }
}

/// In single precision, `scale` times.
#[inline(always)]
fn narrow<const B: usize>(values: &Lanes<B>, scale: f64) -> [f32; B] {
    values.0.map(|x| (x * scale) as f32)
}

#[inline(always)]
fn wide<const B: usize>(values: &[f32; B]) -> Lanes<B> {
    Lanes(values.map(f64::from))
}

/// Σ a b, lane by lane.
#[inline(always)]
fn dot<S: Simd, const B: usize>(simd: S, a: &[Lanes<B>], b: &[Lanes<B>]) -> Lanes<B> {
    a.iter().zip(b).fold(Lanes::ZERO, |sum, (a, b)| plus_product(simd, &sum, a, b))
}
