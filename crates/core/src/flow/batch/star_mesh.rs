//! Star-mesh elimination of the grounded Laplacian, several samples at a time in SIMD lanes.
//!
//! Eliminating node k replaces the star of its conductances by the mesh c_ij += c_ki c_kj / S_k, S_k = Σ c_ki + g_k.
//! Nothing is ever subtracted, so pressures are accurate componentwise, however far the conductances are apart; a
//! floating component is a star with S_k = 0 and needs no test. In samples that hold the pressure of a node, its conductances go to ground at
//! its neighbours before that, and it is left alone.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use std::collections::HashMap;

use super::conductances::Conductances;
use crate::flow::circuit::Circuit;
use crate::support::elimination::{Elimination, NOWHERE};
use crate::support::marked;
use crate::support::simd::{Lanes, Simd, map, masked, plus, plus_product, product, splat, zip};

/// The compiled elimination of a circuit.
#[derive(Debug, Clone)]
pub struct StarMesh {
    pub(super) program: Elimination,
    /// Per node where its pressure stands: the free ones in elimination order, then the fixed ones, each pressure once.
    slot: Vec<u32>,
    /// Per ray the vessels on it.
    vessels_of: Vec<Vec<u32>>,
    grounds: Vec<GroundStamp>,
    /// Terminal conductance and inflow by place.
    shunt: Vec<f64>,
    source: Vec<f64>,
    fixed: Vec<f64>,
    holds: Vec<Hold>,
}

/// A pressure that some samples hold.
#[derive(Debug, Clone)]
struct Hold {
    /// The row of the terminal, open where it holds.
    terminal: u32,
    place: u32,
    pressure: f64,
    /// The rays on which its vessels lie, with the places they lead to.
    rays: Vec<[u32; 2]>,
}

/// A vessel from a free node to one of fixed pressure.
#[derive(Debug, Clone, Copy)]
struct GroundStamp {
    vessel: u32,
    place: u32,
    /// Where the fixed pressure stands.
    fixed: u32,
}

/// The memory of one worker that solves `B` samples side by side.
#[derive(Debug, Clone)]
pub struct StarMeshWorkspace<const B: usize> {
    /// Conductances by ray; once a star is eliminated, the weights of its mean.
    pub(super) conductance: Vec<Lanes<B>>,
    pub(super) ground: Vec<Lanes<B>>,
    /// Pressures by slot, Pa above the circuit's level; zero throughout a floating component.
    pub pressure: Vec<Lanes<B>>,
    /// For each pressure that some samples hold, one where it is held.
    held: Vec<Lanes<B>>,
}

impl StarMesh {
    /// Compiles what `order` makes of the free nodes, by their number, and of the links between them; `None` where it makes nothing.
    pub(super) fn compile(circuit: &Circuit, order: impl FnOnce(usize, &[[usize; 2]]) -> Option<Elimination>) -> Option<Self> {
        let is_free = |node: usize| circuit.fixed[node].is_none();
        Some(Self::with(circuit, Elimination::among(circuit.node_count(), &circuit.ends, is_free, order)?))
    }

    /// The same elimination for a circuit with the same vessels and free nodes.
    pub(super) fn of_same_graph(&self, circuit: &Circuit) -> Self {
        Self::with(circuit, self.program.clone())
    }

    fn with(circuit: &Circuit, program: Elimination) -> Self {
        let mut slot = vec![NOWHERE; circuit.node_count()];
        // Outlets of one pressure share its place.
        let (mut fixed, mut place_of) = (Vec::new(), HashMap::new());
        for (node, slot) in slot.iter_mut().enumerate() {
            *slot = match circuit.fixed[node] {
                None => program.place(node),
                Some(pressure) => *place_of.entry(pressure.to_bits()).or_insert_with(|| {
                    fixed.push(pressure);
                    (program.nodes() + fixed.len() - 1) as u32
                }),
            };
        }
        let (mut links, mut grounds) = (Vec::new(), Vec::new());
        let fixing = marked(circuit.row_count(), circuit.fixing().map(|(row, _)| row));
        for (vessel, &[a, b]) in circuit.ends.iter().enumerate().filter(|(row, e)| e[0] != e[1] && !fixing[*row]) {
            let vessel = vessel as u32;
            match (circuit.fixed[a], circuit.fixed[b]) {
                (None, None) => links.push((vessel, [slot[a], slot[b]])),
                (None, Some(_)) => grounds.push(GroundStamp { vessel, place: slot[a], fixed: slot[b] }),
                (Some(_), None) => grounds.push(GroundStamp { vessel, place: slot[b], fixed: slot[a] }),
                (Some(_), Some(_)) => {}
            }
        }
        let (mut shunt, mut source) = (vec![0.0; program.nodes()], vec![0.0; program.nodes()]);
        for node in (0..circuit.node_count()).filter(|node| circuit.fixed[*node].is_none()) {
            shunt[slot[node] as usize] = circuit.shunt[node];
            source[slot[node] as usize] = circuit.source[node];
        }
        let holds = holds(circuit, &slot, &program);
        let vessels_of = program.rows_by_ray(links);
        Self { program, slot, vessels_of, grounds, shunt, source, fixed, holds }
    }

