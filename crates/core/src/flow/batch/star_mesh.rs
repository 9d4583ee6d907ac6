//! Star-mesh elimination of the grounded Laplacian, several samples at a time in SIMD lanes.
//!
//! Eliminating node k replaces the star of its conductances by the mesh c_ij += c_ki c_kj / S_k, S_k = Σ c_ki + g_k.
//! Nothing is ever subtracted, so pressures are accurate componentwise, however far the conductances are apart; a
//! floating component is a star with S_k = 0 and needs no test. In samples that hold the pressure of a node, its conductances go to ground at
//! its neighbours before that, and it is left alone.

#![expect(clippy::inline_always, reason = "compiled as a whole for each instruction set")]

use std::collections::HashMap;

use crate::flow::circuit::Circuit;
use crate::support::elimination::{Elimination, NOWHERE};
use crate::support::simd::{Lanes, Simd, map, masked, plus, plus_product, product, splat, zip};

/// The compiled elimination of a circuit.
#[derive(Debug, Clone)]
pub struct StarMesh {
    program: Elimination,
    /// Per node where its pressure stands: the free ones in elimination order, then the fixed ones, each pressure once.
    slot: Vec<u32>,
    rays: Vec<RayStamp>,
    /// The rays that no vessel lies on.
    fill: Vec<u32>,
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

/// A vessel between two free nodes.
#[derive(Debug, Clone, Copy)]
struct RayStamp {
    vessel: u32,
    ray: u32,
    /// Whether it is the first of its ray.
    first: bool,
    conductance: f64,
}

/// A vessel from a free node to one of fixed pressure.
#[derive(Debug, Clone, Copy)]
struct GroundStamp {
    vessel: u32,
    place: u32,
    conductance: f64,
    /// Where the fixed pressure stands.
    fixed: u32,
}

/// The memory of one worker that solves `B` samples side by side.
#[derive(Debug, Clone)]
pub struct StarMeshWorkspace<const B: usize> {
    /// Conductances by ray; once a star is eliminated, the weights of its mean.
    pub(crate) conductance: Vec<Lanes<B>>,
    pub(crate) ground: Vec<Lanes<B>>,
    /// Pressures by slot, Pa above the circuit's level; zero throughout a floating component.
    pub pressure: Vec<Lanes<B>>,
    /// For each pressure that some samples hold, one where it is held.
    held: Vec<Lanes<B>>,
}

impl<const B: usize> StarMeshWorkspace<B> {
    /// The pressures, and memory that is free until the next group is solved.
    pub fn pressure_and_spare(&mut self) -> (&[Lanes<B>], &mut [Lanes<B>]) {
        (&self.pressure, &mut self.conductance)
    }
}

/// The conductance of each vessel in a group of samples. A trait rather than a closure: a closure is not sure to be compiled into the
/// caller's instruction set.
pub(crate) trait Conductances<const B: usize> {
    /// Those of a vessel, given its conductance when open.
    fn of<S: Simd>(&self, simd: S, vessel: u32, open: f64) -> Lanes<B>;
}

/// The samples from `first` on, in which the vessels of `masks` are open.
pub(crate) struct Open<'a> {
    pub masks: &'a [u64],
    pub first: usize,
}

impl<const B: usize> Conductances<B> for Open<'_> {
    #[inline(always)]
    fn of<S: Simd>(&self, simd: S, vessel: u32, open: f64) -> Lanes<B> {
        masked(simd, &splat(simd, open), self.masks[vessel as usize], self.first)
    }
}

impl<const B: usize> Conductances<B> for [Lanes<B>] {
    #[inline(always)]
    fn of<S: Simd>(&self, _: S, vessel: u32, _: f64) -> Lanes<B> {
        self[vessel as usize]
    }
}

impl StarMesh {
    /// Orders and compiles the elimination; `None` when it would take more than `limit` mesh updates a sample.
    pub fn compile(circuit: &Circuit, limit: usize) -> Option<Self> {
        Self::of(circuit, |nodes, links| Elimination::compile(nodes, links, limit))
    }

    /// As [`StarMesh::compile`], but eliminates only nodes of at most `most` neighbours: [`StarMesh::solve`] is then not for it.
    pub(crate) fn compile_partly(circuit: &Circuit, most: usize) -> Option<Self> {
        Self::of(circuit, |nodes, links| Elimination::compile_partly(nodes, links, most))
    }

