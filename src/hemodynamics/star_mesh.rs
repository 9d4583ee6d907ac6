//! Star-mesh elimination of the grounded Laplacian, several samples at a time in SIMD lanes.
//!
//! Eliminating node k replaces the star of its conductances by the mesh c_ij += c_ki c_kj / S_k, S_k = Σ c_ki + g_k.
//! Nothing is ever subtracted, so pressures are accurate componentwise, however far the conductances are apart; a
//! floating component is a star with S_k = 0 and needs no test. The order of elimination and the fill are worked out
//! once per circuit and compiled to flat index lists.

mod order;

use super::circuit::Circuit;
use order::minimum_degree;

/// Samples solved side by side.
pub const LANES: usize = 8;

/// One figure for each sample of a group.
pub type Lanes = [f64; LANES];

const NONE: u32 = u32::MAX;

/// The compiled elimination of a circuit.
#[derive(Debug, Clone)]
pub struct StarMesh {
    /// Per node its place in the elimination order; `NONE` where the pressure is fixed.
    place: Vec<u32>,
    /// Per place where its star begins in `rays`; one more at the end.
    star: Vec<u32>,
    /// The later place at the other end of each ray of a star.
    rays: Vec<u32>,
    /// Per place where its mesh begins in `mesh`; one more at the end.
    mesh_start: Vec<u32>,
    /// The ray that each pair (i, j), i < j, of a star's rays adds to, pair by pair.
    mesh: Vec<u32>,
    /// Where each vessel's conductance goes.
    stamps: Vec<Stamp>,
    shunt: Vec<f64>,
    source: Vec<f64>,
    fixed: Vec<f64>,
}

/// Where a vessel's conductance goes in the elimination.
#[derive(Debug, Clone, Copy)]
enum Stamp {
    /// Between two free nodes: a ray.
    Ray { ray: u32, conductance: f64 },
    /// From a free node to one of fixed pressure.
    Ground { place: u32, conductance: f64, inflow: f64 },
    /// Between two fixed pressures, or a self-loop: nothing to solve.
    Nothing,
}

/// The memory of one worker.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    conductance: Vec<Lanes>,
    weight: Vec<Lanes>,
    ground: Vec<Lanes>,
    source: Vec<Lanes>,
    pressure: Vec<Lanes>,
}

impl StarMesh {
    /// Orders and compiles the elimination; `None` when it would take more than `limit` mesh updates a sample.
    pub fn compile(circuit: &Circuit, limit: usize) -> Option<Self> {
        let free: Vec<usize> = (0..circuit.node_count()).filter(|n| circuit.fixed[*n].is_none()).collect();
        let mut index = vec![usize::MAX; circuit.node_count()];
        for (i, node) in free.iter().enumerate() {
            index[*node] = i;
        }
        let is_ray = |ends: &[usize; 2]| ends[0] != ends[1] && ends.iter().all(|n| circuit.fixed[*n].is_none());
        let links = circuit.ends.iter().filter(|e| is_ray(e)).map(|e| [index[e[0]], index[e[1]]]);
        let stars = minimum_degree(free.len(), links, limit)?;

        let mut place = vec![NONE; circuit.node_count()];
        for (at, star) in stars.iter().enumerate() {
            place[free[star.center]] = at as u32;
        }
        let place_of = |i: usize| place[free[i]];
        let (mut star, mut rays) = (vec![0], Vec::new());
        for s in &stars {
            let mut to: Vec<u32> = s.neighbours.iter().map(|i| place_of(*i)).collect();
            to.sort_unstable();
            rays.extend(to);
            star.push(rays.len() as u32);
        }
        let ray_of = |a: u32, b: u32| {
            let (low, high) = (a.min(b), a.max(b));
            let (from, to) = (star[low as usize] as usize, star[low as usize + 1] as usize);
            from as u32 + rays[from..to].partition_point(|r| *r < high) as u32
        };
        let (mut mesh_start, mut mesh) = (vec![0], Vec::new());
        for s in star.windows(2) {
            let to = &rays[s[0] as usize..s[1] as usize];
            for (i, a) in to.iter().enumerate() {
                mesh.extend(to[i + 1..].iter().map(|b| ray_of(*a, *b)));
            }
            mesh_start.push(mesh.len() as u32);
        }
        let stamps = circuit.ends.iter().zip(&circuit.conductance).map(|(&[a, b], &conductance)| {
            match (circuit.fixed[a], circuit.fixed[b]) {
                (None, None) if a != b => Stamp::Ray { ray: ray_of(place[a], place[b]), conductance },
                (None, Some(p)) => Stamp::Ground { place: place[a], conductance, inflow: conductance * p },
                (Some(p), None) => Stamp::Ground { place: place[b], conductance, inflow: conductance * p },
                _ => Stamp::Nothing,
            }
        });
        let by_place = |values: &[f64]| stars.iter().map(|s| values[free[s.center]]).collect();
        Some(Self {
            stamps: stamps.collect(),
            shunt: by_place(&circuit.shunt),
            source: by_place(&circuit.source),
            fixed: circuit.fixed.iter().map(|p| p.unwrap_or(0.0)).collect(),
            place,
            star,
            rays,
            mesh_start,
            mesh,
        })
    }