    /// Injects what is injected in a circuit that does not differ in anything else.
    pub(super) fn inject_as(&mut self, circuit: &Circuit) {
        for (node, source) in circuit.source.iter().enumerate().filter(|(node, _)| circuit.fixed[*node].is_none()) {
            self.source[self.slot[node] as usize] = *source;
        }
    }

    /// Where the pressure of a node stands in a workspace.
    pub fn slot(&self, node: usize) -> usize {
        self.slot[node] as usize
    }

    /// The memory for groups of `B` samples.
    pub fn workspace<const B: usize>(&self) -> StarMeshWorkspace<B> {
        let (nodes, rays) = (self.program.nodes(), self.program.rays());
        let fixed = self.fixed.iter().map(|p| Lanes([*p; B]));
        StarMeshWorkspace {
            conductance: vec![Lanes::ZERO; rays],
            ground: vec![Lanes::ZERO; nodes],
            pressure: vec![Lanes::ZERO; nodes].into_iter().chain(fixed).collect(),
            held: vec![Lanes::ZERO; self.holds.len()],
        }
    }

    /// Conductances by ray, terminal conductances by place, and inflows in the place of the pressures, from the conductance of each row of the
    /// circuit in the samples from `first` on.
    #[inline(always)]
    pub(super) fn assemble<S: Simd, const B: usize>(
        &self,
        simd: S,
        rows: &impl Conductances<B>,
        first: usize,
        stranded: &[(usize, u64)],
        work: &mut StarMeshWorkspace<B>,
    ) {
        for (place, (shunt, source)) in self.shunt.iter().zip(&self.source).enumerate() {
            work.ground[place] = splat(simd, *shunt);
            work.pressure[place] = splat(simd, *source);
        }
        for (node, samples) in stranded {
            let source = &mut work.pressure[self.slot[*node] as usize];
            *source = masked(simd, source, !samples, first);
        }
        for (sum, vessels) in work.conductance.iter_mut().zip(&self.vessels_of) {
            let mut all = Lanes::ZERO;
            for vessel in vessels {
                all = plus(simd, &all, &rows.of_row(simd, *vessel as usize));
            }
            *sum = all;
        }
        for stamp in &self.grounds {
            let own = &rows.of_row(simd, stamp.vessel as usize);
            let (place, pressure) = (stamp.place as usize, work.pressure[stamp.fixed as usize]);
            work.ground[place] = plus(simd, &work.ground[place], own);
            work.pressure[place] = plus_product(simd, &work.pressure[place], own, &pressure);
        }
        for (at, hold) in self.holds.iter().enumerate() {
            let held = rows.of_row(simd, hold.terminal as usize);
            work.held[at] = held;
            // Products with zero and one are exact.
            let (held_at, place) = (splat(simd, hold.pressure), hold.place as usize);
            for [ray, to] in &hold.rays {
                let (ray, to) = (*ray as usize, *to as usize);
                let moved = product(simd, &work.conductance[ray], &held);
                work.conductance[ray] = without(simd, &work.conductance[ray], &held);
                work.ground[to] = plus(simd, &work.ground[to], &moved);
                work.pressure[to] = plus_product(simd, &work.pressure[to], &moved, &held_at);
            }
            work.ground[place] = without(simd, &work.ground[place], &held);
            work.pressure[place] = without(simd, &work.pressure[place], &held);
        }
    }