    fn of(circuit: &Circuit, compile: impl FnOnce(usize, &[[usize; 2]]) -> Option<Elimination>) -> Option<Self> {
        let free: Vec<usize> = (0..circuit.node_count()).filter(|n| circuit.fixed[*n].is_none()).collect();
        let mut index = vec![usize::MAX; circuit.node_count()];
        for (i, node) in free.iter().enumerate() {
            index[*node] = i;
        }
        let is_free = |node: usize| circuit.fixed[node].is_none();
        let links: Vec<[usize; 2]> =
            circuit.ends.iter().filter(|[a, b]| a != b && is_free(*a) && is_free(*b)).map(|e| e.map(|n| index[n])).collect();
        let program = compile(free.len(), &links)?;

        let mut slot = vec![NOWHERE; circuit.node_count()];
        // Outlets of one pressure share its place.
        let (mut fixed, mut place_of) = (Vec::new(), HashMap::new());
        for (node, slot) in slot.iter_mut().enumerate() {
            *slot = match circuit.fixed[node] {
                None => program.place(index[node]),
                Some(pressure) => *place_of.entry(pressure.to_bits()).or_insert_with(|| {
                    fixed.push(pressure);
                    (free.len() + fixed.len() - 1) as u32
                }),
            };
        }
        let (mut rays, mut grounds) = (Vec::new(), Vec::new());
        let mut bare = vec![true; program.rays()];
        let fixes = |row: usize| row.checked_sub(circuit.vessel_count()).is_some_and(|at| circuit.terminals[at].fixes);
        for (vessel, &[a, b]) in circuit.ends.iter().enumerate().filter(|(row, e)| e[0] != e[1] && !fixes(*row)) {
            let (vessel, conductance) = (vessel as u32, circuit.conductance[vessel]);
            match (circuit.fixed[a], circuit.fixed[b]) {
                (None, None) => {
                    let ray = program.ray_between(slot[a], slot[b]);
                    let first = std::mem::take(&mut bare[ray as usize]);
                    rays.push(RayStamp { vessel, ray, first, conductance });
                }
                (None, Some(_)) => grounds.push(GroundStamp { vessel, place: slot[a], conductance, fixed: slot[b] }),
                (Some(_), None) => grounds.push(GroundStamp { vessel, place: slot[b], conductance, fixed: slot[a] }),
                (Some(_), Some(_)) => {}
            }
        }
        let mut by_place = [vec![0.0; free.len()], vec![0.0; free.len()]];
        for node in free {
            by_place[0][slot[node] as usize] = circuit.shunt[node];
            by_place[1][slot[node] as usize] = circuit.source[node];
        }
        let [shunt, source] = by_place;
        let fill = (0..program.rays() as u32).filter(|ray| bare[*ray as usize]).collect();
        let holds = holds(circuit, &slot, &program);
        Some(Self { program, slot, rays, fill, grounds, shunt, source, fixed, holds })
    }

    /// The compiled elimination.
    pub(crate) fn program(&self) -> &Elimination {
        &self.program
    }

    /// Mesh updates of one sample: the length of the program.
    pub fn updates(&self) -> usize {
        self.program.joins()
    }

    /// How many conductances there are, fill included.
    pub fn rays(&self) -> usize {
        self.program.rays()
    }

    /// Where the pressure of a node stands in a workspace.
    pub fn slot(&self, node: usize) -> usize {
        self.slot[node] as usize
    }