    /// Mesh updates of one sample: the length of the program.
    pub fn updates(&self) -> usize {
        self.mesh.len()
    }

    /// Solves a group of samples.
    ///
    /// Bit `lane` of `present[e]` says whether vessel e is open in that lane; `stranded` lists the nodes whose injected
    /// flow has nowhere to go, with the lanes in which that is so. Writes the pressure of every node, Pa above the
    /// circuit's level; zero throughout a floating component.
    pub fn solve(&self, present: &[u8], stranded: &[(usize, u8)], work: &mut Workspace, pressure: &mut Vec<Lanes>) {
        work.conductance.clear();
        work.conductance.resize(self.rays.len(), [0.0; LANES]);
        work.weight.resize(self.rays.len(), [0.0; LANES]);
        work.ground.clear();
        work.ground.extend(self.shunt.iter().map(|g| [*g; LANES]));
        work.source.clear();
        work.source.extend(self.source.iter().map(|s| [*s; LANES]));
        for (node, lanes) in stranded {
            if let Some(source) = work.source.get_mut(self.place[*node] as usize) {
                for (lane, s) in source.iter_mut().enumerate() {
                    *s = if lanes >> lane & 1 == 1 { 0.0 } else { *s };
                }
            }
        }
        for (stamp, present) in self.stamps.iter().zip(present) {
            match *stamp {
                Stamp::Ray { ray, conductance } => add(&mut work.conductance[ray as usize], open(*present, conductance)),
                Stamp::Ground { place, conductance, inflow } => {
                    add(&mut work.ground[place as usize], open(*present, conductance));
                    add(&mut work.source[place as usize], open(*present, inflow));
                }
                Stamp::Nothing => {}
            }
        }
        self.eliminate(work);
        self.substitute_back(work);
        pressure.clear();
        pressure.extend(self.place.iter().zip(&self.fixed).map(|(place, fixed)| match work.pressure.get(*place as usize) {
            Some(p) => *p,
            None => [*fixed; LANES],
        }));
    }

    fn eliminate(&self, work: &mut Workspace) {
        work.pressure.clear();
        for k in 0..self.star.len() - 1 {
            let (from, to) = (self.star[k] as usize, self.star[k + 1] as usize);
            let (ground, source) = (work.ground[k], work.source[k]);
            let mut total = ground;
            for c in &work.conductance[from..to] {
                add(&mut total, |lane| c[lane]);
            }
            for s in &mut total {
                *s = if *s > 0.0 { *s } else { 1.0 };
            }
            let mut updates = self.mesh[self.mesh_start[k] as usize..self.mesh_start[k + 1] as usize].iter();
            for ray in from..to {
                let mut weight = work.conductance[ray];
                for lane in 0..LANES {
                    weight[lane] /= total[lane];
                }
                work.weight[ray] = weight;
                let i = self.rays[ray] as usize;
                add(&mut work.ground[i], |lane| weight[lane] * ground[lane]);
                add(&mut work.source[i], |lane| weight[lane] * source[lane]);
                for other in ray + 1..to {
                    let Some(target) = updates.next() else { break };
                    let c = work.conductance[other];
                    add(&mut work.conductance[*target as usize], |lane| weight[lane] * c[lane]);
                }
            }
            let mut p = source;
            for lane in 0..LANES {
                p[lane] /= total[lane];
            }
            work.pressure.push(p);
        }
    }

    fn substitute_back(&self, work: &mut Workspace) {
        for k in (0..self.star.len() - 1).rev() {
            let mut p = work.pressure[k];
            for ray in self.star[k] as usize..self.star[k + 1] as usize {
                let (weight, far) = (work.weight[ray], work.pressure[self.rays[ray] as usize]);
                add(&mut p, |lane| weight[lane] * far[lane]);
            }
            work.pressure[k] = p;
        }
    }
}

/// `value` in the lanes where the vessel is open, zero elsewhere, without a branch.
#[expect(clippy::inline_always, reason = "the innermost lane loops; a call would keep them scalar")]
#[inline(always)]
fn open(present: u8, value: f64) -> impl Fn(usize) -> f64 {
    move |lane| f64::from_bits(value.to_bits() & u64::from(present >> lane & 1).wrapping_neg())
}

#[expect(clippy::inline_always, reason = "the innermost lane loops; a call would keep them scalar")]
#[inline(always)]
fn add(sum: &mut Lanes, term: impl Fn(usize) -> f64) {
    for (lane, s) in sum.iter_mut().enumerate() {
        *s += term(lane);
    }
}