    #[inline(always)]
    pub(super) fn eliminate<S: Simd, const B: usize>(&self, simd: S, work: &mut StarMeshWorkspace<B>) {
        let ray_to = self.program.ray_to();
        for k in 0..self.program.eliminated() {
            let star = self.program.star(k);
            // A star's mesh lies in later stars only.
            let (done, later) = work.conductance.split_at_mut(star.end);
            let rays = &mut done[star.clone()];
            let (ground, source) = (work.ground[k], work.pressure[k]);
            let mut total = ground;
            for c in &*rays {
                total = plus(simd, &total, c);
            }
            let inverse = inverse(simd, &total);
            let mut mesh = self.program.mesh(k).iter();
            for (i, to) in ray_to[star.clone()].iter().enumerate() {
                let weight = product(simd, &rays[i], &inverse);
                rays[i] = weight;
                let to = *to as usize;
                work.ground[to] = plus_product(simd, &work.ground[to], &weight, &ground);
                work.pressure[to] = plus_product(simd, &work.pressure[to], &weight, &source);
                for (other, target) in rays[i + 1..].iter().zip(&mut mesh) {
                    let sum = &mut later[*target as usize - star.end];
                    *sum = plus_product(simd, sum, &weight, other);
                }
            }
            work.pressure[k] = product(simd, &source, &inverse);
        }
    }

    #[inline(always)]
    pub(super) fn substitute_back<S: Simd, const B: usize>(&self, simd: S, work: &mut StarMeshWorkspace<B>) {
        let ray_to = self.program.ray_to();
        for k in (0..self.program.eliminated()).rev() {
            let mut p = work.pressure[k];
            for ray in self.program.star(k) {
                p = plus_product(simd, &p, &work.conductance[ray], &work.pressure[ray_to[ray] as usize]);
            }
            work.pressure[k] = p;
        }
        for (hold, held) in self.holds.iter().zip(&work.held) {
            let pressure = &mut work.pressure[hold.place as usize];
            *pressure = plus_product(simd, &without(simd, pressure, held), held, &splat(simd, hold.pressure));
        }
    }
}

/// What holds the pressures of free nodes in some samples.
fn holds(circuit: &Circuit, slot: &[u32], program: &Elimination) -> Vec<Hold> {
    let is_free = |node: usize| circuit.fixed[node].is_none();
    let mut rays: std::collections::BTreeMap<usize, Vec<[u32; 2]>> = std::collections::BTreeMap::new();
    let fixing: Vec<(usize, [usize; 2])> = circuit.fixing().filter(|(_, [node, to])| node != to && is_free(*node)).collect();
    for (_, [node, _]) in &fixing {
        rays.insert(*node, Vec::new());
    }
    for &[a, b] in circuit.ends.iter().filter(|[a, b]| a != b && is_free(*a) && is_free(*b)) {
        for (node, to) in [(a, b), (b, a)] {
            if let Some(rays) = rays.get_mut(&node) {
                let ray = [program.ray_between(slot[node], slot[to]), slot[to]];
                if !rays.contains(&ray) {
                    rays.push(ray);
                }
            }
        }
    }
    let mut hold = |(row, [node, outside]): (usize, [usize; 2])| {
        let pressure = circuit.fixed[outside]?;
        Some(Hold { terminal: row as u32, place: slot[node], pressure, rays: rays.remove(&node)? })
    };
    fixing.into_iter().filter_map(&mut hold).collect()
}

/// Zero where `held` is one; the values where it is zero.
#[inline(always)]
fn without<S: Simd, const B: usize>(simd: S, values: &Lanes<B>, held: &Lanes<B>) -> Lanes<B> {
    let one = simd.splat_f64s(1.0);
    zip(simd, values, held, |value, held| simd.mul_f64s(value, simd.sub_f64s(one, held)))
}

/// 1/S of a star. A floating remainder has no conductance at all; its weights then are zero.
#[inline(always)]
pub(super) fn inverse<S: Simd, const B: usize>(simd: S, total: &Lanes<B>) -> Lanes<B> {
    let [zero, one, least] = [0.0, 1.0, f64::MIN_POSITIVE].map(|x| simd.splat_f64s(x));
    map(simd, total, |t| simd.select_f64s(simd.greater_than_or_equal_f64s(t, least), simd.div_f64s(one, t), zero))
}