    /// The memory for groups of `B` samples, with at least so many [`StarMeshWorkspace::pressure_and_spare`] places.
    pub fn workspace_with<const B: usize>(&self, spare: usize) -> StarMeshWorkspace<B> {
        let mut work = self.workspace();
        if spare > work.conductance.len() {
            work.conductance = vec![Lanes::ZERO; spare];
        }
        work
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

    /// Solves the samples `first .. first + B` of a block.
    ///
    /// Bit i of `masks[e]` says whether vessel e is open in sample i; `stranded` lists the nodes whose injected flow has
    /// nowhere to go, with the samples in which that is so.
    #[inline(always)]
    pub fn solve<S: Simd, const B: usize>(
        &self,
        simd: S,
        masks: &[u64],
        first: usize,
        stranded: &[(usize, u64)],
        work: &mut StarMeshWorkspace<B>,
    ) {
        self.assemble(simd, &Open { masks, first }, first, stranded, work);
        self.eliminate(simd, work);
        self.substitute_back(simd, work);
    }

    /// Solves a group of samples that differ in the conductances of their vessels (m³/(Pa s)), zero for a closed one,
    /// rather than in which are open; `stranded` as in [`StarMesh::solve`], for the first samples of a block.
    #[inline(always)]
    pub fn solve_with<S: Simd, const B: usize>(
        &self,
        simd: S,
        conductance: &[Lanes<B>],
        stranded: &[(usize, u64)],
        work: &mut StarMeshWorkspace<B>,
    ) {
        self.assemble(simd, conductance, 0, stranded, work);
        self.eliminate(simd, work);
        self.substitute_back(simd, work);
    }

    /// Conductances by ray, terminal conductances by place, and inflows in the place of the pressures.
    #[inline(always)]
    pub(crate) fn assemble<S: Simd, const B: usize>(
        &self,
        simd: S,
        conductances: &(impl Conductances<B> + ?Sized),
        first: usize,
        stranded: &[(usize, u64)],
        work: &mut StarMeshWorkspace<B>,
    ) {
        self.prepare(simd, first, stranded, work);
        for stamp in &self.rays {
            let own = conductances.of(simd, stamp.vessel, stamp.conductance);
            let c = &mut work.conductance[stamp.ray as usize];
            *c = if stamp.first { own } else { plus(simd, c, &own) };
        }
        for stamp in &self.grounds {
            let own = conductances.of(simd, stamp.vessel, stamp.conductance);
            let (place, pressure) = (stamp.place as usize, work.pressure[stamp.fixed as usize]);
            work.ground[place] = plus(simd, &work.ground[place], &own);
            work.pressure[place] = plus_product(simd, &work.pressure[place], &own, &pressure);
        }
        for (at, hold) in self.holds.iter().enumerate() {
            let held = conductances.of(simd, hold.terminal, 1.0);
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

    /// What no vessel contributes to.
    #[inline(always)]
    fn prepare<S: Simd, const B: usize>(
        &self,
        simd: S,
        first: usize,
        stranded: &[(usize, u64)],
        work: &mut StarMeshWorkspace<B>,
    ) {
        for ray in &self.fill {
            work.conductance[*ray as usize] = Lanes::ZERO;
        }
        for (place, (shunt, source)) in self.shunt.iter().zip(&self.source).enumerate() {
            work.ground[place] = splat(simd, *shunt);
            work.pressure[place] = splat(simd, *source);
        }
        for (node, samples) in stranded {
            let source = &mut work.pressure[self.slot[*node] as usize];
            *source = masked(simd, source, !samples, first);
        }
    }

    #[inline(always)]
    pub(crate) fn eliminate<S: Simd, const B: usize>(&self, simd: S, work: &mut StarMeshWorkspace<B>) {
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
    pub(crate) fn substitute_back<S: Simd, const B: usize>(&self, simd: S, work: &mut StarMeshWorkspace<B>) {
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
    let rows = (circuit.vessel_count()..).zip(&circuit.terminals);
    let fixing = rows.filter(|(row, terminal)| terminal.fixes && circuit.ends[*row][0] != circuit.ends[*row][1]);
    let fixing: Vec<(usize, usize)> = fixing.map(|(row, terminal)| (row, terminal.node)).filter(|(_, n)| is_free(*n)).collect();
    for (_, node) in &fixing {
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
    let mut hold = |(row, node): (usize, usize)| {
        let pressure = circuit.fixed[circuit.ends[row][1]]?;
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
pub(crate) fn inverse<S: Simd, const B: usize>(simd: S, total: &Lanes<B>) -> Lanes<B> {
    let [zero, one, least] = [0.0, 1.0, f64::MIN_POSITIVE].map(|x| simd.splat_f64s(x));
    map(simd, total, |t| simd.select_f64s(simd.greater_than_or_equal_f64s(t, least), simd.div_f64s(one, t), zero))
}
